"""The store of nights behind one URL: SQLite in a file, or PostgreSQL where several machines report."""

from __future__ import annotations

import contextlib
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa
from alembic import command
from alembic.config import Config
from alembic.script import ScriptDirectory
from alembic.util import CommandError
from platformdirs import user_data_path
from sqlalchemy.dialects import postgresql, sqlite

from barchain.history.errors import HistoryError
from barchain.history.figures import CodePart, Figure, FigureKind, FigureUnit, Night, Series
from barchain.history.tables import FIGURE, NAME, NIGHT, PART, SERIES
from scenarios import nearest

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

PLACE = "BARCHAIN_HISTORY"
"""Environment variable: URL of the store"""
PATIENCE_S = 60  # of a writer while another one writes
DIALECTS = ("sqlite", "postgresql")
UPGRADE_LOCK = 5_127_002  # any number, the same in every barchain: PostgreSQL's name of the lock of an upgrade
INSERTED = 500  # rows of a statement: SQLite takes 32 766 parameters


def default_url() -> str:
    """URL from the environment, or a file in the user's folder of data."""
    given = os.environ.get(PLACE)
    if given:
        return given
    return f"sqlite:///{user_data_path('barchain') / 'history.sqlite'}"


@dataclass(frozen=True)
class NightSummary:
    """One night in a list."""

    id: str
    started: str
    machine: str
    barchain: str
    complete: bool
    void: str
    figures: int


