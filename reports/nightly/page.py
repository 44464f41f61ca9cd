"""The page of a night: the sentence, changes, the plan, trends, and the calendar."""

from __future__ import annotations

from collections import defaultdict
from types import MappingProxyType
from typing import TYPE_CHECKING

from reports.nightly.calendar import STATES, months
from reports.nightly.charts import small_chart
from reports.nightly.summary import by_cause
from reports.page import surroundings, templates
from reports.results.nights import PAGE
from reports.results.nights.document import NOT_TRIED, PROGRAM
from reports.results.writing import write_atomically

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from reports.results.nights.document import NightlyFile
    from reports.results.nights.trends import CalendarNight, TrendChart

TEMPLATE = "nightly/page.html.j2"


def write_page(
    folder: Path, facts: NightlyFile, trends: Sequence[TrendChart], nights: Sequence[CalendarNight],
    pages: Mapping[str, str] = MappingProxyType({}), reports: Mapping[str, str] = MappingProxyType({}),
) -> None:  # fmt: skip
    """Render the page of a night into a folder.

    Parameters
    ----------
    folder : Path
    facts : NightlyFile
    trends : sequence of TrendChart
        Of all figures over all nights.
    nights : sequence of CalendarNight
    pages : mapping
        Addresses of the pages of nights, by name.
    reports : mapping
        Addresses of the pages of the parts of the plan, by name.
    """
    touched = {(c.scene, c.engine, c.kind) for c in facts.changes}
    engines: dict[str, list[TrendChart]] = defaultdict(list)
    for one in trends:
        engines[one.engine].append(one)
    text = templates().get_template(TEMPLATE).render(
        facts=facts,
        by_cause=by_cause,
        untried=any(change.confirmed_words == NOT_TRIED for change in facts.changes),
        programs=any(s.name.startswith(PROGRAM) for change in facts.changes for s in change.suspects),
        changed=[small_chart(t, len(nights)) for t in trends if (t.scene, t.engine, t.kind) in touched],
        engines=[
            (engine, [small_chart(t, len(nights)) for t in own if t.curves], sum(t.still for t in own if not t.curves))
            for engine, own in sorted(engines.items())
        ],
        months=months(nights, pages),
        pages=pages,
        reports=reports,
        states=STATES,
        nights=len(nights),
        **surroundings({"environment": facts.night.environment, "packages": facts.night.packages}),
    )  # fmt: skip
    write_atomically(folder / PAGE, text)
