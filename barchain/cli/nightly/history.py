"""`barchain history`: nights as they are added, listed, shown, exported and pruned."""

from __future__ import annotations

import dataclasses
import datetime
import json
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from barchain.cli.common.numbers import WORDS, NamedPath, RealNumber
from barchain.cli.common.options import json_option
from barchain.cli.common.result_folder import need_writable
from barchain.cli.common.terminal import say, show_rows
from barchain.cli.nightly.changes import accept_change, accepted_changes, changes, withdraw_acceptance
from barchain.cli.nightly.documents import killed_nights, report_night, results_site, tell_night
from barchain.cli.nightly.options import history_option, opened, say_left_out
from barchain.nightly.errors import HistoryError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from barchain.nightly.figures.figure import Figure, FigureIdentity, Night, NightSummary

MOST_NIGHTS = 1_000_000
MOST_DAYS = 36_525.0
"""A century"""
NIGHT_HEADINGS = ("night", "state", "figures", "duration", "plan", "barchain", "machine class")
FIGURE_HEADINGS = ("figure", "kind", "result", "unit", "interval", "rounding", "reason")


@click.group(invoke_without_command=True, short_help="Show, export, accept and prune what nights measured.")
@click.pass_context
def history(ctx: click.Context) -> None:
    """Keep what nights measured: add result folders, show nights and their changes, follow a figure, export, prune.

    Nights come from `barchain nightly` and `barchain history add`. docs/howto/history.md describes the figures and the
    rules of change.
    """
    if ctx.invoked_subcommand is None:
        say(ctx.get_help())


@history.command("add")
@click.argument("folders", metavar="DIR...", nargs=-1, required=True, type=NamedPath(path_type=Path))
@history_option
def add(folders: tuple[Path, ...], url: str | None) -> None:
    """Add the results in each DIR as a night; a night that is there already stays as it is."""
    from barchain.nightly.figures.results import read_night  # noqa: PLC0415
    from scenarios.plural import plural  # noqa: PLC0415

    nights = [read_night(folder) for folder in folders]  # all are read before one is added
    store = opened(url, create=True)
    known = {night.name for night in store.nights()}
    for folder in folders:
        if (name := folder.absolute().parent.name) in known:
            raise HistoryError(f"{folder}: a part of the night {name}, which is there already")
    for folder, night in zip(folders, nights, strict=True):
        done = "added" if store.add(night) else "already there"
        say(f"{folder}: {night.name}, {plural(len(night.figures), 'figure')}: {done}")


@history.command("list")
@history_option
@json_option
def list_nights(url: str | None, as_json: bool) -> None:
    """List all nights in the order of their starts."""
    store = opened(url)
    say_left_out(store)
    for name in killed_nights(store):
        say(f"{name}: was begun and did not end; the next `barchain nightly` goes on with it, or adds it", err=True)
    nights = store.nights()
    if as_json:
        print_json([night_values(night) for night in nights])
        return
    rows = [
        (n.name, n.state, str(n.figures), f"{n.duration_s:.0f} s", n.plan, n.barchain, n.environment.machine_class)
        for n in nights
    ]
    show_rows(NIGHT_HEADINGS, rows, right=("figures", "duration"))


@history.command("show")
@click.argument("night", metavar="NIGHT", type=WORDS)
@history_option
@json_option
def show(night: str, url: str | None, as_json: bool) -> None:
    """Show environment, parts and figures of NIGHT: a name, its beginning, or `latest`."""
    store = opened(url)
    found = store.night(night)
    if as_json:
        print_json(night_values(found))
        return
    for name, text in heading(found):
        say(f"{name:<14} {text}")
    show_rows(("part", "version", "digest"), [(p.name, p.version, p.digest or "unknown") for p in found.parts])
    show_rows(FIGURE_HEADINGS, map(figure_row, found.figures), right=("result",))


@history.command("series")
@click.argument("figure", metavar="FIGURE", type=WORDS)
@history_option
@json_option
def series(figure: str, url: str | None, as_json: bool) -> None:
    """Show FIGURE over the nights: scene:engine:setting:quantity, in which * stands for any text.

    A night without the figure, since the first that had it, has the reason.
    """
    store = opened(url)
    known, nights = store.series(figure), store.nights()
    gaps = {night.name: f"not measured; the night is {night.state}" for night in nights}
    gaps |= {name: f"left out: {reason}" for name, reason in store.left_out().items()}
    found = {identity: with_gaps(identity, own, gaps) for identity, own in known.items()}
    if as_json:
        starts = {night.name: night.started.isoformat() for night in nights}
        print_json([series_values(*each, starts) for each in found.items()])
        return
    for identity, own in found.items():
        say(identity.name)
        rows = []
        for _, some in groupby(own, lambda one: one[1].reason if one[1].missing else one[0]):  # a gap is one row
            (night, shown), *others = some
            rows.append((f"{1 + len(others)} from {night}" if others else night, *figure_row(shown)[2:]))
        show_rows(("night", *FIGURE_HEADINGS[2:]), rows, right=("result",))


