"""Place of the history: a file or a server, by option, environment variable or default."""

from __future__ import annotations

import os
from pathlib import Path

VARIABLE = "BARCHAIN_HISTORY"
FILE = "history.sqlite"
SQLITE, POSTGRESQL = "sqlite:///", "postgresql+psycopg://"
PLAIN_POSTGRESQL = ("postgresql://", "postgres://")
ALLOWED = f"a path, {SQLITE}PATH, or {POSTGRESQL}USER@HOST/NAME"


def default_url() -> str:
    """Address of the history where none is given: by the environment variable, else in the user's data folder."""
    from platformdirs import user_data_path  # noqa: PLC0415

    return os.environ.get(VARIABLE) or str(user_data_path("barchain") / FILE)


def full_url(given: str) -> str:
    """Address with its scheme: a path is that of an SQLite file.

    Raises
    ------
    HistoryError
        If the scheme is another than those allowed.
    """
    from barchain.nightly.history.faults import HistoryError  # noqa: PLC0415

    for short in PLAIN_POSTGRESQL:
        if given.startswith(short):
            return POSTGRESQL + given.removeprefix(short)
    if given.startswith(POSTGRESQL):
        return given
    path = given.removeprefix(SQLITE) if given.startswith(SQLITE) else given
    if "://" in path or not path.strip():
        raise HistoryError(f"history {given.partition('://')[0]}: no such kind of address; allowed: {ALLOWED}")
    return f"{SQLITE}{Path(path).expanduser()}"


def file_of(url: str) -> Path | None:
    """File of an SQLite history; None of a server."""
    return Path(url.removeprefix(SQLITE)) if url.startswith(SQLITE) else None
