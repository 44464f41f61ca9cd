"""Deterministic figures over all nights of a long history, without the nights on which nothing changed.

A figure that stays the same for a thousand nights tells no more than its first and its last one. The rules of levels
(:mod:`barchain.nightly.history.changes.levels`) need the last night of each level and the first of the next. All
nights are judged in this way: a change for the worse stands however long ago it was.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import sqlalchemy as sa

from barchain.nightly.history.series import load, ordered
from barchain.nightly.history.storage.connection import told
from barchain.nightly.history.storage.rows import read_figures
from barchain.nightly.history.storage.tables import figures, nights, series

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from sqlalchemy import ColumnElement, Select

    from barchain.nightly.history.model.figures import FigureKind
    from barchain.nightly.history.model.series_model import FigureSeries, NightSummary
    from barchain.nightly.history.store import NightStore

DENSE_NIGHTS = 30
"""Last nights of which every figure is read"""


def load_levels(
    store: NightStore, known: Sequence[NightSummary], kinds: Collection[FigureKind], dense: int = DENSE_NIGHTS
) -> tuple[FigureSeries, ...]:
    """Series over the given nights, before the `dense` last ones without figures that equal both neighbours."""
    recent = load(store, known[-dense:], kinds=kinds)
    earlier = known[:-dense]
    if not earlier:
        return recent
    with told(store.given), store.engine.connect() as connection:
        chosen = sa.tuple_(figures.c.series_id, figures.c.night_id).in_(turning(earlier, known, kinds))
        found = read_figures(connection, chosen)
    places = {night.number: k for k, night in enumerate(known)}
    for one in recent:
        found += [(night.number, figure) for night, figure in zip(one.nights, one.figures, strict=True)]
    return ordered(found, known, places)


def turning(
    earlier: Sequence[NightSummary], known: Sequence[NightSummary], kinds: Collection[FigureKind]
) -> Select[Any]:
    """Query of the figures on some earlier nights that differ from a neighbour, and of missing ones.

    Figures that are the same on all nights are left out, unless the last nights lack them.
    """
    wanted = figures.c.series_id.in_(moved(known, known[len(earlier) :], kinds))
    own = [
        neighbour(column)
        .over(partition_by=figures.c.series_id, order_by=(nights.c.started, nights.c.id))
        .label(f"{name}_{column.name}")
        for name, neighbour in (("before", sa.func.lag), ("after", sa.func.lead))
        for column in (figures.c.night_id, figures.c.value, figures.c.word_id)
    ]
    every = (
        sa.select(figures.c.series_id, figures.c.night_id, figures.c.value, figures.c.word_id, *own)
        .join(nights, figures.c.night_id == nights.c.id)
        .where(on_nights(known), wanted)
        .subquery()
    )
    c = every.c
    differs = [
        condition
        for side in ("before", "after")
        for condition in (
            c[f"{side}_night_id"].is_(None),
            c[f"{side}_value"].is_distinct_from(c.value),
            c[f"{side}_word_id"].is_distinct_from(c.word_id),
        )
    ]
    missing = sa.and_(c.value.is_(None), c.word_id.is_(None))
    return sa.select(c.series_id, c.night_id).where(on_nights(earlier, c.night_id), sa.or_(*differs, missing))


def moved(known: Sequence[NightSummary], recent: Sequence[NightSummary], kinds: Collection[FigureKind]) -> Select[Any]:
    """Query of the numbers of series that are not the same on all nights, or that the recent ones lack."""
    absent = sa.and_(figures.c.value.is_(None), figures.c.word_id.is_(None))
    missing = sa.func.sum(sa.case((absent, 1), else_=0))
    value, word = figures.c.value, figures.c.word_id
    there = sa.func.sum(sa.case((on_nights(recent), 1), else_=0))
    return (
        sa.select(figures.c.series_id)
        .join(series)
        .where(on_nights(known), series.c.kind.in_([str(k) for k in kinds]))
        .group_by(figures.c.series_id)
        .having(
            sa.or_(
                sa.func.min(value) != sa.func.max(value),
                sa.func.min(word) != sa.func.max(word),
                sa.and_(missing > 0, missing < sa.func.count()),
                there == 0,
            )
        )
    )


def on_nights(wanted: Sequence[NightSummary], column: ColumnElement[int] = figures.c.night_id) -> ColumnElement[bool]:
    """Condition that a figure is of one of some nights.

    The numbers stand in the text of the query: databases limit the number of parameters.
    """
    numbers: sa.BindParameter[Sequence[int]] = sa.bindparam(
        None, [night.number for night in wanted], expanding=True, literal_execute=True
    )
    return column.in_(numbers)
