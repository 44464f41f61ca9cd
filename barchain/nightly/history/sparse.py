"""Deterministic figures over all nights of a long history, without the nights on which nothing changed.

A figure that stays the same for a thousand nights tells no more than its first and its last one. The rules of levels
(:mod:`barchain.nightly.history.changes.levels`) need the last night of each level and the first of the next. All
nights are judged in this way: a change for the worse stands however long ago it was.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import sqlalchemy as sa

from barchain.nightly.history.series import load, ordered
from barchain.nightly.history.storage.connection import told
from barchain.nightly.history.storage.rows import read_figures
from barchain.nightly.history.storage.tables import figures, nights, series

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Sequence

    from sqlalchemy import ColumnElement, Connection

    from barchain.nightly.history.model.figures import Figure, FigureKind
    from barchain.nightly.history.model.series_model import FigureSeries, NightSummary
    from barchain.nightly.history.store import NightStore

DENSE_NIGHTS = 16
"""Last nights of which every figure is read: two turns of parts that divide their scenes among a week, and two more"""
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
        wanted = moved(connection, kinds) | (of_kinds(connection, kinds) - on_night(connection, here))
        places = turning(connection, known, wanted)
        found = [entry for chunk in chunks(sorted(places)) for entry in figures_at(connection, chunk)]
    own = [(number, figure) for number, figure in found if number not in here]
    for one in recent:
        own += [(night.number, figure) for night, figure in zip(one.nights, one.figures, strict=True)]
    return ordered(own, known, {night.number: k for k, night in enumerate(known)})


def moved(connection: Connection, kinds: Collection[FigureKind]) -> set[int]:
    """Numbers of the series that are not the same on all nights of the store, whether a night is judged or not."""
    absent = sa.and_(figures.c.value.is_(None), figures.c.word_id.is_(None))
    missing = sa.func.sum(sa.case((absent, 1), else_=0))
    value, word = figures.c.value, figures.c.word_id
    query = sa.select(figures.c.series_id).group_by(figures.c.series_id)
    query = query.having(
        sa.or_(
            sa.func.min(value) != sa.func.max(value),
            sa.func.min(word) != sa.func.max(word),
            sa.and_(missing > 0, missing < sa.func.count()),
        )
    )
    return set(connection.execute(query).scalars()) & of_kinds(connection, kinds)


def of_kinds(connection: Connection, kinds: Collection[FigureKind]) -> set[int]:
    """Numbers of the series of some kinds."""
    return set(connection.execute(sa.select(series.c.id).where(series.c.kind.in_([str(k) for k in kinds]))).scalars())


def on_night(connection: Connection, numbers: Collection[int]) -> set[int]:
    """Numbers of the series that some nights have."""
    return set(
        connection.execute(sa.select(figures.c.series_id).where(figures.c.night_id.in_(numbers)).distinct()).scalars()
    )


def turning(connection: Connection, known: Sequence[NightSummary], wanted: Collection[int]) -> set[tuple[int, int]]:
    """Series and night of each figure that differs from a neighbour, of the first and last ones, and of missing ones.

    Figures lie in the order of series and numbers of nights. If nights were added in the order of their starts, the
    database need not sort them.
    """
    in_order = all(a.number < b.number for a, b in itertools.pairwise(known))
    order = (figures.c.night_id,) if in_order else (nights.c.started, nights.c.id)
    before, old_value, old_word, after = (
        neighbour(column).over(partition_by=figures.c.series_id, order_by=order)
        for neighbour, column in (
            (sa.func.lag, figures.c.night_id), (sa.func.lag, figures.c.value), (sa.func.lag, figures.c.word_id),
            (sa.func.lead, figures.c.night_id),
        )
    )  # fmt: skip
    source = figures if in_order else figures.join(nights, figures.c.night_id == nights.c.id)
    every = (
        sa.select(
            figures.c.series_id, figures.c.night_id, figures.c.value, figures.c.word_id,
            before.label("before"), old_value.label("old_value"), old_word.label("old_word"), after.label("after"),
        )
        .select_from(source)
        .where(among(known_numbers(known), figures.c.night_id), among(wanted, figures.c.series_id))
        .subquery()
    )  # fmt: skip
    c = every.c
    chosen = sa.or_(
        c.before.is_(None),
        c.after.is_(None),
        c.value.is_distinct_from(c.old_value),
        c.word_id.is_distinct_from(c.old_word),
        sa.and_(c.value.is_(None), c.word_id.is_(None)),
    )
    rows = connection.execute(sa.select(c.series_id, c.night_id, c.before).where(chosen)).all()
    return {(r.series_id, night) for r in rows for night in (r.night_id, r.before) if night is not None}


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
