"""`barchain roundoff`: digits of the reactions in absolute and in relative coordinates."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from barchain.cli.common.exit_codes import end_study
from barchain.cli.common.numbers import RealNumber
from barchain.cli.common.options import executor_options, out_option, overwrite_option, resume_option
from barchain.cli.common.result_folder import run_study_in
from barchain.cli.common.terminal import say

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.runs.executors import Executor

PARTS = ("evaluation", "trajectories", "engines", "times")


@click.command(short_help="Measure the digits left in absolute and relative coordinates.")
@out_option()
@click.option("--part", "parts", multiple=True, metavar="PART", type=click.Choice(PARTS), default=PARTS,
              help=f"Run this part of the study: {', '.join(PARTS)}. May be repeated; default: all four.")  # fmt: skip
@click.option("--size", "sizes", multiple=True, metavar="R", type=RealNumber(0.0, 1.0, min_open=True),
              help="Judge one evaluation at this size: a bar's length over the Earth's radius, a power of ten. May be "
                   "repeated; default: eleven sizes from 1e-2 to 1e-12.")  # fmt: skip
@click.option("--full", is_flag=True, help="Take all sizes, arithmetics and numbers of bars, finer steps, longer runs.")
@executor_options
@resume_option
@overwrite_option
def roundoff(
    out: Path, parts: tuple[str, ...], sizes: tuple[float, ...], full: bool, executor: Executor, resume: bool,
    overwrite: bool,
) -> None:  # fmt: skip
    """Measure the digits of the reactions that absolute and relative coordinates leave.

    Exits with 1 if a task fails.
    """
    from barchain.cli.common.progress import verdicts_shown  # noqa: PLC0415
    from barchain.studies.roundoff.study import RoundoffOptions, RoundoffStudy  # noqa: PLC0415  # multiple precision
    from barchain.studies.study import Reporter  # noqa: PLC0415

    study = RoundoffStudy()
    try:
        plan = study.plan(RoundoffOptions(parts, full, executor, sizes))
    except ValueError as error:
        raise click.UsageError(f"--size: {error}") from error
    with verdicts_shown(plan.turns) as show:
        result, rendered = run_study_in(out, study, plan, Reporter(show, show.note), resume=resume, overwrite=overwrite)
    say(f"round-off study: {rendered.page}")
    end_study(result, result.failures)
