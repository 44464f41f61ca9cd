"""Judgement of one night against one other: a baseline, from the store, a file or a result folder."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from barchain.nightly.history.changes.judging import JudgedNight, judge_night
from barchain.nightly.history.changes.model import Change, Direction
from barchain.nightly.history.changes.vanished import SAMPLED
from barchain.nightly.history.model.figures import STEPPED, Figure
from barchain.nightly.history.model.series_model import FigureSeries, NightSummary

if TYPE_CHECKING:
    from barchain.nightly.history.model.figures import FigureIdentity, Night


def judge_pair(before: Night, after: Night) -> JudgedNight:
    """Judge a night against one other.

    Times and memory need many nights, so that a baseline tells nothing of them. A figure of the baseline that a
    complete night of the same plan lacks is a change for the worse. A void baseline is believed, as it was named on
    purpose; a void night is not judged.

    Parameters
    ----------
    before : Night
        Baseline.
    after : Night
    """
    nights = (replace(summary_of(before), void=None), summary_of(after))
    if after.void is not None:
        return JudgedNight(nights[1], nights[:1])
    found: dict[FigureIdentity, list[tuple[NightSummary, Figure]]] = {}
    for night, content in zip(nights, (before, after), strict=True):
        for figure in content.figures:
            found.setdefault(figure.identity, []).append((night, figure))
    series = tuple(
        FigureSeries(identity, tuple(n for n, _ in own), tuple(f for _, f in own)) for identity, own in found.items()
    )
    judged = judge_night(series, nights)
    compared = sum(len(one.nights) > 1 for one in series if one.identity.kind not in STEPPED)
    gone = tuple(lost(one, nights) for one in series if is_lost(one, nights))
    return replace(
        judged, changes=(*judged.changes, *gone), tonight=(*judged.tonight, *gone), judged=compared + len(gone)
    )


def is_lost(series: FigureSeries, nights: tuple[NightSummary, NightSummary]) -> bool:
    """Whether a figure of the baseline should be there again, and is not."""
    before, after = nights
    alone = series.nights == (before,) and not series.figures[0].missing
    rotates = series.identity.quantity.startswith(SAMPLED) or series.identity.kind in STEPPED
    return alone and not rotates and before.plan == after.plan and after.complete


def lost(series: FigureSeries, nights: tuple[NightSummary, NightSummary]) -> Change:
    """Change of a figure that is gone."""
    was, reason = series.figures[0], "not measured, though the baseline of the same plan has it"
    now = Figure(series.identity, reason=reason, depends=was.depends)
    return Change(series.identity, was, now, nights[0].name, nights[1].name, Direction.WORSE, reason)


def summary_of(night: Night) -> NightSummary:
    """Night without its figures."""
    return NightSummary(
        night.name, night.started, night.duration_s, night.plan, night.barchain, night.environment,
        night.parts, len(night.figures), night.commit, night.complete, night.void,
    )  # fmt: skip
