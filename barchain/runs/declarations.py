"""Declarations of an engine: their types, and the values that a comparison can work with."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from adapters.engine import AccuracyParameter, AccuracySweep, Coordinates
from adapters.trajectory import Observable
from barchain.runs.message import plain_text

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.engine import Engine

DECLARED: dict[str, tuple[type, ...]] = {
    "title": (str,), "coordinates": (str,), "order": (float, int, type(None)), "sweep": (AccuracySweep,),
    "effects": (frozenset, set), "observables": (frozenset, set), "options": (frozenset, set),
    "joints_in_place": (bool,), "track_by_length": (bool,), "step_constant": (float, int),
    "unsupported_reasons": (dict,),
}  # fmt: skip
"""Declarations of an engine, with their types"""
HIGHEST_ORDER = 40.0
"""Taylor series in double precision have about half of it"""
LARGEST_STEP_CONSTANT = 10.0


class DeclarationError(TypeError):
    """A declaration of an engine that is missing, of a wrong type or out of range; the message names it."""


def declared(engine: type[Engine], name: str) -> Any:
    """Value of a declaration.

    Raises
    ------
    DeclarationError
        If it is missing, of another type than :data:`DECLARED` says, or out of range.
    """
    if not hasattr(engine, name):
        raise DeclarationError(f"it does not declare {name}")
    value, types = getattr(engine, name), DECLARED[name]
    if not isinstance(value, types) or (isinstance(value, bool) and bool not in types):
        wanted = " or ".join("None" if t is type(None) else t.__name__ for t in types)
        raise DeclarationError(f"{name} is a {type(value).__name__}, expected {wanted}")
    if name in CHECKS:
        CHECKS[name](value)
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


def check_observables(observables: frozenset[str]) -> None:
    """Check that each quantity is known."""
    for each in observables:
        Observable(each)


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


CHECKS: dict[str, Callable[[Any], object]] = {
    "coordinates": Coordinates,
    "order": check_order,
    "observables": check_observables,
    "step_constant": check_step_constant,
    "sweep": check_sweep,
}
"""Checks of a declaration's value, by name"""
