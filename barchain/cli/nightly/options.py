"""The option of all commands on the history, and the history that it names."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from barchain.cli.common.numbers import WORDS
from barchain.cli.common.terminal import say
from barchain.nightly.errors import need_extra
from barchain.nightly.figures.storage import default_url

if TYPE_CHECKING:
    from barchain.nightly.history.nights import NightStore

history_option = click.option(
    "--history",
    "url",
    metavar="URL",
    type=WORDS,
    help="Take this history: a folder of nights, or its address, e.g. s3://...; default: BARCHAIN_HISTORY, or the "
    "folder nights.",
)


def opened(url: str | None, *, create: bool = False) -> NightStore:
    """History of the option, the environment variable, or the folder ``nights``.

    Raises
    ------
    HistoryError
        If it can't be opened, or a package is missing.
    """
    need_extra()
    from barchain.nightly.history.nights import open_store  # noqa: PLC0415

    return open_store(url or default_url(), create=create)


def say_left_out(store: NightStore) -> None:
    """Say which nights, and which files of nights, do not count, each with the reason; all files are read."""
    from barchain.nightly.history.news import left_out  # noqa: PLC0415

    store.check()
    for name, reason in left_out(store).items():
        say(f"{name}: left out: {reason}", err=True)
