"""Histories of both kinds: an SQLite file, and a database of a real PostgreSQL server."""

from __future__ import annotations

import itertools
import time
import warnings
from typing import TYPE_CHECKING

import pytest
import sqlalchemy as sa

from barchain.nightly.history.store import open_store
from tests.support.machine import need_postgresql

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from barchain.nightly.history.store import NightStore

NUMBERS = itertools.count()


@pytest.fixture(scope="session")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Address of a PostgreSQL server, which ends with the session."""
    need_postgresql()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it asks for a runtime folder that a container lacks
        import pgserver

        running = pgserver.get_server(tmp_path_factory.mktemp("pg"), cleanup_mode="delete")
    address = running.get_uri().replace("postgresql://", "postgresql+psycopg://")
    wait_for(address)
    for setting in ("fsync", "full_page_writes", "synchronous_commit"):  # no power is cut here
        command(address, f"ALTER SYSTEM SET {setting} = off")
    command(address, "SELECT pg_reload_conf()")
    yield address
    running.cleanup()


@pytest.fixture(params=["sqlite", "postgresql"])
def url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Address of a history that does not exist yet."""
    if request.param == "sqlite":
        return str(tmp_path / "history.sqlite")
    return new_database(request.getfixturevalue("server"))


@pytest.fixture
def store(url: str) -> Iterator[NightStore]:
    """Empty history."""
    with open_store(url, create=True) as opened:
        yield opened


def wait_for(server: str, within_s: float = 60.0) -> None:
    """Wait until the server takes connections: on a busy machine it rejects them for some seconds after its start."""
    end = time.monotonic() + within_s
    while True:
        try:
            command(server, "SELECT 1")
        except sa.exc.OperationalError:
            if time.monotonic() > end:
                raise
            time.sleep(0.5)
        else:
            return


def command(server: str, text: str) -> None:
    """Run a command on the server, outside a transaction."""
    engine = sa.create_engine(server, isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        connection.execute(sa.text(text))
    engine.dispose()


def new_database(server: str) -> str:
    """Address of an empty database of the server."""
    name = f"history_{next(NUMBERS)}"
    command(server, f"CREATE DATABASE {name}")
    return server.replace("/postgres?", f"/{name}?")
