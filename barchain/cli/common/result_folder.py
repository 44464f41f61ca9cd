"""A study run into a result folder; obstacles that are told before the first run: other results, unwritable files."""

from __future__ import annotations

import os
from functools import partial
from typing import TYPE_CHECKING

import click

from barchain.cli.common.exit_codes import findings
from barchain.cli.common.terminal import say
from barchain.record.environment import typed

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.studies.study import ResultT_co, Study, StudyResult
    from reports.render import Rendered


def run_shown(out: Path | None, study: Study[ResultT_co], kept: dict[str, bool]) -> tuple[ResultT_co, Rendered]:
    """Run a study into a result folder with its progress shown, and render it.

    Without a folder it is a temporary one; `kept` are the arguments ``resume`` and ``overwrite``. Results of other
    commands that the study's page will include are read first.

    Raises
    ------
    UsageError
        If the study is to go on without a folder.
    """
    from barchain.cli.common.progress import verdicts_shown
    from barchain.runs.environment import kept_or_temporary
    from barchain.studies.study import run_and_render
    from reports.render import check_others, render_study

    if kept["resume"] and out is None:
        raise click.UsageError("--resume goes with --out DIR")
    name = study.files.study
    with kept_or_temporary(out) as folder:
        check_others(name, folder)
        with verdicts_shown(getattr(study, "turns", None)) as reporter:
            return run_and_render(
                study, folder, partial(render_study, name), command=typed(), reporter=reporter, **kept
            )


def end_study(result: StudyResult, page: Path | None = None) -> None:
    """Print what a study left out, its failures and its page; exit code 1 if it did not pass."""
    for engine, reason in getattr(result, "idle", {}).items():
        say(f"{engine} is left out: {reason}", err=True)
    if page is not None:
        say(f"report: {page}")
    for line in getattr(result, "failures", ()):
        say(f"barchain: {line}", err=True)
    if not result.passed:
        raise findings()


def need_writable(file: Path, option: str) -> None:
    """Make sure that a file can be written when the runs are done.

    Raises
    ------
    UsageError
        If its folder is missing, or the system takes no file there.
    """
    from reports.results.writing import NEW, PART, need_ordinary

    if not file.parent.is_dir():
        raise click.UsageError(f"{option} {file}: there is no folder {file.parent}")
    half = file.with_name(file.name + PART)  # as the writer of the file
    try:
        need_ordinary(file)
        half.unlink(missing_ok=True)
        os.close(os.open(half, NEW, 0o666))
        half.unlink()
    except OSError as error:
        raise click.UsageError(f"{option} {file}: no file can be written there ({error.strerror})") from error
