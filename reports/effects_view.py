"""What the page and the console show of an effect budget."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.effects_advice import Advice, Worth, advise, headline
from reports.effects_charts import effect_charts
from reports.effects_rows import rows_of, whole_of
from reports.effects_tables import QUANTITIES, SIZES, has_effects, read_effects
from reports.effects_words import brief, times
from reports.numerals import significant
from reports.record import mapping

if TYPE_CHECKING:
    from pathlib import Path

    from reports.charts import Panel
    from reports.effects_rows import EffectRow, Whole

HEADINGS = (
    "effect", "in the scene", "worth", "moves CM", "turns bars", "changes reactions", "time with / without",
    "one evaluation", "evaluations", "between bars / tide", "torque / 3n²J", "common / g",
)  # fmt: skip
WORDY = 3  # columns of words, at the left


@dataclass(frozen=True)
class EffectsView:
    """The chapter."""

    record: dict[str, Any]
    whole: Whole
    advice: tuple[Advice, ...]
    """One for each effect, what matters first"""
    table: tuple[tuple[str, ...], ...]
    """One row for each effect, in the order of :data:`HEADINGS`"""
    charts: tuple[Panel, ...]

    headings, wordy = HEADINGS, WORDY

    @property
    def finished(self) -> bool:
        """Whether the budget went to its end."""
        return bool(self.record.get("finished"))

    @property
    def scene(self) -> dict[str, Any]:
        """What is known of the scene."""
        return mapping(self.record.get("scene"))

    @property
    def assumed(self) -> tuple[tuple[str, str], ...]:
        """What was assumed of effects that the scene does not have."""
        off = (a.row for a in self.advice if not a.row.on and not a.row.model)
        return tuple((row.title, row.said) for row in off if row.said)

    @property
    def headline(self) -> str:
        """What matters, and what one may do without."""
        return headline(self.advice, self.whole.gravity)

    @property
    def horizon(self) -> str:
        """Until when the scene as it is can be compared with itself; empty where that is the whole run."""
        short = 0.0 < self.whole.horizon_s < min(self.whole.end_s, self.whole.duration_s)
        return times(self.whole.horizon_s, self.whole) if short else ""


def view_effects(folder: Path) -> EffectsView | None:
    """Effect budget of a result folder; None if it holds none."""
    if not has_effects(folder):
        return None
    tables = read_effects(folder)
    whole = whole_of(tables.record)
    rows = rows_of(tables, whole)
    advice = [advise(row, whole) for row in rows]
    order = list(Worth)
    return EffectsView(
        tables.record,
        whole,
        tuple(sorted(advice, key=lambda a: order.index(a.worth))),
        tuple(cells(a) for a in advice),
        tuple(effect_charts(rows, whole)),
    )


def cells(advice: Advice) -> tuple[str, ...]:
    """Row of the table."""
    row = advice.row
    if advice.worth is Worth.NOT_SWITCHED:
        return (row.title, row.state, f"{advice.worth}: {row.reason}", *[""] * (len(HEADINGS) - WORDY))
    changed = (row.change(q) for q in QUANTITIES)
    return (
        row.title,
        row.state,
        str(advice.worth),
        *("" if c is None else brief(c) for c in changed),
        time_text(row),
        *(ratio_text(r) for r in (row.evaluation_ratio, row.evaluations_ratio)),
        *(size_text(*row.sizes[name]) for name in SIZES),
    )


def size_text(start: float | None, largest: float | None) -> str:
    """Size at the start; and over the run, where it gets larger than its first two digits tell."""
    if start is None or largest is None:
        return ""
    first, most = significant(start, 2), significant(largest, 2)
    return first if first == most else f"{first} (to {most})"


def time_text(row: EffectRow) -> str:
    """``1.62 (1.58–1.70)``."""
    if row.time_ratio is None:
        return ""
    if row.time_low is None or row.time_high is None:
        return f"{row.time_ratio:.2f}"
    return f"{row.time_ratio:.2f} ({row.time_low:.2f}\N{EN DASH}{row.time_high:.2f})"


def ratio_text(ratio: float | None) -> str:
    """``1.62``."""
    return "" if ratio is None else f"{ratio:.2f}"
