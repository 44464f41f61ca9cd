"""Declarations of an engine: their types, the values that a comparison can work with, and their form in messages."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from adapters.engine import AccuracyParameter, AccuracySweep, Coordinates
from adapters.trajectory import Observable
from barchain.runs.message import plain_text

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from adapters.engine import Engine

HIGHEST_ORDER = 40.0
"""Taylor series in double precision have about half of it"""
LARGEST_STEP_CONSTANT = 10.0
NAME_LENGTH = 60


class DeclarationError(TypeError):
    """A declaration of an engine that is missing, of a wrong type or out of range; the message names it."""


@dataclass(frozen=True)
class Declaration:
    """One declaration of engines."""

    types: tuple[type, ...]
    plain: Callable[[Any], Any]
    """Form in a message"""
    meant: Callable[[Any], Any]
    """Value of that form; raises for another form, as the message may come from a process gone astray"""
    check: Callable[[Any], object] = bool
    """Raises for a value out of range"""


def declared(engine: type[Engine], name: str) -> Any:
    """Value of a declaration.

    Raises
    ------
    DeclarationError
        If it is missing, of another type than :data:`DECLARED` says, or out of range.
    """
    if not hasattr(engine, name):
        raise DeclarationError(f"it does not declare {name}")
    value, types = getattr(engine, name), DECLARED[name].types
    if not isinstance(value, types) or (isinstance(value, bool) and bool not in types):
        wanted = " or ".join("None" if t is type(None) else t.__name__ for t in types)
        raise DeclarationError(f"{name} is a {type(value).__name__}, expected {wanted}")
    DECLARED[name].check(value)
    return value


def check_order(order: float | None) -> None:
    """Check the range of an order."""
    if order is not None and not 1.0 <= order <= HIGHEST_ORDER:
        raise DeclarationError(f"order is {order:g}, allowed: 1 to {HIGHEST_ORDER:g}, or None")


def check_step_constant(constant: float) -> None:
    """Check the range of a step constant."""
    if not 0.0 < constant <= LARGEST_STEP_CONSTANT:
        raise DeclarationError(
            f"step_constant is {constant:g}, allowed: greater than 0, at most {LARGEST_STEP_CONSTANT:g}"
        )


def check_sweep(sweep: AccuracySweep) -> None:
    """Check that settings go from coarse to fine."""
    values = [float(v) for v in sweep.values]
    coarse_first = sorted(values, reverse=AccuracyParameter(sweep.parameter) is AccuracyParameter.RTOL)
    if not values or values != coarse_first:
        raise DeclarationError(f"sweep.values are not sorted from coarse to fine: {plain_text(values, 120)}")
    if len(set(values)) < len(values):
        raise DeclarationError(f"sweep.values repeat a value: {plain_text(values, 120)}")
    if not all(math.isfinite(v) and v > 0.0 for v in (*values, float(sweep.default))):
        raise DeclarationError("sweep holds a value that is not positive and finite")
    if not 0.0 < float(sweep.finer_rtol) < 1.0:
        raise DeclarationError(
            f"sweep.finer_rtol is {float(sweep.finer_rtol):g}, allowed: between 0 and 1, the requested error of the "
            "finer run over that of the run itself"
        )


def plain_sweep(sweep: AccuracySweep) -> dict[str, Any]:
    """Sweep as a message has it."""
    return {
        "parameter": str(sweep.parameter), "values": [float(v) for v in sweep.values], "default": float(sweep.default),
        "finer_rtol": float(sweep.finer_rtol),
    }  # fmt: skip


def meant_sweep(said: dict[str, Any]) -> AccuracySweep:
    """Sweep of a message."""
    values = tuple(float(v) for v in said["values"])
    return AccuracySweep(
        AccuracyParameter(said["parameter"]), values, float(said["default"]), float(said["finer_rtol"])
    )


def number_or_none(value: Any) -> float | None:
    """Number as a float."""
    return None if value is None else float(value)


def plain_names(names: Iterable[object]) -> list[str]:
    """Names, sorted."""
    return sorted(plain_text(name, NAME_LENGTH) for name in names)


def meant_names(names: Iterable[object]) -> frozenset[str]:
    """Names of a message."""
    return frozenset(map(str, names))


def observables(names: Iterable[str]) -> frozenset[Observable]:
    """Quantities; one that is unknown raises."""
    return frozenset(map(Observable, names))


def plain_reasons(reasons: dict[str, str]) -> dict[str, str]:
    """Reasons by their names."""
    return {plain_text(name, NAME_LENGTH): plain_text(reason) for name, reason in reasons.items()}


NAMES = Declaration((frozenset, set), plain_names, meant_names)
SWITCH = Declaration((bool,), bool, bool)
DECLARED: dict[str, Declaration] = {
    "title": Declaration((str,), lambda title: plain_text(title, 200), str),
    "coordinates": Declaration((str,), str, Coordinates, Coordinates),
    "order": Declaration((float, int, type(None)), number_or_none, number_or_none, check_order),
    "sweep": Declaration((AccuracySweep,), plain_sweep, meant_sweep, check_sweep),
    "effects": NAMES,
    "observables": Declaration((frozenset, set), plain_names, observables, observables),
    "options": NAMES,
    "joints_in_place": SWITCH,
    "track_by_length": SWITCH,
    "step_constant": Declaration((float, int), float, float, check_step_constant),
    "unsupported_reasons": Declaration((dict,), plain_reasons, plain_reasons),
}
"""Declarations of an engine"""
