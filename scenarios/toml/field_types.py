"""Types and values of the fields of a scene that was made in Python, against those of the file that it stands for."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from scenarios.text import shorten

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


ROUNDED = 1e-9
"""Relative difference of an angle in degrees"""
INSTANTS = {"times_s", "at_s", "start_s", "duration_s"}
"""Fields that a file moves to a sample beside them: engines of equal steps would take the two apart"""
REMEDY = "change_scene computes it"
SAME = 1e-15
"""Relative difference of such instants: a sum of two of them is rounded"""
TINY = 1e-12
"""Difference of such numbers beside zero"""


def without_numpy(tables: Any) -> Any:
    """Tables with lists and numbers of Python in place of NumPy's, at every depth."""
    if isinstance(tables, np.ndarray):
        return without_numpy(tables.tolist())
    if isinstance(tables, np.generic):
        return tables.item()
    if isinstance(tables, Mapping):
        return {key: without_numpy(value) for key, value in tables.items()}
    if isinstance(tables, list | tuple):
        return [without_numpy(value) for value in tables]
    return tables


def with_plain_numbers(part: Any) -> Any:
    """A scene, or a part of one, with numbers of Python in place of NumPy's; the same object where there are none."""
    return changed_leaves(part, part, lambda one, _: one.item() if isinstance(one, np.generic) else one)


def with_types_of(part: Any, found: Any) -> Any:
    """A scene, or a part of one, whose numbers are whole or not as those of `found`, which has the same shape."""
    return changed_leaves(
        part,
        found,
        lambda one, other: type(other)(one) if is_number(one) and is_number(other) else one,
    )


def changed_leaves(part: Any, beside: Any, change: Callable[[Any, Any], Any]) -> Any:
    """A part of a scene after a change of each value, which also sees the value at its place in `beside`."""
    if isinstance(part, tuple):
        values = tuple(changed_leaves(one, other, change) for one, other in zip(part, beside, strict=True))
        return values if any(new is not old for new, old in zip(values, part, strict=True)) else part
    if dataclasses.is_dataclass(part) and not isinstance(part, type):
        changes = {}
        for field in dataclasses.fields(part):
            old = getattr(part, field.name)
            new = changed_leaves(old, getattr(beside, field.name), change)
            if new is not old:
                changes[field.name] = new
        return dataclasses.replace(part, **changes) if changes else part
    return change(part, beside)


def is_number(value: Any) -> bool:
    """Whether a value is a number; True and False are none."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def type_faults(given: Any, found: Any, where: str = "") -> Iterator[str]:
    """Fields that are not of the type and value that a file gives them, one line each.

    A list or a text works in part only. A value that follows from others, as a third body's rate, is none of its own.
    """
    if is_number(found) and is_number(given):
        name = where.rpartition(".")[2].partition("[")[0]
        of_effect = name in INSTANTS and where.startswith("effects.")
        if not math.isclose(given, found, rel_tol=SAME if of_effect else ROUNDED, abs_tol=TINY):
            beside = of_effect and math.isclose(given, found, rel_tol=ROUNDED)
            why = "the sample beside it" if beside else f"which follows from the other values ({REMEDY})"
            yield f"{where}: {shorten(given)} given, allowed: {found!r}, {why}"
        return
    if type(given) is not type(found):
        yield f"{where}: {shorten(given)} given, allowed: of type {type(found).__name__}"
    elif dataclasses.is_dataclass(found):
        for field in (f for f in dataclasses.fields(found) if f.compare):
            name = f"{where}.{field.name}" if where else field.name
            yield from type_faults(getattr(given, field.name), getattr(found, field.name), name)
    elif isinstance(found, tuple):
        for number, (one, other) in enumerate(zip(given, found, strict=True), start=1):
            yield from type_faults(one, other, f"{where}[{number}]")
