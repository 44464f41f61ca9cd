"""Obstacles to the end of a command that are told before its first run: unreadable results, unwritable files."""

from __future__ import annotations

import os
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from barchain.record.environment import typed

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.studies.study import PlanT, Reporter, ResultT_co, Study
    from reports.render import Rendered


def run_shown(
    out: Path, study: Study[Any, PlanT, ResultT_co], plan: PlanT, *, turns: int | None = None, **kept: bool
) -> tuple[ResultT_co, Rendered]:
    """Run a study into a result folder with its progress shown, and render it, as :func:`run_study_in`.

    Without a number of `turns` the study counts by itself.
    """
    from barchain.cli.common.progress import counted, verdicts_shown
    from barchain.studies.study import Reporter

    if turns is None:
        return run_study_in(out, study, plan, Reporter(counted=counted), **kept)
    with verdicts_shown(turns) as show:
        return run_study_in(out, study, plan, Reporter(show, show.note), **kept)


def run_study_in(
    out: Path, study: Study[Any, PlanT, ResultT_co], plan: PlanT, reporter: Reporter, **kept: bool
) -> tuple[ResultT_co, Rendered]:
    """Run a study into a result folder and render it, as :func:`barchain.studies.study.run_and_render`.

    Results of other commands that the study's page will include are read first.
    """
    from barchain.studies.study import run_and_render
    from reports.render import check_others, render_study

    name = study.files.name
    check_others(name, out)
    return run_and_render(study, plan, out, partial(render_study, name), command=typed(), reporter=reporter, **kept)


def need_kept(out: Path | None, *, resume: bool) -> None:
    """Make sure that a command that goes on has a folder to go on in.

    Raises
    ------
    UsageError
        If not.
    """
    if resume and out is None:
        raise click.UsageError("--resume goes with --out DIR")


def need_writable(file: Path, option: str) -> None:
    """Make sure that a file can be written when the runs are done.

    Raises
    ------
    UsageError
        If its folder is missing, or the system takes no file there.
    """
    from reports.tables.writing import NEW, PART, need_ordinary

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
