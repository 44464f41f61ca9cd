"""Trends of all figures over the nights, thinned for a page, and the calendar of nights."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from barchain.nightly.figures import FigureKind
from reports.tables.nights.trends import CalendarNight, TrendChart, TrendCurve

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from barchain.nightly.figures import FigureIdentity, NightSummary
    from barchain.nightly.levels import EarlierNames
    from barchain.nightly.table import FigureTable
    from barchain.nightly.told import ToldNight

    Key = tuple[str, str, str]
    Told = Mapping[str, ToldNight]


MOST_POINTS = 60
"""Points of a curve: of more nights, each earlier point is the median of a group"""
SHOWN = (FigureKind.ERROR, FigureKind.RATIO, FigureKind.MEMORY, FigureKind.COUNT)
"""Kinds that are drawn as factors relative to the median over the nights"""


def trend_charts(
    table: FigureTable, nights: Sequence[NightSummary], told: Told = MappingProxyType({}),
    names: Mapping[FigureIdentity, EarlierNames] = MappingProxyType({}),
) -> tuple[TrendChart, ...]:  # fmt: skip
    """Charts of all engines and scenes.

    Parameters
    ----------
    table : FigureTable
    nights : sequence of NightSummary
        Those that are drawn, in their order.
    told : mapping
        What each night told, by its name: first nights with a new value are marked.
    names : mapping
        Earlier names of figures, each with its last night.
    """
    curves: dict[Key, list[TrendCurve]] = defaultdict(list)
    still: Counter[Key] = Counter()
    for identity, at, value in drawn(table, nights, names):
        curves[key_of(identity)] += []
        if (value == value[0]).all():
            still[key_of(identity)] += 1
        else:
            quantity = f"{identity.quantity}{f' ({identity.setting})' if identity.setting else ''}"
            points = thinned(at.astype(float), value / np.median(value))
            curves[key_of(identity)].append(TrendCurve(quantity, str(identity.kind), *map(tuple, points)))
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


def drawn(
    table: FigureTable, nights: Sequence[NightSummary], names: Mapping[FigureIdentity, EarlierNames]
) -> Iterator[tuple[FigureIdentity, NDArray[np.intp], NDArray[np.float64]]]:
    """Figures of engines, the places of their nights, and their values, from those above zero; a renamed one is one."""
    columns, there = np.flatnonzero(table.among(nights)), table.where(nights, SHOWN)
    rows = {identity: k for k, identity in enumerate(table.identities)}
    starts = np.array([night.name for night in nights])
    ended = {name: until for earlier in names.values() for name, until in earlier}
    for k in np.flatnonzero(there.any(axis=1)).tolist():
        identity = table.identities[k]
        goes_on = identity in ended and not (there[k, columns] & (starts > ended[identity])).any()
        if not identity.engine or goes_on:
            continue
        at, value, since = [], [], ""
        for name, until in (*names.get(identity, ()), (identity, "~")):  # after all nights
            if name in rows:
                own = there[rows[name], columns] & (starts > since) & (starts <= until)
                at.append(np.flatnonzero(own))
                value.append(table.results["value"][table.cells[rows[name], columns[own]]])
            since = until
        nights_of, values = np.concatenate(at), np.concatenate(value)
        if (above_zero := values > 0.0).any():
            yield identity, nights_of[above_zero], values[above_zero]


def key_of(identity: FigureIdentity) -> Key:
    """Scene, engine and kind of a figure: those of one chart."""
    return identity.scene, identity.engine, str(identity.kind)


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
    found = []
    for night in nights:
        worse, changes = told.get(night.name, (0, 0))
        state = (
            "void" if night.void else "worse" if worse else "incomplete" if not night.complete
            else "changed" if changes else "quiet"
        )  # fmt: skip
        found.append(CalendarNight(night.name, night.started.isoformat(), state, changes))
    return tuple(found)
