"""Markdown text and table rows, each on one line."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.text.numerals import significant
from reports.text.visible import visible

if TYPE_CHECKING:
    from collections.abc import Iterable

SPECIAL = str.maketrans({c: "\\" + c for c in "\\|`*_[]<>&"})


def escape_text(value: object) -> str:
    """Literal Markdown text on one line."""
    return visible(" ".join(str(value).split())).translate(SPECIAL)


def table_row(values: Iterable[object]) -> str:
    """One row of a table; None is an empty cell, floats get three significant digits."""
    shown = (significant(v) if isinstance(v, float) else "" if v is None else escape_text(v) for v in values)
    return "| " + " | ".join(shown) + " |"
