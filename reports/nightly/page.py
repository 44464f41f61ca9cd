"""The page of a night: the sentence, changes, the plan, trends, and the calendar."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from typing import TYPE_CHECKING

from markupsafe import Markup

from reports.nightly.calendar import STATES, year_blocks
from reports.nightly.charts import small_chart
from reports.nightly.words import NOT_TRIED, by_cause, change_rows, factor_words, seconds_words
from reports.page import templates
from reports.plotting.palette import variables
from reports.tables.writing import write_atomically

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence
    from pathlib import Path

    from reports.nightly.charts import SmallChart
    from reports.tables.nights.facts import NightlyFile
    from reports.tables.nights.trends import CalendarNight, TrendChart

PAGE = "nightly.html"
TEMPLATE = "nightly/page.html.j2"


@dataclass(frozen=True)
class EngineTrends:
    """Charts of one engine."""

    engine: str
    charts: tuple[SmallChart, ...]
    still: int
    """Figures of the engine that had the same value on all nights"""


def write_page(
    folder: Path, facts: NightlyFile, trends: Sequence[TrendChart], nights: Sequence[CalendarNight],
    pages: Collection[str] = (),
) -> Path:  # fmt: skip
    """Render the page of a night into a folder, and return its path.

    Parameters
    ----------
    folder : Path
    facts : NightlyFile
    trends : sequence of TrendChart
        Of all figures over all nights.
    nights : sequence of CalendarNight
    pages : collection of str
        Names of the nights whose pages lie in folders beside this one.
    """
    path = folder / PAGE
    write_atomically(path, rendered(facts, trends, nights, pages))
    return path


def rendered(
    facts: NightlyFile, trends: Sequence[TrendChart], nights: Sequence[CalendarNight], pages: Collection[str] = ()
) -> str:
    """Text of the page."""
    touched = {(c.scene, c.engine, c.kind) for c in facts.changes}
    changed = [t for t in trends if (t.scene, t.engine, t.kind) in touched]
    rows = change_rows(facts.changes)
    return templates().get_template(TEMPLATE).render(
        facts=facts,
        changes=by_cause(rows),
        untried=any(row.confirmed == NOT_TRIED for row in rows),
        standing=by_cause(change_rows(facts.standing)),
        held=by_cause(change_rows(facts.held)),
        changed=[small_chart(t, len(nights)) for t in changed],
        engines=by_engine(trends, len(nights)),
        years=year_blocks(nights, pages),
        pages=pages,
        states=STATES,
        nights=len(nights),
        factor=factor_words,
        seconds=seconds_words,
        light=Markup(variables(0)),
        dark=Markup(variables(1)),
    )  # fmt: skip


def by_engine(trends: Sequence[TrendChart], nights: int) -> list[EngineTrends]:
    """Charts by engine, of figures that moved."""
    grouped: dict[str, list[TrendChart]] = defaultdict(list)
    for one in trends:
        grouped[one.engine].append(one)
    return [
        EngineTrends(
            engine, tuple(small_chart(t, nights) for t in own if t.curves), sum(t.still for t in own if not t.curves)
        )
        for engine, own in sorted(grouped.items())
    ]
