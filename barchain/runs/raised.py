"""Words on an exception that an engine raised: its type, its text, and the line of code."""

from __future__ import annotations

import traceback
from typing import TYPE_CHECKING

from barchain.runs.message import plain_text

if TYPE_CHECKING:
    from types import FrameType

CALLERS = {"barchain", "contextlib"}
"""Top-level packages that call an engine's code"""
IMPORTER = "importlib"
BASE = "adapters.engine"
"""Module of the class that every engine inherits; it calls the engine's methods"""


def exception_words(error: BaseException) -> str:
    """Type and text of an exception, and the last line of the engine's own code that its traceback names.

    The line where the exception was raised follows if it lies in another package, e.g. in NumPy.
    """
    return f"{type(error).__name__}: {plain_text(error)}{place_words(error)}"


def place_words(error: BaseException) -> str:
    """Place of an exception, in parentheses after a space; empty if no code but barchain's was running."""
    frames = [pair for pair in traceback.walk_tb(error.__traceback__) if package(pair[0]) != IMPORTER]
    outside = [k for k, (frame, _) in enumerate(frames) if package(frame) not in CALLERS and module(frame) != BASE]
    if not outside:
        return ""
    engine = package(frames[outside[0]][0])
    own = max(k for k in outside if package(frames[k][0]) == engine)
    places = [line(*frames[own])]
    if own < len(frames) - 1:
        places.append(f"raised in {line(*frames[-1])}")
    return f" ({', '.join(places)})"


def package(frame: FrameType) -> str:
    """Top-level package of a frame's code."""
    return module(frame).partition(".")[0]


def module(frame: FrameType) -> str:
    """Name of a frame's module."""
    return str(frame.f_globals.get("__name__", "?"))


def line(frame: FrameType, number: int) -> str:
    """Module, line and function of a frame."""
    return plain_text(f"{module(frame)}:{number} in {frame.f_code.co_name}", 200)
