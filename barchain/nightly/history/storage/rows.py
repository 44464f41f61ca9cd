"""Figures as rows of the store, and back."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import sqlalchemy as sa

from barchain.nightly.history.model.figures import Figure
from barchain.nightly.history.storage.tables import figures, series, texts
from barchain.nightly.history.storage.vocabulary import CHUNK, depends_of, depends_text, identity_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from sqlalchemy import ColumnElement, Connection

    from barchain.nightly.history.model.figures import FigureIdentity

NUMBERS = ("value", "low", "high", "tolerance")
WORDS = ("word", "trajectory", "reason")


def figure_rows(
    found: Sequence[Figure],
    night: int,
    known: Mapping[FigureIdentity, int],
    numbers_of: Callable[[Iterable[str]], Mapping[str, int]],
) -> list[dict[str, Any]]:
    """Rows of a night's figures; `numbers_of` gives the numbers of texts."""
    depends = {figure.depends: depends_text(figure.depends) for figure in found}
    wanted = {getattr(figure, name) for figure in found for name in WORDS} - {""}
    numbers = numbers_of(wanted | set(depends.values()))
    return [
        {
            "series_id": known[figure.identity],
            "night_id": night,
            **{name: getattr(figure, name) for name in NUMBERS},
            **{f"{name}_id": numbers.get(getattr(figure, name)) for name in WORDS},
            "depends_id": numbers[depends[figure.depends]],
        }
        for figure in sorted(found, key=lambda f: known[f.identity])
    ]


def read_figures(connection: Connection, chosen: ColumnElement[bool]) -> list[tuple[int, Figure]]:
    """Figures that a condition chooses, each with the number of its night, by series and night.

    Parameters
    ----------
    connection : Connection
    chosen : ColumnElement
        Condition on the tables of figures and series.
    """
    query = sa.select(figures).join(series).where(chosen).order_by(figures.c.series_id, figures.c.night_id)
    rows = connection.execute(query).all()
    own = {row.series_id for row in rows}
    identities = {row.id: identity_of(row) for row in chunked(connection, series, own)}
    used = {number for row in rows for number in (row.word_id, row.trajectory_id, row.reason_id, row.depends_id)}
    words: dict[int | None, str] = {row.id: row.text for row in chunked(connection, texts, used - {None})}
    words[None] = ""
    depends = {number: depends_of(words[number]) for number in {row.depends_id for row in rows}}
    return [
        (
            row.night_id,
            Figure(
                identities[row.series_id], row.value, words[row.word_id], row.low, row.high, row.tolerance,
                words[row.trajectory_id], depends[row.depends_id], words[row.reason_id],
            ),
        )
        for row in rows
    ]  # fmt: skip


def chunked(connection: Connection, table: sa.Table, numbers: Iterable[int | None]) -> Iterable[Any]:
    """Rows of a table by their numbers."""
    wanted = sorted(number for number in numbers if number is not None)
    for first in range(0, len(wanted), CHUNK):
        some = wanted[first : first + CHUNK]
        yield from connection.execute(sa.select(table).where(table.c.id.in_(some)))