@history.command("export")
@click.option("--parquet", "path", metavar="FILE", type=NamedPath(path_type=Path, dir_okay=False), required=True,
              help="Write a row for each figure of each night into this file.")  # fmt: skip
@history_option
def export(path: Path, url: str | None) -> None:
    """Export all figures of all nights as one table; a baseline to be kept is a copy of a night's folder."""
    from barchain.nightly.history.nights import export_parquet  # noqa: PLC0415
    from scenarios.plural import plural  # noqa: PLC0415

    store = opened(url)
    need_writable(path, "--parquet")
    say_left_out(store)
    say(f"{path}: {plural(export_parquet(store, path), 'figure')}")


@history.command("prune")
@click.option("--keep-nights", "keep", metavar="N", type=click.IntRange(1, MOST_NIGHTS),
              help="Keep the last N nights, and remove the earlier ones.")  # fmt: skip
@click.option("--older-than", "days", metavar="DAYS", type=RealNumber(0.0, MOST_DAYS),
              help="Remove nights that started more than this number of days ago; with --keep-nights none of the "
                   "last N.")  # fmt: skip
@history_option
def prune(keep: int | None, days: float | None, url: str | None) -> None:
    """Remove old nights; accepted changes stay, and so do nights that a change for the worse is compared with."""
    from barchain.nightly.history.pruning import needed_nights  # noqa: PLC0415
    from scenarios.plural import plural  # noqa: PLC0415

    if keep is None and days is None:
        raise click.UsageError("give --keep-nights N, --older-than DAYS, or both")
    before = None if days is None else datetime.datetime.now(datetime.UTC) - datetime.timedelta(days=days)
    store = opened(url)
    gone = store.prune(keep, before, needed_nights(store))
    say(f"{store}: {plural(len(gone), 'night')} removed{f', {gone[0]} to {gone[-1]}' if gone else ''}")


history.add_command(changes)
history.add_command(accept_change)
history.add_command(accepted_changes)
history.add_command(withdraw_acceptance)
history.add_command(report_night)
history.add_command(tell_night)
history.add_command(results_site)


def heading(night: Night) -> list[tuple[str, str]]:
    """Lines about a whole night."""
    own = night.environment
    return [
        ("night", night.name),
        ("state", night.summary().state),
        ("started", night.started.isoformat()),
        ("duration", f"{night.duration_s:.1f} s"),
        ("plan", night.plan),
        ("barchain", night.barchain + (f", commit {night.commit}" if night.commit else "")),
        ("machine class", own.machine_class),
        ("processor", f"{own.cpu}, {own.cores} cores, {own.architecture}"),
        ("system", f"{own.kernel}, {own.libc}"),
        ("BLAS", own.blas or "unknown"),
        ("Python", own.python),
    ]


def figure_row(figure: Figure) -> tuple[str, ...]:
    """Cells of a figure."""
    low, high = (number_words(end) for end in (figure.low, figure.high))
    result = "missing" if figure.missing else figure.word or number_words(figure.value)
    interval = f"{low or '?'} to {high or '?'}" if low or high else ""
    identity = figure.identity
    rounding = number_words(figure.tolerance)
    return identity.name, str(identity.kind), result, str(identity.unit), interval, rounding, figure.reason


def number_words(value: float | None) -> str:
    """Number as text; empty without one."""
    return "" if value is None else f"{value:.6g}"


def night_values(night: Night | NightSummary) -> dict[str, Any]:
    """Night as JSON holds it."""
    values = dataclasses.asdict(night) | {"name": night.name, "started": night.started.isoformat()}
    return values | {"machine_class": night.environment.machine_class}


def with_gaps(
    identity: FigureIdentity, own: Sequence[tuple[NightSummary, Figure]], gaps: Mapping[str, str]
) -> list[tuple[str, Figure]]:
    """Figure on all nights since its first one, by their names: missing on the others, with the reasons in `gaps`."""
    from barchain.nightly.figures.figure import Figure  # noqa: PLC0415

    there = {night.name: figure for night, figure in own}
    since = own[0][0].name
    return [
        (night, there.get(night) or Figure(identity, reason=reason))
        for night, reason in sorted(gaps.items()) if night >= since
    ]  # fmt: skip


def series_values(
    identity: FigureIdentity, found: Sequence[tuple[str, Figure]], starts: Mapping[str, str]
) -> dict[str, Any]:
    """Figure over the nights, as JSON holds it; the start of a night that is left out is not known."""
    figures = [dataclasses.asdict(figure) | {"night": night, "started": starts.get(night)} for night, figure in found]
    for figure in figures:
        figure.pop("identity")
    return dataclasses.asdict(identity) | {"name": identity.name, "figures": figures}


def print_json(values: Sequence[Any] | dict[str, Any]) -> None:
    """Print values as JSON."""
    say(json.dumps(values, indent=2))
