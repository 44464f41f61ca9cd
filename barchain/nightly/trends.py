"""Trends of all figures over the nights, thinned for a page, and the calendar of nights."""

from __future__ import annotations

import math
from collections import defaultdict
from typing import TYPE_CHECKING

import numpy as np

from barchain.nightly.figures import FigureKind
from reports.tables.nights.trends import CalendarNight, TrendChart, TrendCurve

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from barchain.nightly.changes import Change
    from barchain.nightly.figures import NightSummary, ValueSeries


MOST_POINTS = 60
"""Points of a curve: of more nights, each earlier point is the median of some nights of a group"""
OF_GROUP = 3
"""Nights that are read of a group: a history of years would take minutes to read"""
SHOWN = (FigureKind.ERROR, FigureKind.RATIO, FigureKind.MEMORY, FigureKind.COUNT)
"""Kinds that are drawn as factors relative to the median over the nights"""


def drawn_nights(nights: Sequence[NightSummary]) -> list[NightSummary]:
    """Nights whose figures are drawn: the last ones, and some of each of the groups that make one earlier point."""
    if len(nights) <= MOST_POINTS:
        return list(nights)
    kept = MOST_POINTS // 2
    groups = np.array_split(np.arange(len(nights) - kept), MOST_POINTS - kept)
    chosen = [k for g in groups for k in np.unique(np.linspace(g[0], g[-1], OF_GROUP).round().astype(int))]
    return [nights[k] for k in chosen] + list(nights[-kept:])


def trend_charts(
    series: Sequence[ValueSeries], nights: Sequence[NightSummary], changes: Sequence[Change]
) -> tuple[TrendChart, ...]:
    """Charts of all engines and scenes.

    Parameters
    ----------
    series : sequence of ValueSeries
        Of the nights of :func:`drawn_nights`.
    nights : sequence of NightSummary
        All nights in their order.
    changes : sequence of Change
        Their first nights with the new value are marked.
    """
    place = {night.name: k for k, night in enumerate(nights)}
    grouped: dict[tuple[str, str, str], list[ValueSeries]] = defaultdict(list)
    for one in series:
        i = one.identity
        if i.kind in SHOWN and i.engine:
            grouped[i.scene, i.engine, str(i.kind)].append(one)
    steps: dict[tuple[str, str, str], set[int]] = defaultdict(set)
    for change in changes:
        if change.since in place:
            i = change.identity
            steps[i.scene, i.engine, str(i.kind)].add(place[change.since])
    return tuple(chart(key, own, place, steps[key]) for key, own in sorted(grouped.items()))


def chart(
    key: tuple[str, str, str], series: Sequence[ValueSeries], place: Mapping[str, int], steps: set[int]
) -> TrendChart:
    """Chart of one kind, of one engine in one scene."""
    found = [c for c in (curve(one, place) for one in series) if c is not None]
    return TrendChart(*key, tuple(found), len(series) - len(found), tuple(sorted(steps)))


def curve(series: ValueSeries, place: Mapping[str, int]) -> TrendCurve | None:
    """Curve of one figure; None if it has the same value on all nights, or no positive one."""
    pairs = sorted((place[n], value) for n, value in zip(series.nights, series.values, strict=True) if n in place)
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
