"""Deterministic figures over all nights of a long history, without the nights on which nothing changed.

A figure that stays the same for a thousand nights tells no more than its first and its last one. The rules of levels
(:mod:`barchain.nightly.history.changes.levels`) need the last night of each level and the first of the next. All
nights are judged in this way: a change for the worse stands however long ago it was.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa

from barchain.nightly.history.model.figures import FigureKind
from barchain.nightly.history.series import load, of_kinds, ordered
from barchain.nightly.history.storage.connection import told
from barchain.nightly.history.storage.rows import read_figures
from barchain.nightly.history.storage.tables import figures, nights
from barchain.nightly.history.storage.vocabulary import pieces

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Sequence

    from sqlalchemy import ColumnElement, Connection, Label

    from barchain.nightly.history.model.figures import Figure
    from barchain.nightly.history.model.series_model import FigureSeries, NightSummary
    from barchain.nightly.history.store import NightStore

DENSE_NIGHTS = 16
"""Last nights of which every figure is read: two turns of parts that divide their scenes among a week, and two more"""
VARYING = ("value", "word_id", "tolerance")
JUDGED = (*VARYING, "low", "high")
"""Columns that the rules look at"""
FEWEST = 2
"""Dense nights of a figure from which on its earlier ones are not needed, if nothing moved"""
MOST_PLACES = 5000
"""Figures that one query reads by series and night"""


def load_levels(
    store: NightStore, known: Sequence[NightSummary], kinds: Collection[FigureKind], dense: int = DENSE_NIGHTS
) -> tuple[FigureSeries, ...]:
    """Series over the given nights, before the `dense` last ones without figures that equal both neighbours."""
    recent = load(store, known[-dense:], kinds=kinds)
    if not known[:-dense]:
        return recent
    here = {night.number for night in known[-dense:]}
    with told(store.given), store.engine.connect() as connection:
        every, there = of_kinds(connection, kinds), nights_of_series(connection, here)
        changed = moved(connection) & every
        rare = {number for number in every if there.get(number, 0) < FEWEST}
        places = turning(connection, known, changed | rare)
        places |= places_of(connection, known, changed & of_kinds(connection, [FigureKind.BITS]))
        found = figures_at(connection, places)
    own = [(number, figure) for number, figure in found if number not in here]
    for one in recent:
        own += [(night.number, figure) for night, figure in zip(one.nights, one.figures, strict=True)]
    return ordered(own, known, {night.number: k for k, night in enumerate(known)})


def moved(connection: Connection) -> set[int]:
    """Numbers of the series that are not the same on all nights of the store, whether a night is judged or not.

    The interval of a number hardly varies without the number: only results and shares of rounding are looked at.
    """
    absent = sa.and_(figures.c.value.is_(None), figures.c.word_id.is_(None))
    missing, rounded = sa.func.sum(sa.case((absent, 1), else_=0)), sa.func.count(figures.c.tolerance)
    varying = [sa.func.min(figures.c[name]) != sa.func.max(figures.c[name]) for name in VARYING]
    partly = [sa.and_(number > 0, number < sa.func.count()) for number in (missing, rounded)]
    query = sa.select(figures.c.series_id).group_by(figures.c.series_id).having(sa.or_(*varying, *partly))
    return set(connection.execute(query).scalars())


def nights_of_series(connection: Connection, numbers: Collection[int]) -> dict[int, int]:
    """Number of nights, of some nights, by the number of the series that they have."""
    query = sa.select(figures.c.series_id, sa.func.count().label("nights")).where(figures.c.night_id.in_(numbers))
    return {row.series_id: row.nights for row in connection.execute(query.group_by(figures.c.series_id))}


def places_of(connection: Connection, known: Sequence[NightSummary], wanted: Collection[int]) -> set[tuple[int, int]]:
    """Series and night of each figure of some series."""
    query = sa.select(figures.c.series_id, figures.c.night_id).where(of_series_on(known, wanted))
    return {(r.series_id, r.night_id) for r in connection.execute(query)}


def load_gone(
    store: NightStore, known: Sequence[NightSummary], recent: Sequence[NightSummary], kinds: Collection[FigureKind]
) -> tuple[FigureSeries, ...]:
    """Last figures of the series that the `recent` ones of some nights lack."""
    here = {night.number for night in recent}
    with told(store.given), store.engine.connect() as connection:
        absent = of_kinds(connection, kinds) - set(nights_of_series(connection, here))
        place = {night.number: k for k, night in enumerate(known)}
        last: dict[int, int] = {}
        for number, night in places_of(connection, known, absent):
            last[number] = max(last.get(number, night), night, key=place.__getitem__)
        found = figures_at(connection, last.items())
    return ordered(found, known, place)


def turning(connection: Connection, known: Sequence[NightSummary], wanted: Collection[int]) -> set[tuple[int, int]]:
    """Series and night of each figure that differs from a neighbour, of the first and last ones, and of missing ones.

    Figures lie in the order of series and numbers of nights. If nights were added in the order of their starts, the
    database need not sort them.
    """
    in_order = all(a.number < b.number for a, b in itertools.pairwise(known))
    order = (figures.c.night_id,) if in_order else (nights.c.started, nights.c.id)

    def beside(which: str, name: str) -> Label[Any]:
        """Value of a column in the row before (``lag``) or after (``lead``)."""
        row = getattr(sa.func, which)(figures.c[name]).over(partition_by=figures.c.series_id, order_by=order)
        value: Label[Any] = row.label(f"{which}_{name}")
        return value

    source = figures if in_order else figures.join(nights, figures.c.night_id == nights.c.id)
    every = (
        sa.select(
            figures.c.series_id, figures.c.night_id, *(figures.c[name] for name in JUDGED),
            *(beside("lag", name) for name in ("night_id", *JUDGED)), beside("lead", "night_id"),
        )
        .select_from(source)
        .where(of_series_on(known, wanted))
        .subquery()
    )  # fmt: skip
    c = every.c
    chosen = sa.or_(
        c.lag_night_id.is_(None),
        c.lead_night_id.is_(None),
        *(c[name].is_distinct_from(c[f"lag_{name}"]) for name in JUDGED),
        sa.and_(c.value.is_(None), c.word_id.is_(None)),
    )
    rows = connection.execute(sa.select(c.series_id, c.night_id, c.lag_night_id).where(chosen)).all()
    return {(r.series_id, night) for r in rows for night in (r.night_id, r.lag_night_id) if night is not None}


def figures_at(connection: Connection, places: Iterable[tuple[int, int]]) -> list[tuple[int, Figure]]:
    """Figures of some series and nights, each with the number of its night."""
    place = sa.tuple_(figures.c.series_id, figures.c.night_id)
    return [one for some in pieces(sorted(places), MOST_PLACES) for one in read_figures(connection, place.in_(some))]


def of_series_on(known: Sequence[NightSummary], wanted: Collection[int]) -> ColumnElement[bool]:
    """Condition that a figure is of some series and some nights."""
    return sa.and_(among([night.number for night in known], figures.c.night_id), among(wanted, figures.c.series_id))


def among(numbers: Collection[int], column: ColumnElement[int]) -> ColumnElement[bool]:
    """Condition that a column has one of some numbers.

    They stand in the text of the query: databases limit the number of parameters.
    """
    wanted: sa.BindParameter[Sequence[int]] = sa.bindparam(None, sorted(numbers), expanding=True, literal_execute=True)
    return column.in_(wanted)
