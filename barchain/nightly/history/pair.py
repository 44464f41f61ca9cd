"""Judgement of one night against one other: a baseline, from the store, a file or a result folder."""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.nightly.history.changes.judging import JudgedNight, judge_night
from barchain.nightly.history.model.series_model import FigureSeries, NightSummary

if TYPE_CHECKING:
    from barchain.nightly.history.model.figures import Figure, FigureIdentity, Night


def judge_pair(before: Night, after: Night) -> JudgedNight:
    """Judge a night against one other.

    Times and memory need many nights, so that a baseline tells nothing of them. Figures that only one of both has are
    not judged.

    Parameters
    ----------
    before : Night
        Baseline.
    after : Night
    """
    nights = (summary_of(before, 0), summary_of(after, 1))
    found: dict[FigureIdentity, list[tuple[NightSummary, Figure]]] = {}
    for night, content in zip(nights, (before, after), strict=True):
        for figure in content.figures:
            found.setdefault(figure.identity, []).append((night, figure))
    series = tuple(
        FigureSeries(identity, tuple(n for n, _ in own), tuple(f for _, f in own)) for identity, own in found.items()
    )
    return judge_night(series, nights)


def summary_of(night: Night, number: int) -> NightSummary:
    """Night without its figures; a void one is believed here, as it was named on purpose."""
    return NightSummary(
        number, night.name, night.started, night.duration_s, night.plan, night.barchain, night.environment,
        night.parts, len(night.figures), night.commit, night.complete,
    )  # fmt: skip
