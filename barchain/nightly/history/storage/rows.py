"""Figures as rows of the store, and back."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import sqlalchemy as sa

from barchain.nightly.history.model.figures import Figure
from barchain.nightly.history.storage.tables import figures, series, texts
from barchain.nightly.history.storage.vocabulary import depends_of, depends_text, identity_of, pieces

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence, Set

    from sqlalchemy import ColumnElement, Connection

    from barchain.nightly.history.model.figures import FigureIdentity

NUMBERS = ("value", "low", "high", "tolerance")
WORDS = ("word", "trajectory", "reason")
FIGURE_COLUMNS = ("series_id", *NUMBERS, *(f"{name}_id" for name in WORDS), "depends_id")
"""Columns of a figure that are the same on every night on which the figure is the same"""


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
    columns = [getattr(figures.c, name) for name in FIGURE_COLUMNS]
    query = sa.select(figures.c.night_id, *columns).join(series).where(chosen)
    rows = connection.execute(query.order_by(figures.c.series_id, figures.c.night_id)).all()
    made = figures_of(connection, {row[1:] for row in rows})
    return [(row[0], made[row[1:]]) for row in rows]


def figures_of(connection: Connection, rows: Set[tuple[Any, ...]]) -> dict[tuple[Any, ...], Figure]:
    """Figure of each row of :data:`FIGURE_COLUMNS`. Most figures are the same on many nights, and are made once."""
    identities = {row.id: identity_of(row) for row in chunked(connection, series, {row[0] for row in rows})}
    used = {number for row in rows for number in row[-4:]}
    words: dict[int | None, str] = {row.id: row.text for row in chunked(connection, texts, used - {None})}
    words[None] = ""
    depends = {number: depends_of(words[number]) for number in {row[-1] for row in rows}}
    return {
        row: Figure(
            identities[number],
            value,
            words[word],
            low,
            high,
            tolerance,
            words[trajectory],
            depends[depending],
            words[reason],
        )
        for row in rows
        for number, value, low, high, tolerance, word, trajectory, reason, depending in (row,)
    }


def chunked(connection: Connection, table: sa.Table, numbers: Iterable[int | None]) -> Iterable[Any]:
    """Rows of a table by their numbers."""
    for some in pieces(sorted(number for number in numbers if number is not None)):
        yield from connection.execute(sa.select(table).where(table.c.id.in_(some)))
