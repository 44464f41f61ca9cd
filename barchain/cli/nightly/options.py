"""The option of all commands on the history, and the history that it names."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from barchain.cli.common.numbers import WORDS

if TYPE_CHECKING:
    from barchain.nightly.history.store import NightStore

history_option = click.option(
    "--history",
    "url",
    metavar="URL",
    type=WORDS,
    help="Take this history: a file, or postgresql+psycopg://...; default: BARCHAIN_HISTORY, or a file in the user's "
    "data folder.",
)


def opened(url: str | None, *, create: bool = False) -> NightStore:
    """History of the option, the environment variable, or the user's data folder.

    Raises
    ------
    HistoryError
        If it can't be opened, or a package is missing.
    """
    from barchain.nightly.history.faults import need_extra  # noqa: PLC0415
    from barchain.nightly.history.location import default_url  # noqa: PLC0415

    need_extra()
    from barchain.nightly.history.store import open_store  # noqa: PLC0415  # SQLAlchemy

    return open_store(url or default_url(), create=create)


def exists(url: str | None) -> bool:
    """Whether a history is there; a server counts as being there."""
    from barchain.nightly.history.location import default_url, file_of, full_url  # noqa: PLC0415

    path = file_of(full_url(url or default_url()))
    return path is None or path.is_file()
