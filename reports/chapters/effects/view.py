"""View of an effect budget, for the page and the terminal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.chapters.effects.advice import Advice, Relevance, advise, headline
from reports.chapters.effects.charts import effect_charts
from reports.chapters.effects.rows import rows_of, scope_of
from reports.chapters.effects.words import brief, spoken, times
from reports.tables.effects import QUANTITIES, SIZES, read_effects
from reports.text.numerals import significant
from reports.text.record import is_complete, mapping

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
    """Number of text columns at the left"""


@dataclass(frozen=True)
class EffectsView:
    """Contents of the chapter."""

    record: dict[str, Any]
    scope: BudgetScope
    advice: tuple[Advice, ...]
    """One for each effect, relevant ones first"""
    consequences: BudgetTable
    price: BudgetTable
    size: BudgetTable
    charts: tuple[Panel, ...]
    legend: tuple[Legend, ...]
    """Of all charts"""

    @property
    def tables(self) -> tuple[BudgetTable, ...]:
        """All tables."""
        return self.consequences, self.price, self.size

    @property
    def finished(self) -> bool:
        """Whether the budget was finished."""
        return is_complete(self.record)

    @property
    def scene(self) -> dict[str, Any]:
        """Recorded facts of the scene."""
        return mapping(self.record.get("scene"))

    @property
    def assumed(self) -> tuple[tuple[str, str], ...]:
        """Assumptions on effects that the scene does not have: title and words."""
        off = (a.row for a in self.advice if not a.row.on and not a.row.model)
        return tuple((spoken(row), row.said) for row in off if row.said)

    @property
    def headline(self) -> str:
        """Relevant and negligible effects in sentences."""
        return headline(self.advice, self.scope)

    @property
    def predictability_limit(self) -> str:
        """Predictability limit of the scene in words; empty if it covers the run."""
        short = 0.0 < self.scope.limit_s < min(self.scope.end_s, self.scope.duration_s)
        return times(self.scope.limit_s, self.scope) if short else ""

    @property
    def timing(self) -> str:
        """Sentence on the timing and on narrower intervals; empty without timing."""
        scope = self.scope
        if not scope.rounds:
            return ""
        over = "" if scope.timed_s >= scope.duration_s else f" over the first {times(scope.timed_s, scope)}"
        rounds = "round" if scope.rounds == 1 else "rounds"
        return f"Timed in {scope.rounds} {rounds}{over}; more --minutes, and more --repeats, narrow the intervals."


def view_effects(folder: Path) -> EffectsView:
    """View of the study in a result folder."""
    tables = read_effects(folder)
    scope = scope_of(tables.record)
    rows = rows_of(tables, scope)
    advice = [advise(row, scope) for row in rows]
    order, switched = list(Relevance), [a.row for a in advice if a.relevance is not Relevance.NOT_SWITCHED]
    return EffectsView(
        tables.record,
        scope,
        tuple(sorted(advice, key=lambda a: order.index(a.relevance))),
        BudgetTable(
            "Changes by each effect",
            ("effect", "in the scene", "relevance", "CM moves by", "bars rotate by", "reactions change by"),
            tuple(map(consequence_cells, advice)),
            WORDY,
        ),
        BudgetTable(
            "Times with the effect / without it",
            ("effect", "run", "one evaluation", "evaluations", "remainder"),
            tuple(map(price_cells, switched)),
        ),
        BudgetTable(
            "Size of each effect",
            ("effect", "differential / tidal", "torque / 3n²J", "common / g"),
            tuple(map(size_cells, switched)),
        ),
        *effect_charts(rows, scope),
    )


def consequence_cells(advice: Advice) -> tuple[str, ...]:
    """Cells of an effect's changes."""
    row = advice.row
    if advice.relevance is Relevance.NOT_SWITCHED:
        return (row.title, row.state, f"{advice.relevance}: {row.reason}", *[""] * len(QUANTITIES))
    changed = (row.change(q) for q in QUANTITIES)
    return (row.title, row.state, str(advice.relevance), *("" if c is None else brief(c) for c in changed))


def price_cells(row: EffectRow) -> tuple[str, ...]:
    """Cells of an effect's cost."""
    count, rest = ("" if r is None else ratio_text(r) for r in (row.evaluations_ratio, row.rest))
    return (row.title, interval_text(row.time), interval_text(row.evaluation), count, rest)


def size_cells(row: EffectRow) -> tuple[str, ...]:
    """Cells of an effect's size."""
    return (row.title, *(size_text(*row.sizes[name]) for name in SIZES))


def size_text(start: float | None, largest: float | None) -> str:
    """Size at the start, and the largest over the run if its first two digits differ."""
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
