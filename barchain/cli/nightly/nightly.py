"""`barchain nightly`: a plan inside a budget, its place in the history, and what it changed."""

from __future__ import annotations

import contextlib
import os
import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from barchain.cli.common.numbers import NamedPath, RealNumber
from barchain.cli.common.options import programs_option
from barchain.cli.common.result_folder import need_writable
from barchain.cli.common.terminal import say
from barchain.cli.nightly.documents import (
    PAGE,
    baseline_night,
    baseline_option,
    end_night,
    fail_option,
    junit_option,
    publish,
    require_option,
    show_night,
    write_documents,
)
from barchain.cli.nightly.options import history_option, opened, say_left_out
from barchain.nightly.errors import HistoryError, need_extra
from barchain.nightly.figures.storage import VARIABLE

if TYPE_CHECKING:
    from collections.abc import Iterator

    from barchain.nightly.running.jobs import NightJob
    from barchain.nightly.running.night import NightProgress
    from barchain.nightly.running.plan import NightPlan
    from reports.results.nights.document import PartResult

LEAST_MINUTES, MOST_MINUTES = 0.5, 1440.0


@click.command(short_help="Run a plan within a budget of time, and report what changed.")
@click.option("--plan", "path", metavar="FILE", type=NamedPath(path_type=Path),
              help="Do this plan; default: the one that comes with barchain, see `--show-plan`.")  # fmt: skip
@click.option("--minutes", metavar="M", type=RealNumber(LEAST_MINUTES, MOST_MINUTES),
              help="Give the night a budget of this wall time, in minutes; default: that of the plan.")  # fmt: skip
@programs_option
@history_option
@click.option("--out", metavar="DIR", type=NamedPath(path_type=Path, file_okay=False), default=Path("nights"),
              show_default=True, help="Keep the results of each night in a folder in DIR.")  # fmt: skip
@junit_option
@baseline_option
@fail_option
@require_option
@click.option("--list", "listed", is_flag=True, help="List the commands of tonight's parts, and run nothing.")
@click.option("--show-plan", "shown", is_flag=True, help="Print the plan file, and run nothing.")
def nightly(
    path: Path | None, minutes: float | None, url: str | None, out: Path, junit: Path | None, baseline: str | None,
    fail_on: str, need_history: bool, listed: bool, shown: bool,
) -> None:  # fmt: skip
    """Run a plan within a budget of time, add the night to the history, and tell what changed.

    Exits with 0 if nothing is worse, with 1 if something is, with 2 for bad input, and with 3 if the night is void (a
    planted fault was missed) or incomplete. An interrupted night goes on with the next call.
    """
    need_extra("junitparser")
    from barchain.nightly.running.plan import SHIPPED, load_plan  # noqa: PLC0415

    plan = load_plan(path)
    if shown:
        say((path or SHIPPED).read_text("utf-8").rstrip())
        return
    url = url or os.environ.get(VARIABLE) or str(out)
    if listed:
        for job in planned(plan, url):
            say(job.shown(out / "NIGHT" / job.name))
        return
    run_and_tell(plan, minutes or plan.file.minutes, url, out, junit, baseline, fail_on, need_history=need_history)


def planned(plan: NightPlan, url: str) -> tuple[NightJob, ...]:
    """Jobs of the next night."""
    from barchain.nightly.history.nights import last_run  # noqa: PLC0415
    from barchain.nightly.running.night import next_jobs  # noqa: PLC0415

    store = opened(url, create=True)
    return next_jobs(plan, last_run(store, plan.identity))


def run_and_tell(
    plan: NightPlan, minutes: float, url: str, out: Path, junit: Path | None, baseline: str | None, fail_on: str,
    *, need_history: bool = False,
) -> None:  # fmt: skip
    """Run the night, write its documents, and end with the exit code of what it found."""
    from barchain.nightly.history.judging import folded_night  # noqa: PLC0415
    from barchain.nightly.history.pruning import prune_runs  # noqa: PLC0415
    from barchain.nightly.running.budget import process_age_s  # noqa: PLC0415
    from barchain.nightly.running.night import run_night  # noqa: PLC0415

    begun = time.monotonic() - process_age_s()
    if junit is not None:
        need_writable(junit, "--junit")
    planned(plan, url)  # a wrong name in the plan is told before a history begins
    store = opened(url, create=True)
    if baseline is not None:
        baseline_night(store, baseline)  # a wrong name is told before anything runs
    store.place.need_writable()
    say_left_out(store)
    every = store.nights()
    if not every:
        say(f"history: begins in {store}", err=True)
    believed = [night for night in every if night.void is None]
    if believed:
        folded_night(store, believed[-1], every)  # a long history without levels takes a while: before the runs
    with shown_progress() as progress:
        ended = run_night(plan, minutes, store, out, progress, time.monotonic() - begun)
    with kept_without_documents(ended.name):
        facts = write_documents(store, ended.name, ended.folder, junit, baseline, fail_on, need_history=need_history)
        place = publish(store, ended.name, ended.folder)
    prune_runs(store, out)
    show_night(facts, place / PAGE)
    end_night(facts, fail_on, need_history=need_history)


@contextlib.contextmanager
def kept_without_documents(name: str) -> Iterator[None]:
    """Tell that a night is in the history where its documents can't be written."""
    try:
        yield
    except OSError as error:
        said = f"{error.filename}: {error.strerror}" if error.filename else str(error)
        remedy = f"`barchain history report {name}` writes the documents"
        raise HistoryError(f"{said}; the night is in the history, and {remedy}") from error


@contextlib.contextmanager
def shown_progress() -> Iterator[NightProgress]:
    """Progress of a night: a bar for the job on a terminal, a line for each job elsewhere."""
    from barchain.cli.common.progress import error_console, quiet  # noqa: PLC0415
    from barchain.nightly.running.night import NightProgress  # noqa: PLC0415

    console = error_console()
    if quiet():
        yield NightProgress()
        return
    if not console.is_terminal:

        def begun(name: str, number: int, total: int, limit_s: float) -> None:
            say(f"[{number}/{total}] {time.strftime('%H:%M:%S')}  {name}: at most {limit_s:.0f} s", err=True)

        yield NightProgress(lambda text: say(text, err=True), begun, end=lambda result: say(words(result), err=True))
        return
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn  # noqa: PLC0415

    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("night", total=None)

        def begin(name: str, number: int, total: int, limit_s: float) -> None:
            bar.reset(task, description=f"[{number}/{total}] {name}", total=limit_s)

        yield NightProgress(
            lambda text: bar.console.print(text, markup=False, highlight=False),
            begin,
            lambda done_s: bar.update(task, completed=done_s),
            lambda result: bar.console.print(words(result), markup=False, highlight=False),
        )


def words(result: PartResult) -> str:
    """Result of a job in one line."""
    reason = f": {result.reasons}" if result.reasons else ""
    left = f"; {len(result.left)} left for the next night" if result.left else ""
    return f"{result.name}: {result.shown_state} after {result.duration_s:.0f} s{reason}{left}"
