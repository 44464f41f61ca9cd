"""Matrix of scenes and engines: columns by kind of engine, and cells as text."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from reports.tables.cost import INDEPENDENT, KINDS, OWN_EQUATIONS
from reports.text.numerals import significant

if TYPE_CHECKING:
    from reports.chapters.crossval.summary import RunCell, Summary
    from reports.text.record import SceneRecord

DIGITS_A_SHADE = 2
DIGIT_WORDS = ("0–2", "2–4", "4–6", "6–8", "8–10", "10–12", "12+")
"""Digits of each shade"""
MOST_DIGITS = 16.0
"""Of double precision"""
FEW_COLUMNS = 12
"""Columns up to which a laptop's window shows all kinds of engines side by side"""


@dataclass(frozen=True)
class EngineGroup:
    """Columns of one kind of engine."""

    key: str
    """Name in ids and classes"""
    heading: str
    engines: tuple[str, ...]
    passed: int
    compared: int
    """Comparisons that passed or failed"""
    unfolded: bool = True
    """Whether the columns are shown at first"""

    @property
    def words(self) -> str:
        """``8 engines, 101 of 101 passed``."""
        plural = "" if len(self.engines) == 1 else "s"
        compared = f"{self.passed} of {self.compared} passed" if self.compared else "nothing compared"
        return f"{len(self.engines)} engine{plural}, {compared}"


def engine_groups(summary: Summary) -> list[EngineGroup]:
    """Engines by kind, independent physics first; one group where the record does not tell the kinds apart."""
    if not summary.outside_known:
        return [engine_group(summary, "engines", "Engines", summary.engines, foldable=False)]
    own = tuple(e for e in summary.engines if not summary.external(e))
    outside = tuple(e for e in summary.engines if summary.external(e))
    many = bool(outside) and len(summary.engines) > FEW_COLUMNS
    groups = (("independent", INDEPENDENT, outside, False), ("own", OWN_EQUATIONS, own, many))
    return [engine_group(summary, key, KINDS[kind], names, foldable=fold) for key, kind, names, fold in groups if names]


def engine_group(summary: Summary, key: str, heading: str, engines: tuple[str, ...], *, foldable: bool) -> EngineGroup:
    """Group of some engines; one with a failure is never folded at first."""
    judged = [c for c in summary.all if c.engine in engines and c.outcome.judged]
    failed = sum(not c.outcome.ok for c in judged)
    return EngineGroup(key, heading, engines, len(judged) - failed, len(judged), bool(failed) or not foldable)


def digits(cell: RunCell, scene: SceneRecord) -> float | None:
    """Digits of accuracy of a comparison that may stand: of the attitude in rad, of a track relative to its radius."""
    row = next(iter(cell.shown), None)
    size = {"attitude": 1.0, "com": scene.value("radius0_m")}.get(row.quantity) if row else None
    error = None if row is None else cell.shown_value(row)
    if not cell.outcome.ok or not size or error is None or not math.isfinite(error):
        return None
    return min(max(0.0, -math.log10(error / size)), MOST_DIGITS) if error > 0.0 else MOST_DIGITS


def shade(count: float) -> int:
    """Index of the shade of a number of digits."""
    return min(int(count / DIGITS_A_SHADE), len(DIGIT_WORDS) - 1)


def cell_text(cell: RunCell | None, predictability_limit: str = "") -> str:
    """Text of one cell: outcome, errors, detection limit, compared duration."""
    if cell is None:
        return "not run"
    errors = [f"{'CM ' * (r.quantity == 'com')}{significant(cell.shown_value(r))} {r.unit}" for r in cell.shown]
    limit = cell.detection_limit
    detects = [] if limit is None else [f"detects {significant(limit)}"]
    return "; ".join([cell.word, *errors, *detects, *([predictability_limit] if predictability_limit else [])])
