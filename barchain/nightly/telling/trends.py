"""Trends of all figures over the nights, thinned for a page, and the calendar of nights."""

from __future__ import annotations

import math
from collections import defaultdict
from typing import TYPE_CHECKING

import numpy as np

from barchain.nightly.history.model.figures import FigureKind
from reports.tables.nights.trends import CalendarNight, TrendChart, TrendCurve

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from barchain.nightly.history.changes.model import Change
    from barchain.nightly.history.model.series_model import FigureSeries, NightSummary

MOST_POINTS = 60
"""Points of a curve: of more nights, each point is the median of some nights one after the other"""
SHOWN = (FigureKind.ERROR, FigureKind.RATIO, FigureKind.MEMORY, FigureKind.COUNT)
"""Kinds that are drawn as factors relative to the median over the nights"""


def trend_charts(
    series: Sequence[FigureSeries], nights: Sequence[NightSummary], changes: Sequence[Change]
) -> tuple[TrendChart, ...]:
    """Charts of all engines and scenes.

    Parameters
    ----------
    series : sequence of FigureSeries
    nights : sequence of NightSummary
        All nights in their order.
    changes : sequence of Change
        Their first nights with the new value are marked.
    """
    place = {night.number: k for k, night in enumerate(nights)}
    named = {night.name: k for k, night in enumerate(nights)}
    grouped: dict[tuple[str, str, str], list[FigureSeries]] = defaultdict(list)
    for one in series:
        i = one.identity
        if i.kind in SHOWN and i.engine:
            grouped[i.scene, i.engine, str(i.kind)].append(one)
    steps: dict[tuple[str, str, str], set[int]] = defaultdict(set)
    for change in changes:
        if change.since in named:
            i = change.identity
            steps[i.scene, i.engine, str(i.kind)].add(named[change.since])
    return tuple(chart(key, own, place, steps[key]) for key, own in sorted(grouped.items()))


def chart(
    key: tuple[str, str, str], series: Sequence[FigureSeries], place: Mapping[int, int], steps: set[int]
) -> TrendChart:
    """Chart of one kind, of one engine in one scene."""
    found = [c for c in (curve(one, place) for one in series) if c is not None]
    return TrendChart(*key, tuple(found), len(series) - len(found), tuple(sorted(steps)))


def curve(series: FigureSeries, place: Mapping[int, int]) -> TrendCurve | None:
    """Curve of one figure; None if it has the same value on all nights, or no positive one."""
    pairs = [
        (place[night.number], figure.value)
        for night, figure in zip(series.nights, series.figures, strict=True)
        if figure.value is not None and figure.value > 0.0 and night.number in place
    ]
    if not pairs or len({value for _, value in pairs}) == 1:
        return None
    night, value = (np.array(column, float) for column in zip(*pairs, strict=True))
    factor = value / float(np.median(value))
    night, factor = thinned(night, factor)
    quantity = f"{series.identity.quantity}{f' ({series.identity.setting})' if series.identity.setting else ''}"
    return TrendCurve(quantity, str(series.identity.kind), tuple(night.tolist()), tuple(factor.tolist()))


def thinned(night: NDArray[np.float64], factor: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Curve of at most :data:`MOST_POINTS` points: medians of groups of nights; the last nights stay as they are."""
    if len(night) <= MOST_POINTS:
        return night, factor
    kept = MOST_POINTS // 2
    groups = np.array_split(np.arange(len(night) - kept), MOST_POINTS - kept)
    first = [(float(night[g].mean()), math.exp(float(np.median(np.log(factor[g]))))) for g in groups if len(g)]
    early_night, early_factor = (np.array(column) for column in zip(*first, strict=True))
    return np.append(early_night, night[-kept:]), np.append(early_factor, factor[-kept:])


def calendar(nights: Sequence[NightSummary], told: Mapping[str, tuple[int, int]]) -> tuple[CalendarNight, ...]:
    """Calendar of all nights.

    Parameters
    ----------
    nights : sequence of NightSummary
    told : mapping
        Numbers of changes for the worse and of all changes that a night told, by its name.
    """
    return tuple(calendar_night(night, *told.get(night.name, (0, 0))) for night in nights)


def calendar_night(night: NightSummary, worse: int, changes: int) -> CalendarNight:
    """Entry of one night."""
    if night.void:
        state = "void"
    elif worse:
        state = "worse"
    elif not night.complete:
        state = "incomplete"
    else:
        state = "changed" if changes else "quiet"
    return CalendarNight(night.name, night.started.isoformat(), state, changes)
