"""Figures that are gone: measured on two nights of the same plan in a row, and on none since."""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.nightly.history.changes.model import Change, Direction
from barchain.nightly.history.model.figures import Figure

if TYPE_CHECKING:
    from collections.abc import Sequence

    from barchain.nightly.history.model.series_model import FigureSeries, NightSummary

NIGHTS = 2
"""Nights in a row that must have a figure: a plan measures some figures only now and then"""
SAMPLED = ("stability.", "selftest.", "campaign.")
"""Beginnings of the quantities of studies of which a night does a part only: scenes, or faults, of that night"""


def vanished(series: Sequence[FigureSeries], nights: Sequence[NightSummary]) -> tuple[Change, ...]:
    """Figures that the last of some nights lacks, since the first night without them; none of an incomplete night.

    Parameters
    ----------
    series : sequence of FigureSeries
    nights : sequence of NightSummary
        In their order.
    """
    if not nights or not nights[-1].complete:
        return ()
    tonight = nights[-1]
    plan = [night for night in nights if night.plan == tonight.plan and night.complete]
    found = []
    current = [one for one in series if one.nights and one.nights[-1].number == tonight.number]
    not_run, done = {place(one) for one in current if one.figures[-1].not_run}, {subject(one) for one in current}
    for one in series:
        if place(one) in not_run or (one.identity.quantity.startswith(SAMPLED) and subject(one) not in done):
            continue
        there = {night.number: figure for night, figure in zip(one.nights, one.figures, strict=True)}
        had = [k for k, night in enumerate(plan) if night.number in there]
        last = had[-1] if had else len(plan)
        if last + 1 >= len(plan) or last + 1 < NIGHTS or had[-NIGHTS:] != [*range(last + 1 - NIGHTS, last + 1)]:
            continue
        was = there[plan[last].number]
        if not was.missing:
            reason = f"not measured, though each of the {NIGHTS} nights of this plan before had it"
            now = Figure(one.identity, reason=reason, depends=was.depends)
            since = plan[last + 1].name
            found.append(Change(one.identity, was, now, plan[last].name, since, Direction.WORSE, reason))
    return tuple(found)


def subject(series: FigureSeries) -> tuple[str, str, str]:
    """Study, scene and fault of a figure of a study that does some of them each night."""
    identity = series.identity
    study = identity.quantity.partition(".")[0]
    return study, identity.scene, identity.setting if study != "stability" else ""


def place(series: FigureSeries) -> tuple[str, str, str, str]:
    """Study, scene, engine and setting of a figure: a run that had no time lacks all of its figures."""
    identity = series.identity
    return identity.quantity.partition(".")[0], identity.scene, identity.engine, identity.setting
