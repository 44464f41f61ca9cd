"""Store of nights behind one address: nights are added whole, read and pruned."""

from __future__ import annotations

import datetime
from typing import TYPE_CHECKING, Any, Self

import sqlalchemy as sa

from barchain.nightly.history.faults import HistoryError, UnknownNightError
from barchain.nightly.history.model.figures import Night
from barchain.nightly.history.model.series_model import NightSummary
from barchain.nightly.history.storage.connection import connected, shown, told, writing
from barchain.nightly.history.storage.rows import figure_rows, read_figures
from barchain.nightly.history.storage.tables import (
    acceptances,
    attributions,
    environments,
    figures,
    night_parts,
    nights,
    parts,
    runs,
    series,
    texts,
    told_changes,
)
from barchain.nightly.history.storage.vocabulary import (
    environment_number,
    environment_of,
    link_parts,
    parts_by_night,
    series_numbers,
    text_numbers,
)
from scenarios.nearest import nearest

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence
    from types import TracebackType

    from sqlalchemy import ColumnElement, Connection, Engine, Select

    from barchain.nightly.run_facts import NightRun

LATEST = "latest"
"""Name that stands for the last night"""


class NightStore:
    """Nights behind one address."""

    def __init__(self, given: str, engine: Engine) -> None:
        """Take an engine whose tables are there; :func:`open_store` makes it."""
        self.given, self.engine = given, engine

    def __enter__(self) -> Self:
        """Store as it is."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        """Close all connections."""
        self.engine.dispose()

    def __str__(self) -> str:
        """Address without its password."""
        return shown(self.given)

    def add(self, night: Night, replaces: str | None = None, run: NightRun | None = None) -> bool:
        """Add a night in one transaction.

        Parameters
        ----------
        night : Night
        replaces : str, optional
            Name of an incomplete night that this one goes on from, and that is removed in the same transaction.
        run : NightRun, optional
            What the night did of its plan.

        Returns
        -------
        bool
            Whether it was added: False of a night that is there already.

        Raises
        ------
        HistoryError
            If it can't be written, and then nothing is changed; or if the replaced night is complete.
        """
        with told(self.given), writing(self.engine) as connection:
            if replaces is not None and replaces != night.name:
                remove_incomplete(connection, replaces)
                rename_night(connection, replaces, night.name)
            return add_night(connection, night, run)

    def nights(self, last: int | None = None) -> tuple[NightSummary, ...]:
        """Nights in the order of their starts, all or the `last` ones."""
        with told(self.given), self.engine.connect() as connection:
            newest = summaries().order_by(nights.c.started.desc(), nights.c.id.desc()).limit(last)
            return summarised(connection, connection.execute(newest).all()[::-1])

    def summary(self, name: str) -> NightSummary:
        """Night by its name, the beginning of it, or ``latest``.

        Raises
        ------
        UnknownNightError
            If there is none, or several; the message gives the nearest name.
        """
        with told(self.given), self.engine.connect() as connection:
            number = night_number(connection, name)
            return summarised(connection, connection.execute(summaries().where(nights.c.id == number)).all())[0]

    def night(self, name: str) -> Night:
        """Whole night; errors as :meth:`summary`."""
        known = self.summary(name)
        with told(self.given), self.engine.connect() as connection:
            found = read_figures(connection, figures.c.night_id == known.number)
        return Night(
            known.started, known.duration_s, known.plan, known.barchain, known.environment, known.parts,
            tuple(figure for _, figure in found), known.commit, known.complete, known.void,
        )  # fmt: skip

    def prune(
        self, keep: int | None = None, before: datetime.datetime | None = None, spared: Collection[str] = ()
    ) -> tuple[str, ...]:
        """Remove nights, and all rows that only they used.

        Parameters
        ----------
        keep : int, optional
            Number of the latest nights that stay.
        before : datetime, optional
            Nights that started before are removed.
        spared : collection of str
            Names of nights that stay.

        Returns
        -------
        tuple of str
            Names of the removed nights: those that both rules remove, where both are given.
        """
        with told(self.given), writing(self.engine) as connection:
            chosen = sa.select(nights.c.id, nights.c.name).order_by(*latest_first())
            if before is not None:
                chosen = chosen.where(nights.c.started < before)
            if keep is not None:
                kept = sa.select(nights.c.id).order_by(*latest_first()).limit(keep)
                chosen = chosen.where(nights.c.id.not_in(kept))
            gone = [row for row in connection.execute(chosen) if row.name not in spared]
            remove(connection, [row.id for row in gone])
        return tuple(row.name for row in reversed(gone))


def open_store(given: str, *, create: bool = False) -> NightStore:
    """Open a history.

    Parameters
    ----------
    given : str
        Path of an SQLite file, ``sqlite:///PATH`` or ``postgresql+psycopg://...``.
    create : bool
        Make it if there is none.

    Raises
    ------
    HistoryError
        If it can't be opened; the message is one line.
    """
    return NightStore(given, connected(given, create=create))


def add_night(connection: Connection, night: Night, run: NightRun | None = None) -> bool:
    """Add a night and all that belongs to it; False if it is there already."""
    there = sa.select(nights.c.id).where(nights.c.identity == night.identity)
    if connection.execute(there).first() is not None:
        return False
    row = {
        "identity": night.identity, "name": night.name, "started": night.started, "duration_s": night.duration_s,
        "plan": night.plan, "barchain": night.barchain, "source_commit": night.commit, "complete": night.complete,
        "void": night.void, "environment_id": environment_number(connection, night.environment),
        "figures": len(night.figures),
    }  # fmt: skip
    connection.execute(sa.insert(nights), [row])
    number = connection.execute(there).scalar_one()
    link_parts(connection, number, night.parts)
    known = series_numbers(connection, (figure.identity for figure in night.figures))
    rows = figure_rows(night.figures, number, known, lambda wanted: text_numbers(connection, wanted))
    if rows:
        connection.execute(sa.insert(figures), rows)
    if run is not None:
        connection.execute(sa.insert(runs), [{"night_id": number, "plan": run.plan, "content": run.to_json()}])
    return True


def remove_incomplete(connection: Connection, name: str) -> None:
    """Remove the night that another goes on from."""
    number = night_number(connection, name)
    if connection.execute(sa.select(nights.c.complete).where(nights.c.id == number)).scalar_one():
        raise HistoryError(f"{name}: is complete, and no other night replaces it")
    remove(connection, [number])


def rename_night(connection: Connection, old: str, new: str) -> None:
    """Let changes, acceptances, attributions and what was told begin with the night that replaces another one."""
    connection.execute(sa.delete(told_changes).where(told_changes.c.night == old))  # the new night tells them itself
    for table in (told_changes, acceptances, attributions):
        connection.execute(sa.update(table).where(table.c.since == old).values(since=new))


def remove(connection: Connection, numbers: Sequence[int]) -> None:
    """Remove nights, and the rows that no other night uses."""
    for number in numbers:
        for table in (figures, night_parts):
            connection.execute(sa.delete(table).where(table.c.night_id == number))
        connection.execute(sa.delete(nights).where(nights.c.id == number))
    if not numbers:
        return
    used = sa.union(*(sa.select(figures.c[c]).where(figures.c[c].is_not(None)) for c in
                      ("word_id", "trajectory_id", "reason_id", "depends_id")))  # fmt: skip
    connection.execute(sa.delete(texts).where(texts.c.id.not_in(used)))
    for table, column in ((series, figures.c.series_id), (parts, night_parts.c.part_id)):
        connection.execute(sa.delete(table).where(table.c.id.not_in(sa.select(column))))
    connection.execute(sa.delete(environments).where(environments.c.id.not_in(sa.select(nights.c.environment_id))))


def latest_first() -> tuple[ColumnElement[Any], ...]:
    """Order of nights from the latest one on; nights that start later than now, by a wrong clock, come at the end."""
    now = datetime.datetime.now(datetime.UTC)
    return sa.case((nights.c.started > now, 1), else_=0), nights.c.started.desc(), nights.c.id.desc()


def summaries() -> Select[Any]:
    """Query of nights with their environments."""
    own = [c.label(f"night_{c.name}") for c in nights.c]
    below = [c for c in environments.c if c.name != "id"]
    return sa.select(*own, *below).join(environments, nights.c.environment_id == environments.c.id)


def summarised(connection: Connection, rows: Sequence[Any]) -> tuple[NightSummary, ...]:
    """Nights of the rows of :func:`summaries`."""
    own = parts_by_night(connection, [row.night_id for row in rows])
    return tuple(
        NightSummary(
            r.night_id, r.night_name, r.night_started, r.night_duration_s, r.night_plan, r.night_barchain,
            environment_of(r), own[r.night_id], r.night_figures, r.night_source_commit, r.night_complete, r.night_void,
        )
        for r in rows
    )  # fmt: skip


def night_number(connection: Connection, name: str) -> int:
    """Number of a night by its name, as :meth:`NightStore.summary`."""
    if name == LATEST:
        last = sa.select(nights.c.id).order_by(*latest_first()).limit(1)
        found = connection.execute(last).scalar()
        if found is None:
            raise UnknownNightError(f"{name}: the history holds no nights")
        return int(found)
    known = {row.name: row.id for row in connection.execute(sa.select(nights.c.name, nights.c.id))}
    fitting = [name] if name in known else [each for each in known if name and each.startswith(name)]
    if len(fitting) == 1:
        return int(known[fitting[0]])
    if fitting:
        raise UnknownNightError(f"{name[:60]}: {len(fitting)} nights begin so, e.g. {fitting[0]} and {fitting[1]}")
    if not known:
        raise UnknownNightError(f"{name[:60]}: no such night; the history holds no nights")
    raise UnknownNightError(f"{name[:60]}: no such night{nearest(name, known)}; `barchain history list` shows all")
