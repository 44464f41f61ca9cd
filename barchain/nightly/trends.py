"""Trends of all figures over the nights, thinned for a page, and the calendar of nights."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from typing import TYPE_CHECKING

import numpy as np

from barchain.nightly.figures import FigureKind
from barchain.nightly.vanished import continued
from reports.tables.nights.trends import CalendarNight, TrendChart, TrendCurve

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from barchain.nightly.changes import Change
    from barchain.nightly.figures import FigureIdentity, NightSummary
    from barchain.nightly.table import FigureTable

    Key = tuple[str, str, str]


MOST_POINTS = 60
"""Points of a curve: of more nights, each earlier point is the median of a group"""
SHOWN = (FigureKind.ERROR, FigureKind.RATIO, FigureKind.MEMORY, FigureKind.COUNT)
"""Kinds that are drawn as factors relative to the median over the nights"""


def trend_charts(
    table: FigureTable, nights: Sequence[NightSummary], changes: Sequence[Change]
) -> tuple[TrendChart, ...]:
    """Charts of all engines and scenes.

    Parameters
    ----------
    table : FigureTable
    nights : sequence of NightSummary
        Those that are drawn, in their order.
    changes : sequence of Change
        Their first nights with the new value are marked.
    """
    place = {night.name: k for k, night in enumerate(nights)}
    curves: dict[Key, list[TrendCurve]] = defaultdict(list)
    still: Counter[Key] = Counter()
    for identity, at, value in drawn(table, nights, place):
        curves[key_of(identity)] += []
        if (value == value[0]).all():
            still[key_of(identity)] += 1
        else:
            quantity = f"{identity.quantity}{f' ({identity.setting})' if identity.setting else ''}"
            points = thinned(at.astype(float), value / np.median(value))
            curves[key_of(identity)].append(TrendCurve(quantity, str(identity.kind), *map(tuple, points)))
    marked: dict[Key, set[int]] = defaultdict(set)
    for change in changes:
        if change.since in place:
            marked[key_of(change.identity)].add(place[change.since])
    return tuple(
        TrendChart(*key, tuple(own), still[key], tuple(sorted(marked[key]))) for key, own in sorted(curves.items())
    )


def drawn(
    table: FigureTable, nights: Sequence[NightSummary], place: Mapping[str, int]
) -> Iterator[tuple[FigureIdentity, NDArray[np.intp], NDArray[np.float64]]]:
    """Figures of engines, the places of their nights, and their values, from those above zero; a renamed one is one."""
    columns, there = np.flatnonzero(table.among(nights)), table.where(nights, SHOWN)
    renamed = may_go_on(table.identities, there[:, columns])
    for k in np.flatnonzero(there.any(axis=1) & ~renamed).tolist():
        at = np.flatnonzero(there[k, columns])
        yield from above_zero(table.identities[k], at, table.results["value"][table.cells[k, columns[at]]])
    series, _ = continued(table.series_at(there & renamed[:, None]))
    for one in series:
        at = np.array([place[night.name] for night in one.nights])
        values = [math.nan if figure.value is None else figure.value for figure in one.figures]
        yield from above_zero(one.identity, at, np.array(values))


def above_zero(
    identity: FigureIdentity, at: NDArray[np.intp], value: NDArray[np.float64]
) -> Iterator[tuple[FigureIdentity, NDArray[np.intp], NDArray[np.float64]]]:
    """A figure of an engine where it is above zero; nothing without such a night."""
    known = value > 0.0
    if identity.engine and known.any():
        yield identity, at[known], value[known]


def may_go_on(identities: Sequence[FigureIdentity], there: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Whether a figure ended before one of an equal quantity began, or began after one ended, (figures,)."""
    found, groups = np.zeros(len(identities), bool), defaultdict[tuple[str, str, str], list[int]](list)
    for k in np.flatnonzero(there.any(axis=1)).tolist():
        groups[identities[k].engine, identities[k].quantity, identities[k].anchor].append(k)
    for own in groups.values():
        first, last = there[own].argmax(axis=1), there.shape[1] - 1 - there[own, ::-1].argmax(axis=1)
        found[own] = (last < first.max()) | (first > last.min())
    return found


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
