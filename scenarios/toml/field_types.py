"""Types of the fields of a scene that was made in Python."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

from scenarios.text import shorten

if TYPE_CHECKING:
    from collections.abc import Iterator


def type_faults(given: Any, found: Any, where: str = "") -> Iterator[str]:
    """Fields that are not of the type that a file gives them, one line each: a list or a text works in part only."""
    if isinstance(found, int | float) and isinstance(given, int | float):
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
