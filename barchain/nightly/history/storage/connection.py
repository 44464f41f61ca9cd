"""Connections to a history: SQLite in a file, or PostgreSQL; its tables are made or migrated when it is opened."""

from __future__ import annotations

import contextlib
import errno
import sqlite3
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa
from sqlalchemy import event
from sqlalchemy.exc import DBAPIError, SQLAlchemyError

from barchain.nightly.history.faults import HistoryError, NewerSchemaError
from barchain.nightly.history.location import file_of, full_url
from barchain.nightly.history.storage.tables import HEAD

if TYPE_CHECKING:
    from collections.abc import Iterator

    from sqlalchemy import Connection, Engine

BUSY_S = 60.0
"""Time that a writer waits for another; a night of 3000 figures takes less than a second"""
CONNECT_S = 10
CACHE_KIB = 65536
"""Pages of a file that stay in memory: with the default of 2 MiB a history of a thousand nights is read repeatedly"""
WRITES = "barchain_writes"
LOCK = 0x6261_7263
"""Number of the lock that writers into PostgreSQL hold until their transaction ends"""
VERSION = "alembic_version"
DISK = ("database or disk is full", "disk i/o error", "no space left", "could not extend file", "file too large")


def connected(given: str, *, create: bool) -> Engine:
    """Engine of a history whose tables are there.

    Parameters
    ----------
    given : str
        Path of an SQLite file, or address.
    create : bool
        Make the history if there is none.

    Raises
    ------
    HistoryError
        If there is none and it shall not be made, it can't be read, or is something else.
    NewerSchemaError
        If a later barchain wrote it.
    """
    url = full_url(given)
    path = file_of(url)
    if path is not None and not create and not path.is_file():
        raise HistoryError(f"{path}: no history there; `barchain nightly` and `barchain history add DIR` begin one")
    if path is not None and create:
        path.resolve().parent.mkdir(parents=True, exist_ok=True)
    with told(given):
        engine = new_engine(url)
    try:
        with told(given):
            prepare(engine, given)
    except BaseException:
        engine.dispose()
        raise
    return engine


def new_engine(url: str) -> Engine:
    """Engine whose transactions say whether they write."""
    if file_of(url) is None:
        return sa.create_engine(url, connect_args={"connect_timeout": CONNECT_S})
    engine = sa.create_engine(url, connect_args={"timeout": BUSY_S}, poolclass=sa.NullPool)
    event.listen(engine, "connect", set_pragmas)
    event.listen(engine, "begin", begin_sqlite)
    return engine


def set_pragmas(connection: Any, _: object) -> None:
    """Settings of an SQLite connection: readers beside a writer, references checked, transactions begun by hand."""
    connection.isolation_level = None
    cursor = connection.cursor()
    cursor.execute(f"PRAGMA busy_timeout = {int(1000 * BUSY_S)}")
    with contextlib.suppress(sqlite3.OperationalError):  # a file that can't be written is read as it is
        cursor.execute("PRAGMA journal_mode = WAL")
    cursor.execute("PRAGMA synchronous = FULL")
    cursor.execute("PRAGMA foreign_keys = ON")
    cursor.execute(f"PRAGMA cache_size = -{CACHE_KIB}")
    cursor.close()


def begin_sqlite(connection: Connection) -> None:
    """Begin a transaction; a writer takes its lock at once, as two readers that begin to write would block."""
    writes = connection.get_execution_options().get(WRITES, False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")


@contextlib.contextmanager
def writing(engine: Engine) -> Iterator[Connection]:
    """Transaction of a writer: one at a time, and whole or not at all."""
    with engine.connect().execution_options(**{WRITES: True}) as connection, connection.begin():
        if connection.dialect.name == "postgresql":
            connection.execute(sa.select(sa.func.pg_advisory_xact_lock(LOCK)))
        yield connection


def prepare(engine: Engine, given: str) -> None:
    """Make or migrate the tables."""
    with engine.connect() as connection:
        found = revision(connection)
    if found == HEAD:
        return
    from barchain.nightly.history.storage.migrating import known_revisions, upgrade  # noqa: PLC0415  # Alembic, only where needed

    with writing(engine) as connection:
        found = revision(connection)  # another process may have been faster
        if found is not None and found not in known_revisions():
            said = f"{shown(given)}: a later barchain wrote this history (revision {found[:20]}; this one knows {HEAD})"
            raise NewerSchemaError(f"{said}; update barchain")
        if found is None and sa.inspect(connection).get_table_names():
            raise HistoryError(f"{shown(given)}: a database with other tables, no history of barchain")
        if found != HEAD:
            upgrade(connection)


def revision(connection: Connection) -> str | None:
    """Revision of a history's tables; None of an empty database."""
    if not sa.inspect(connection).has_table(VERSION):
        return None
    found = connection.execute(sa.text(f"SELECT version_num FROM {VERSION}")).scalar()
    return None if found is None else str(found)


@contextlib.contextmanager
def told(given: str) -> Iterator[None]:
    """Turn the database's errors into one line each."""
    try:
        yield
    except DBAPIError as error:
        raise HistoryError(f"{shown(given)}: {reason(error)}") from error
    except SQLAlchemyError as error:
        raise HistoryError(f"{shown(given)}: {first_line(error)}") from error
    except OSError as error:
        if error.errno != errno.ENOSPC:
            raise
        raise HistoryError(f"{shown(given)}: the disk is full; nothing was changed") from error


def reason(error: DBAPIError) -> str:
    """Cause of a database's error in words."""
    said = first_line(error.orig or error)
    low = said.lower()
    if any(word in low for word in DISK):
        return f"the disk is full ({said}); nothing was changed"
    if "database is locked" in low:
        return f"another process writes for more than {BUSY_S:g} s; nothing was changed"
    if "readonly" in low or "read-only" in low:
        return f"can't be written ({said}); nothing was changed"
    if "not a database" in low or "malformed" in low:
        return f"is no history of barchain, or damaged ({said})"
    return f"can't be used ({said})"


def first_line(error: object) -> str:
    """First line of an error's message."""
    return (str(error).strip().splitlines() or [type(error).__name__])[0][:300]


def shown(given: str) -> str:
    """Address without its password."""
    url = full_url(given)
    path = file_of(url)
    if path is not None:
        return str(path)
    try:
        return sa.make_url(url).render_as_string(hide_password=True)
    except SQLAlchemyError:
        return "the history's address"
