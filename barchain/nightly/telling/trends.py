"""Trends of all figures over the nights, thinned for a page, and the calendar of nights."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from reports.results.nights.trends import CalendarNight, TrendChart, TrendCurve

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from barchain.nightly.figures.figure import EarlierNames, FigureIdentity, NightSummary
    from barchain.nightly.figures.table import NumberSeries, NumberTable
    from barchain.nightly.history.acceptances import Acceptance
    from barchain.nightly.history.news import ToldNight

    Key = tuple[str, str, str]
    Told = Mapping[str, ToldNight]


MOST_POINTS = 60
"""Points of a curve: of more nights, each earlier point is the median of a group"""


def trend_charts(
    table: NumberTable, nights: Sequence[NightSummary], told: Told = MappingProxyType({}),
    names: Mapping[FigureIdentity, EarlierNames] = MappingProxyType({}),
) -> tuple[TrendChart, ...]:  # fmt: skip
    """Charts of all engines and scenes: factors relative to the median over the nights.

    Parameters
    ----------
    table : NumberTable
    nights : sequence of NightSummary
        Those that are drawn, in their order.
    told : mapping
        What each night told, by its name: first nights with a new value are marked.
    names : mapping
        Earlier names of figures, each with its last night.
    """
    curves: dict[Key, list[TrendCurve]] = defaultdict(list)
    still: Counter[Key] = Counter()
    for one in drawn(table.among(nights), names):
        identity, above_zero = one.identity, one.values > 0.0
        at, value = one.at[above_zero], one.values[above_zero]
        curves[chart_of(identity)] += []
        if (value == value[0]).all():
            still[chart_of(identity)] += 1
        else:
            points = thinned(at.astype(float), value / np.median(value))
            curves[chart_of(identity)].append(TrendCurve(curve_name(identity), str(identity.kind), *map(tuple, points)))
    marked = marked_nights(nights, told)
    return tuple(
        TrendChart(*key, tuple(own), still[key], tuple(sorted(marked[key]))) for key, own in sorted(curves.items())
    )


def marked_nights(nights: Sequence[NightSummary], told: Told) -> dict[Key, set[int]]:
    """Numbers of the nights on which a figure changed, by chart."""
    number = {night.name: k for k, night in enumerate(nights)}
    found: dict[Key, set[int]] = defaultdict(set)
    for name in number.keys() & told.keys():
        for change in told[name].changes:
            scene, engine = change.figure.split(":")[:2]
            if change.since in number:
                found[scene, engine, change.kind].add(number[change.since])
    return found


def drawn(table: NumberTable, names: Mapping[FigureIdentity, EarlierNames]) -> Iterator[NumberSeries]:
    """Figures of engines; one that goes on under another name is drawn with that one."""
    ended = {name: until for earlier in names.values() for name, until in earlier}
    for identity in table.identities:
        one = table.series(identity, names.get(identity, ()))
        goes_on = identity in ended and not any(night.name > ended[identity] for night in one.nights)
        if identity.engine and not goes_on and (one.values > 0.0).any():
            yield one


def chart_of(identity: FigureIdentity) -> Key:
    """Scene, engine and kind of a figure: those of one chart."""
    return identity.scene, identity.engine, str(identity.kind)


def curve_name(identity: FigureIdentity) -> str:
    """Name of a figure's curve in its chart."""
    return f"{identity.quantity}{f' ({identity.setting})' if identity.setting else ''}"


def thinned(night: NDArray[np.float64], factor: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Curve of at most :data:`MOST_POINTS` points: medians of groups of nights; the last nights stay as they are."""
    if len(night) <= MOST_POINTS:
        return night, factor
    kept = MOST_POINTS // 2
    groups = np.array_split(np.arange(len(night) - kept), MOST_POINTS - kept)
    first = [(float(night[g].mean()), math.exp(float(np.median(np.log(factor[g]))))) for g in groups if len(g)]
    early_night, early_factor = (np.array(column) for column in zip(*first, strict=True))
    return np.append(early_night, night[-kept:]), np.append(early_factor, factor[-kept:])


def calendar(nights: Sequence[NightSummary], told: Told, known: Sequence[Acceptance]) -> tuple[CalendarNight, ...]:
    """Calendar of all nights.

    Parameters
    ----------
    nights : sequence of NightSummary
    told : mapping
        What each night told, by its name.
    known : sequence of Acceptance
        Those that have not ended: what they cover is not worse.
    """
    found = []
    for night in nights:
        facts = told.get(night.name)
        changes = len(facts.tonight) if facts else 0
        held = facts is not None and bool(facts.standing)  # accepted, if the night is not worse
        state = (
            "void" if night.void else "worse" if facts and facts.worse(known) else "incomplete" if not night.complete
            else "changed" if changes or held else "first" if facts and not facts.judged else "quiet"
        )  # fmt: skip
        found.append(CalendarNight(night.name, night.started.isoformat(), state, changes))
    return tuple(found)
