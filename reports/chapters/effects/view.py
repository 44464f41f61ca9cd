"""What the page and the console show of an effect budget."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.chapters.effects.advice import Advice, Relevance, advise, headline
from reports.chapters.effects.charts import effect_charts
from reports.chapters.effects.rows import rows_of, whole_of
from reports.chapters.effects.words import brief, times
from reports.tables.effects import QUANTITIES, SIZES, read_effects
from reports.text.numerals import significant
from reports.text.record import mapping

if TYPE_CHECKING:
    from pathlib import Path

    from reports.chapters.effects.rows import BudgetScope, EffectRow, Ratio
    from reports.plotting.panels import Legend, Panel

WORDY = 3  # columns of words, at the left of the consequences; one elsewhere


@dataclass(frozen=True)
class BudgetTable:
    """One of the chapter's tables: a row for each effect."""

    title: str
    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    wordy: int = 1
    """Columns of words, at the left"""


@dataclass(frozen=True)
class EffectsView:
    """The chapter."""

    record: dict[str, Any]
    whole: BudgetScope
    advice: tuple[Advice, ...]
    """One for each effect, what matters first"""
    consequences: BudgetTable
    price: BudgetTable
    size: BudgetTable
    charts: tuple[Panel, ...]
    legend: tuple[Legend, ...]
    """Of all charts"""

    @property
    def tables(self) -> tuple[BudgetTable, ...]:
        """All of them."""
        return self.consequences, self.price, self.size

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
        return headline(self.advice, self.whole)

    @property
    def predictability_limit(self) -> str:
        """Until when the scene as it is can be compared with itself; empty where that is the whole run."""
        short = 0.0 < self.whole.limit_s < min(self.whole.end_s, self.whole.duration_s)
        return times(self.whole.limit_s, self.whole) if short else ""

    @property
    def timing(self) -> str:
        """How the price was measured, and how a better one is had; empty before it was."""
        whole = self.whole
        if not whole.rounds:
            return ""
        over = "" if whole.timed_s >= whole.duration_s else f" over the first {times(whole.timed_s, whole)}"
        rounds = "round" if whole.rounds == 1 else "rounds"
        return f"Timed in {whole.rounds} {rounds}{over}; more --minutes, and more --repeats, narrow the intervals."


def view_effects(folder: Path) -> EffectsView:
    """View of the study in a result folder."""
    tables = read_effects(folder)
    whole = whole_of(tables.record)
    rows = rows_of(tables, whole)
    advice = [advise(row, whole) for row in rows]
    order, switched = list(Relevance), [a.row for a in advice if a.worth is not Relevance.NOT_SWITCHED]
    return EffectsView(
        tables.record,
        whole,
        tuple(sorted(advice, key=lambda a: order.index(a.worth))),
        BudgetTable(
            "What each changes",
            ("effect", "in the scene", "worth", "moves CM", "turns bars", "changes reactions"),
            tuple(map(consequence_cells, advice)),
            WORDY,
        ),
        BudgetTable(
            "What each costs, times as much",
            ("effect", "run", "one evaluation", "evaluations", "the rest"),
            tuple(map(price_cells, switched)),
        ),
        BudgetTable(
            "How large each is",
            ("effect", "between bars / tide", "torque / 3n²J", "common / g"),
            tuple(map(size_cells, switched)),
        ),
        *effect_charts(rows, whole),
    )


def consequence_cells(advice: Advice) -> tuple[str, ...]:
    """Row of what an effect changes."""
    row = advice.row
    if advice.worth is Relevance.NOT_SWITCHED:
        return (row.title, row.state, f"{advice.worth}: {row.reason}", *[""] * len(QUANTITIES))
    changed = (row.change(q) for q in QUANTITIES)
    return (row.title, row.state, str(advice.worth), *("" if c is None else brief(c) for c in changed))


def price_cells(row: EffectRow) -> tuple[str, ...]:
    """Row of what an effect costs."""
    count, rest = ("" if r is None else ratio_text(r) for r in (row.evaluations_ratio, row.rest))
    return (row.title, interval_text(row.time), interval_text(row.evaluation), count, rest)


def size_cells(row: EffectRow) -> tuple[str, ...]:
    """Row of how large an effect is."""
    return (row.title, *(size_text(*row.sizes[name]) for name in SIZES))


def size_text(start: float | None, largest: float | None) -> str:
    """Size at the start; and over the run, where it gets larger than its first two digits tell."""
    if start is None or largest is None:
        return ""
    first, most = significant(start, 2), significant(largest, 2)
    return first if first == most else f"{first} (to {most})"


def interval_text(ratio: Ratio) -> str:
    """``1.62 (1.58-1.70)``, with an en dash."""
    if ratio.value is None:
        return ""
    if ratio.low is None or ratio.high is None:
        return ratio_text(ratio.value)
    return f"{ratio_text(ratio.value)} ({ratio_text(ratio.low)}\N{EN DASH}{ratio_text(ratio.high)})"


def ratio_text(ratio: float) -> str:
    """``1.62``, ``23.4``."""
    return f"{ratio:.2f}" if ratio < 10.0 else significant(ratio)
