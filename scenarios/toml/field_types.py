"""Types and values of the fields of a scene that was made in Python, against those of the file that it stands for."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any

from scenarios.text import shorten

if TYPE_CHECKING:
    from collections.abc import Iterator


ROUNDED = 1e-9
"""Relative difference of an angle in degrees"""
INSTANTS = {"times_s", "at_s", "start_s", "duration_s"}
"""Fields that a file moves to a sample beside them: engines of equal steps would take the two apart"""
SAME = 1e-15
"""Relative difference of such instants: a sum of two of them is rounded"""
TINY = 1e-12
"""Difference of such numbers beside zero"""


def is_number(value: Any) -> bool:
    """Whether a value is a number; True and False are none."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def type_faults(given: Any, found: Any, where: str = "") -> Iterator[str]:
    """Fields that are not of the type and value that a file gives them, one line each.

    A list or a text works in part only. A value that follows from others, as a third body's rate, is none of its own.
    """
    if is_number(found) and is_number(given):
        name = where.rpartition(".")[2].partition("[")[0]
        if not math.isclose(given, found, rel_tol=SAME if name in INSTANTS else ROUNDED, abs_tol=TINY):
            why = "the sample beside it" if name in INSTANTS else "which follows from the other values"
            yield f"{where}: {shorten(given)} given, allowed: {found!r}, {why}"
        return
    if type(given) is not type(found):
        yield f"{where}: {shorten(given)} given, allowed: of type {type(found).__name__}"
    elif dataclasses.is_dataclass(found):
        for field in dataclasses.fields(found):
            name = f"{where}.{field.name}" if where else field.name
            yield from type_faults(getattr(given, field.name), getattr(found, field.name), name)
    elif isinstance(found, tuple):
        for number, (one, other) in enumerate(zip(given, found, strict=True)):
            yield from type_faults(one, other, f"{where}[{number}]")
