"""`barchain scaling`: cost of a run and of an evaluation against the number of bars."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from barchain.cli.common.exit_codes import end_study
from barchain.cli.common.numbers import MOST_BARS
from barchain.cli.common.options import (
    engine_option,
    minutes_option,
    out_option,
    overwrite_option,
    repeats_option,
    resume_option,
    time_limit_option,
    timed_alone,
)
from barchain.cli.common.result_folder import run_study_in
from barchain.cli.common.terminal import say
from barchain.cli.cost import report_idle
from barchain.studies.defaults import BARS, SCALING

if TYPE_CHECKING:
    from pathlib import Path


@click.command(short_help="Measure time and memory against the number of bars.")
@engine_option("all that are installed, also those that only studies need")
@click.option("--bars", multiple=True, type=click.IntRange(2, MOST_BARS), metavar="N", default=BARS,
              help=f"Cut the chain into N bars. May be repeated; default: 2 to {BARS[-1]}.")  # fmt: skip
@out_option()
@repeats_option(SCALING.repeats)
@minutes_option(SCALING.minutes, more="; nothing more is begun after it")
@time_limit_option(
    SCALING.time_limit_s, more=", and run an orbit that is expected to take longer in part, or not at all"
)
@resume_option
@overwrite_option
@timed_alone
def scaling(
    names: tuple[str, ...], bars: tuple[int, ...], out: Path, repeats: int, minutes: float, time_limit: float,
    resume: bool, overwrite: bool,
) -> None:  # fmt: skip
    """Measure time and memory against the number of bars.

    The times are those of an evaluation and of an orbit. The chain is that of paper/fig05, cut into N bars. Exits with
    1 if an engine fails at every number of bars, if an engine that was named does not run at all, or if nothing is
    measured.
    """
    from barchain.cli.common.progress import verdicts_shown  # noqa: PLC0415
    from barchain.studies.scaling.study import ScalingOptions, ScalingStudy  # noqa: PLC0415  # statistics no other needs
    from barchain.studies.study import Reporter  # noqa: PLC0415

    study = ScalingStudy()
    plan = study.plan(ScalingOptions(names or None, bars, repeats, minutes, time_limit))
    with verdicts_shown(plan.turns) as show:
        result, rendered = run_study_in(out, study, plan, Reporter(show, show.note), resume=resume, overwrite=overwrite)
    say(f"scaling study: {rendered.page}")
    report_idle(result.idle)
    end_study(result, result.failures)