class HistoryStore:
    """The store, open. Every method is one transaction: a kill at any instant leaves it whole or not begun."""

    def __init__(self, url: str | None = None) -> None:
        """Open a store; the first use makes its tables.

        Parameters
        ----------
        url : str, optional
            ``sqlite:///file`` or ``postgresql+psycopg://...``; a plain path is a SQLite file. By default
            `default_url`.

        Raises
        ------
        HistoryError
            If the URL or the database can't be used, or a newer barchain made the tables.
        """
        self.url = parsed_url(url or default_url())
        self.shown = self.url.render_as_string(hide_password=True)
        with self.told():
            self.engine = engine_of(self.url)
        try:
            self.upgrade()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Close all connections."""
        self.engine.dispose()

    def __enter__(self) -> HistoryStore:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @contextlib.contextmanager
    def told(self) -> Iterator[None]:
        """Tell errors of the database in one line."""
        try:
            yield
        except (sa.exc.SQLAlchemyError, CommandError, OSError) as error:
            cause = getattr(error, "orig", None) or error
            said = " ".join(str(cause).split())[:300]
            raise HistoryError(f"{self.shown}: {said}") from error

    @contextlib.contextmanager
    def transaction(self, *, writes: bool = False) -> Iterator[sa.Connection]:
        """One transaction; a writer takes the database's lock at its start."""
        with self.told(), self.engine.connect().execution_options(writes=writes) as connection, connection.begin():
            yield connection

    def upgrade(self) -> None:
        """Bring the tables to this barchain's form.

        Raises
        ------
        HistoryError
            If a newer barchain made them.
        """
        with self.transaction(writes=True) as connection:
            if self.engine.dialect.name == "postgresql":
                connection.execute(sa.select(sa.func.pg_advisory_xact_lock(UPGRADE_LOCK)))
            found = revision_of(connection)
            scripts = ScriptDirectory.from_config(alembic_config(connection))
            if found == scripts.get_current_head():
                return
            if found is not None and found not in {script.revision for script in scripts.walk_revisions()}:
                said = f"{self.shown}: made by a newer barchain (form {found})"
                raise HistoryError(f"{said}; install that, or give another store")
            command.upgrade(alembic_config(connection), "head")

    def add(self, night: Night) -> bool:
        """Add a night; False if it is there already.

        Raises
        ------
        HistoryError
            If it can't be written; nothing of it is there then.
        """
        with self.transaction(writes=True) as connection:
            row = {c.name: getattr(night, c.name) for c in NIGHT.columns}
            row["environment"] = json.dumps(night.environment, sort_keys=True)
            if not connection.execute(self.insert(NIGHT).returning(NIGHT.c.id), row).all():
                return False
            parts = [{"night": night.id, "name": p.name, "version": p.version, "digest": p.digest} for p in night.parts]
            if parts:
                connection.execute(sa.insert(PART), parts)
            ids = self.series_ids(connection, {figure.series for figure in night.figures})
            rows = [figure_row(night.id, ids[figure.series], figure) for figure in night.figures]
            for k in range(0, len(rows), INSERTED):
                connection.execute(sa.insert(FIGURE), rows[k : k + INSERTED])
        return True

    def insert(self, table: sa.Table) -> Any:
        """Insertion that leaves out rows that are there, in the words of the database."""
        made = postgresql.insert(table) if self.engine.dialect.name == "postgresql" else sqlite.insert(table)
        return made.on_conflict_do_nothing()

    def series_ids(self, connection: sa.Connection, wanted: set[Series]) -> dict[Series, int]:
        """Numbers of series; those that are not there are made, in one order, so that two writers can't lock out."""
        known = known_series(connection)
        missing = sorted(wanted - known.keys())
        for k in range(0, len(missing), INSERTED):
            connection.execute(self.insert(SERIES), [series_row(series) for series in missing[k : k + INSERTED]])
        return known_series(connection) if missing else known

    def nights(self, machine: str | None = None) -> list[NightSummary]:
        """All nights in order of time, or those of one class of machines."""
        count = sa.select(FIGURE.c.night, sa.func.count().label("figures")).group_by(FIGURE.c.night).subquery()
        names = (NIGHT.c.id, NIGHT.c.started, NIGHT.c.machine, NIGHT.c.barchain, NIGHT.c.complete, NIGHT.c.void)
        asked = sa.select(*names, sa.func.coalesce(count.c.figures, 0)).join_from(
            NIGHT, count, NIGHT.c.id == count.c.night, isouter=True
        )
        if machine is not None:
            asked = asked.where(NIGHT.c.machine == machine)
        with self.transaction() as connection:
            return [NightSummary(*row) for row in connection.execute(asked.order_by(NIGHT.c.started, NIGHT.c.id))]

    def find(self, name: str) -> str:
        """Id of a night by the beginning of its id, or ``latest``.

        Raises
        ------
        HistoryError
            If there is none, or several.
        """
        ids = [night.id for night in self.nights()]
        if name == "latest" and ids:
            return ids[-1]
        found = [each for each in ids if name and each.startswith(name)]
        if len(found) == 1:
            return found[0]
        if found:
            raise HistoryError(f"{name}: the beginning of {len(found)} nights: {', '.join(found[:5])}")
        hint = nearest(name, ids) if ids else ": the history is empty"
        raise HistoryError(f"no night {name[:40]}{hint}")

    def night(self, name: str) -> Night:
        """Night by its id, with all figures; errors as :meth:`find`."""
        found = self.find(name)
        with self.transaction() as connection:
            row = connection.execute(sa.select(NIGHT).where(NIGHT.c.id == found)).one()._mapping
            columns = PART.c.name, PART.c.version, PART.c.digest
            parts = connection.execute(sa.select(*columns).where(PART.c.night == found))
            asked = sa.select(SERIES, FIGURE).join_from(FIGURE, SERIES).where(FIGURE.c.night == found)
            figures = [figure_of(each._mapping) for each in connection.execute(asked)]
            entries = {key: value for key, value in row.items() if key not in ("id", "environment")}
            return Night(
                **entries,
                environment=json.loads(row["environment"]),
                parts=tuple(CodePart(*each) for each in parts),
                figures=tuple(figures),
            )

    def values(self, machine: str | None = None) -> list[tuple[str, Figure]]:
        """Night and figure of every value in the store, in order of time."""
        asked = sa.select(SERIES, FIGURE).join_from(FIGURE, SERIES).join(NIGHT, NIGHT.c.id == FIGURE.c.night)
        if machine is not None:
            asked = asked.where(NIGHT.c.machine == machine)
        with self.transaction() as connection:
            rows = connection.execute(asked.order_by(NIGHT.c.started, NIGHT.c.id))
            return [(row._mapping[FIGURE.c.night], figure_of(row._mapping)) for row in rows]

    def values_of(self, series: Iterable[Series]) -> list[tuple[str, Figure]]:
        """Night and figure of every value of some series, in order of time."""
        with self.transaction() as connection:
            known = known_series(connection)
            ids = [known[each] for each in series if each in known]
            asked = sa.select(SERIES, FIGURE).join_from(FIGURE, SERIES).join(NIGHT, NIGHT.c.id == FIGURE.c.night)
            rows = connection.execute(asked.where(FIGURE.c.series.in_(ids)).order_by(NIGHT.c.started, NIGHT.c.id))
            return [(row._mapping[FIGURE.c.night], figure_of(row._mapping)) for row in rows]

    def prune(self, keep: int) -> list[str]:
        """Delete all but the latest nights; ids of the deleted ones."""
        if keep < 1:
            raise HistoryError(f"--keep-nights {keep}: at least 1")
        old = [night.id for night in self.nights()][:-keep]
        with self.transaction(writes=True) as connection:
            for k in range(0, len(old), INSERTED):
                connection.execute(sa.delete(NIGHT).where(NIGHT.c.id.in_(old[k : k + INSERTED])))
            connection.execute(sa.delete(SERIES).where(SERIES.c.id.not_in(sa.select(FIGURE.c.series))))
        return old


