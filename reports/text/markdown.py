"""Pieces of Markdown that stay one line in a diff."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.text.numerals import significant

if TYPE_CHECKING:
    from collections.abc import Iterable

    from reports.chapters.crossval.summary import Cell

SPECIAL = str.maketrans({c: "\\" + c for c in "\\|`*_[]<>"})


def escape_text(value: object) -> str:
    """Text on one line that Markdown takes literally."""
    return " ".join(str(value).split()).translate(SPECIAL)


def table_row(values: Iterable[object]) -> str:
    """One row of a table; None is an empty cell, floats get three significant digits."""
    shown = (significant(v) if isinstance(v, float) else "" if v is None else escape_text(v) for v in values)
    return "| " + " | ".join(shown) + " |"


def cell_text(cell: Cell | None, horizon: str = "") -> str:
    """One cell of the matrix: outcome, errors, horizon."""
    if cell is None:
        return "not run"
    errors = [f"{'CM ' * (r.quantity == 'com')}{significant(cell.shown_value(r))} {r.unit}" for r in cell.shown]
    limit = cell.detection_limit
    detects = [] if limit is None else [f"detects {significant(limit)}"]
    return "; ".join([cell.word, *errors, *detects, *([horizon] if horizon else [])])
