"""`barchain history`: figures of earlier nights."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from barchain.cli.common.numbers import NamedPath
from barchain.cli.common.terminal import say, show_rows

if TYPE_CHECKING:
    from barchain.history.figures import Figure
    from barchain.history.store import HistoryStore

SHOWN_DIGITS = 6

url_option = click.option(
    "--history", "url", metavar="URL", help="Store: sqlite:///FILE, a file, or postgresql+psycopg://...; default: "
    "BARCHAIN_HISTORY, else a file in the user's folder of data.")  # fmt: skip
night_argument = click.argument("night", metavar="NIGHT")


@click.group()
def history() -> None:
    """Keep the figures of result folders, and show them night by night."""


@history.command("add")
@click.argument("folders", metavar="DIR...", nargs=-1, required=True, type=NamedPath(path_type=Path))
@url_option
def add(folders: tuple[Path, ...], url: str | None) -> None:
    """Add the comparison in each DIR; adding one twice changes nothing."""
    from barchain.history.folders import night_of  # noqa: PLC0415  # tables

    nights = [(folder, night_of(folder)) for folder in folders]  # all are read before one is added
    with opened(url) as store:
        for folder, night in nights:
            word = "added as" if store.add(night) else "is there already:"
            say(f"{folder} {word} {night.id}: {len(night.figures)} figures")


@history.command("list")
@url_option
def list_nights(url: str | None) -> None:
    """List all nights."""
    with opened(url) as store:
        nights = store.nights()
    rows = [
        (n.id, n.started, n.barchain, n.machine, str(n.figures), n.void or ("" if n.complete else "incomplete"))
        for n in nights
    ]
    show_rows(("night", "started", "barchain", "machine class", "figures", "note"), rows, right=("figures",))


@history.command("show")
@night_argument
@url_option
def show_night(night: str, url: str | None) -> None:
    """Show all figures of NIGHT: the beginning of an id, or latest."""
    with opened(url) as store:
        found = store.night(night)
    say(f"{found.id}, {found.started}, barchain {found.barchain}, machine class {found.machine}")
    say(", ".join(f"{part.name} {part.version}" for part in found.parts))
    rows = [(*map(str, names(figure)), value(figure)) for figure in found.figures]
    show_rows(("scene", "engine", "setting", "quantity", "metric", "value"), rows, right=("value",))


@history.command("export")
@click.option(
    "--parquet", "file", metavar="FILE", required=True, type=NamedPath(path_type=Path), help="Write this file."
)
@url_option
def export(file: Path, url: str | None) -> None:
    """Write every figure of every night as one table."""
    from barchain.cli.common.result_folder import need_writable  # noqa: PLC0415
    from barchain.history.export import table_of  # noqa: PLC0415
    from reports.tables.writing import parquet, write_atomically  # noqa: PLC0415

    need_writable(file, "--parquet")
    with opened(url) as store:
        table = table_of(store)
    write_atomically(file, parquet(table))
    say(f"wrote {file}: {len(table)} figures")


@history.command("prune")
@click.option(
    "--keep-nights", "keep", metavar="N", required=True, type=click.IntRange(min=1), help="Keep the latest N nights."
)
@url_option
def prune(keep: int, url: str | None) -> None:
    """Delete all but the latest nights."""
    with opened(url) as store:
        gone = store.prune(keep)
    say(f"deleted {len(gone)} nights")


def opened(url: str | None) -> HistoryStore:
    """Store behind a URL; a missing library ends the command in one line."""
    try:
        from barchain.history.store import HistoryStore  # noqa: PLC0415  # a database that no other command needs
    except ModuleNotFoundError as error:
        raise click.UsageError(f"{error.name} is not installed; try: pip install 'barchain[nightly]'") from error
    return HistoryStore(url)


def names(figure: Figure) -> tuple[str, ...]:
    """Columns that name a figure."""
    series = figure.series
    return series.scene, series.engine, series.setting, series.quantity, series.metric


def value(figure: Figure) -> str:
    """Value with its unit, or the reason why there is none."""
    if figure.word:
        return figure.word
    if figure.value is None:
        return f"missing: {figure.reason}"
    unit = "" if figure.series.unit == "1" else f" {figure.series.unit}"
    return f"{figure.value:.{SHOWN_DIGITS}g}{unit}"