def parsed_url(given: str) -> sa.URL:
    """URL of a store.

    Raises
    ------
    HistoryError
        If it is none, or of another database.
    """
    text = given if "://" in given else f"sqlite:///{given}"
    try:
        url = sa.make_url(text)
    except sa.exc.ArgumentError:
        raise HistoryError(f"{given[:80]}: no URL; allowed: sqlite:///FILE, postgresql+psycopg://...") from None
    if url.get_backend_name() not in DIALECTS:
        raise HistoryError(f"{given[:80]}: allowed: sqlite:///FILE, postgresql+psycopg://...")
    return url


def engine_of(url: sa.URL) -> sa.Engine:
    """Engine of SQLAlchemy; a SQLite file waits for another writer, and keeps its readers reading."""
    if url.get_backend_name() == "postgresql":
        return sa.create_engine(url)
    if url.database and url.database != ":memory:":
        Path(url.database).parent.mkdir(parents=True, exist_ok=True)
    engine = sa.create_engine(url, connect_args={"timeout": PATIENCE_S})

    @sa.event.listens_for(engine, "connect")
    def prepare(connection: Any, _: object) -> None:
        connection.isolation_level = None  # transactions begin where SQLAlchemy says, also for tables
        for setting in ("journal_mode=WAL", "foreign_keys=ON", "synchronous=FULL"):
            connection.execute(f"PRAGMA {setting}")

    @sa.event.listens_for(engine, "begin")
    def begin(connection: sa.Connection) -> None:
        writes = connection.get_execution_options().get("writes")
        connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")

    return engine


def alembic_config(connection: sa.Connection) -> Config:
    """Configuration of Alembic, without a file."""
    made = Config()
    made.set_main_option("script_location", str(Path(__file__).parent / "migrations"))
    made.set_main_option("path_separator", "os")
    made.attributes["connection"] = connection
    return made


def revision_of(connection: sa.Connection) -> str | None:
    """Form of the tables; None of an empty database."""
    if not sa.inspect(connection).has_table("alembic_version"):
        return None
    found: str | None = connection.execute(sa.text("select version_num from alembic_version")).scalar()
    return found


def known_series(connection: sa.Connection) -> dict[Series, int]:
    """Numbers of all series."""
    rows = connection.execute(sa.select(SERIES))
    return {series_of(row._mapping): row._mapping["id"] for row in rows}


def series_of(row: Mapping[Any, Any]) -> Series:
    """Series of a row."""
    words = {name: row[SERIES.c[name]] for name in NAME}
    return Series(**words | {"kind": FigureKind(words["kind"]), "unit": FigureUnit(words["unit"])})


def series_row(series: Series) -> dict[str, str]:
    """Row of a series."""
    return {name: str(getattr(series, name)) for name in NAME}


def figure_row(night: str, series: int, figure: Figure) -> dict[str, Any]:
    """Row of a figure."""
    own = {name: getattr(figure, name) for name in ("value", "word", "low", "high", "roundoff", "reason")}
    return own | {"night": night, "series": series, "parts": ",".join(figure.parts)}


def figure_of(row: Mapping[Any, Any]) -> Figure:
    """Figure of a row of the joined tables."""
    own = {name: row[FIGURE.c[name]] for name in ("value", "word", "low", "high", "roundoff", "reason")}
    return Figure(series_of(row), **own, parts=tuple(filter(None, row[FIGURE.c.parts].split(","))))
