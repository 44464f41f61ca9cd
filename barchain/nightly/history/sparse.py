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
from barchain.nightly.history.series import load, ordered
from barchain.nightly.history.storage.connection import told
from barchain.nightly.history.storage.rows import read_figures
from barchain.nightly.history.storage.tables import figures, nights, series

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Sequence

    from sqlalchemy import ColumnElement, Connection, Label

    from barchain.nightly.history.model.figures import Figure
    from barchain.nightly.history.model.series_model import FigureSeries, NightSummary
    from barchain.nightly.history.store import NightStore

DENSE_NIGHTS = 16
"""Last nights of which every figure is read: two turns of parts that divide their scenes among a week, and two more"""
VARYING = ("value", "word_id", "tolerance")
JUDGED = (*VARYING, "low", "high")
"""Columns that the rules look at"""
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
        changed = moved(connection, kinds)
        once = {s.id for s in counted(connection, here) if s.nights == 1}
        absent = of_kinds(connection, kinds) - {s.id for s in counted(connection, here)}
        places = turning(connection, known, changed | absent | (once & of_kinds(connection, kinds)))
        places |= every_place(connection, known, changed & of_kinds(connection, [FigureKind.BITS]))
        found = [entry for chunk in chunks(sorted(places)) for entry in figures_at(connection, chunk)]
    own = [(number, figure) for number, figure in found if number not in here]
    for one in recent:
        own += [(night.number, figure) for night, figure in zip(one.nights, one.figures, strict=True)]
    return ordered(own, known, {night.number: k for k, night in enumerate(known)})


def moved(connection: Connection, kinds: Collection[FigureKind]) -> set[int]:
    """Numbers of the series that are not the same on all nights of the store, whether a night is judged or not.

    The interval of a number hardly varies without the number: only results and shares of rounding are looked at.
    """
    absent = sa.and_(figures.c.value.is_(None), figures.c.word_id.is_(None))
    missing = sa.func.sum(sa.case((absent, 1), else_=0))
    varying = [sa.func.min(figures.c[name]) != sa.func.max(figures.c[name]) for name in VARYING]
    query = sa.select(figures.c.series_id).group_by(figures.c.series_id)
    query = query.having(sa.or_(*varying, sa.and_(missing > 0, missing < sa.func.count()), partly_known()))
    return set(connection.execute(query).scalars()) & of_kinds(connection, kinds)


def of_kinds(connection: Connection, kinds: Collection[FigureKind]) -> set[int]:
    """Numbers of the series of some kinds."""
    return set(connection.execute(sa.select(series.c.id).where(series.c.kind.in_([str(k) for k in kinds]))).scalars())


def partly_known() -> ColumnElement[bool]:
    """Condition on a group of figures that some have a share of rounding and others have none."""
    known = sa.func.count(figures.c.tolerance)
    return sa.and_(known > 0, known < sa.func.count())


def counted(connection: Connection, numbers: Collection[int]) -> Sequence[Any]:
    """Series that some nights have, ``id``, each with the number of these nights, ``nights``."""
    query = sa.select(figures.c.series_id.label("id"), sa.func.count().label("nights"))
    return connection.execute(query.where(figures.c.night_id.in_(numbers)).group_by(figures.c.series_id)).all()


def every_place(connection: Connection, known: Sequence[NightSummary], wanted: Collection[int]) -> set[tuple[int, int]]:
    """Series and night of each figure: of bits, which are compared with the last night of the same parts."""
    query = sa.select(figures.c.series_id, figures.c.night_id)
    chosen = among(known_numbers(known), figures.c.night_id), among(wanted, figures.c.series_id)
    return {(r.series_id, r.night_id) for r in connection.execute(query.where(*chosen))}


def load_gone(
    store: NightStore, known: Sequence[NightSummary], recent: Sequence[NightSummary], kinds: Collection[FigureKind]
) -> tuple[FigureSeries, ...]:
    """Last figures of the series that the `recent` ones of some nights lack."""
    here = {night.number for night in recent}
    with told(store.given), store.engine.connect() as connection:
        absent = of_kinds(connection, kinds) - {s.id for s in counted(connection, here)}
        place = {night.number: k for k, night in enumerate(known)}
        last: dict[int, int] = {}
        for number, night in every_place(connection, known, absent):
            last[number] = max(last.get(number, night), night, key=place.__getitem__)
        found = [entry for chunk in chunks(sorted(last.items())) for entry in figures_at(connection, chunk)]
    return ordered(found, known, place)


def turning(connection: Connection, known: Sequence[NightSummary], wanted: Collection[int]) -> set[tuple[int, int]]:
    """Series and night of each figure that differs from a neighbour, of the first and last ones, and of missing ones.

    Figures lie in the order of series and numbers of nights. If nights were added in the order of their starts, the
    database need not sort them.
    """
    in_order = all(a.number < b.number for a, b in itertools.pairwise(known))
    order = (figures.c.night_id,) if in_order else (nights.c.started, nights.c.id)

    def lag(name: str) -> Label[Any]:
        """Value of a column in the row before."""
        return sa.func.lag(figures.c[name]).over(partition_by=figures.c.series_id, order_by=order).label(f"lag_{name}")

    def lead(name: str) -> Label[Any]:
        """Value of a column in the row after."""
        return (
            sa.func.lead(figures.c[name]).over(partition_by=figures.c.series_id, order_by=order).label(f"lead_{name}")
        )

    source = figures if in_order else figures.join(nights, figures.c.night_id == nights.c.id)
    every = (
        sa.select(
            figures.c.series_id, figures.c.night_id, *(figures.c[name] for name in JUDGED),
            *(lag(name) for name in ("night_id", *JUDGED)), lead("night_id"),
        )
        .select_from(source)
        .where(among(known_numbers(known), figures.c.night_id), among(wanted, figures.c.series_id))
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


def figures_at(connection: Connection, places: Sequence[tuple[int, int]]) -> list[tuple[int, Figure]]:
    """Figures of some series and nights."""
    return read_figures(connection, sa.tuple_(figures.c.series_id, figures.c.night_id).in_(places))


def chunks(places: Sequence[tuple[int, int]]) -> Iterator[Sequence[tuple[int, int]]]:
    """Pieces that a query takes: databases limit the number of parameters."""
    for begin in range(0, len(places), MOST_PLACES):
        yield places[begin : begin + MOST_PLACES]


def known_numbers(known: Sequence[NightSummary]) -> list[int]:
    """Numbers of nights."""
    return [night.number for night in known]


def among(numbers: Collection[int], column: ColumnElement[int]) -> ColumnElement[bool]:
    """Condition that a column has one of some numbers, which stand in the text of the query."""
    wanted: sa.BindParameter[Sequence[int]] = sa.bindparam(None, sorted(numbers), expanding=True, literal_execute=True)
    return column.in_(wanted)
