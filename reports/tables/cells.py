r"""Cells of text in CSV tables: a spreadsheet must not take one for a formula.

A cell of text that begins with ``=``, ``+``, ``-``, ``@``, a tab or a carriage return gets an apostrophe in front, the
spreadsheets' mark of text. Numbers stay as they are. Readers of these tables remove the apostrophe again: text reads
back as written, also text that begins with apostrophes.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable

    import pandas as pd

FORMULA = re.compile(r"'*[=+\-@\t\r]")
MARKED = re.compile(r"'+[=+\-@\t\r]")
NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[+-]?(?:inf|nan)")


def as_cell(value: Any) -> Any:
    """Cell of a value; text that a spreadsheet would take as a formula is marked as text."""
    if isinstance(value, str) and FORMULA.match(value) and not NUMBER.fullmatch(value):
        return f"'{value}"
    return value


def from_cell(value: Any) -> Any:
    """Value of a cell that :func:`as_cell` made."""
    return value[1:] if isinstance(value, str) and MARKED.match(value) else value


def to_cells(frame: pd.DataFrame) -> pd.DataFrame:
    """Table whose cells of text are no formulas; columns of numbers are not looked at."""
    return mapped(frame, as_cell)


def from_cells(frame: pd.DataFrame) -> pd.DataFrame:
    """Table that :func:`to_cells` made, with its text as it was."""
    return mapped(frame, from_cell)


def mapped(frame: pd.DataFrame, change: Callable[[Any], Any]) -> pd.DataFrame:
    """Table whose cells in columns of objects or text are changed."""
    words = frame.select_dtypes(include=["object", "string"])
    return frame.assign(**{str(name): words[name].map(change).astype(words[name].dtype) for name in words})
