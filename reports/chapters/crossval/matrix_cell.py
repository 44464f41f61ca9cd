"""Cells of the matrix as text."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.text.numerals import significant

if TYPE_CHECKING:
    from reports.chapters.crossval.summary import RunCell


def cell_text(cell: RunCell | None, predictability_limit: str = "") -> str:
    """Text of one cell: outcome, errors, detection limit, compared duration."""
    if cell is None:
        return "not run"
    errors = [f"{'CM ' * (r.quantity == 'com')}{significant(cell.shown_value(r))} {r.unit}" for r in cell.shown]
    limit = cell.detection_limit
    detects = [] if limit is None else [f"detects {significant(limit)}"]
    return "; ".join([cell.word, *errors, *detects, *([predictability_limit] if predictability_limit else [])])
