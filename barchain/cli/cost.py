"""`barchain cost`: what accuracy costs in time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from barchain.cli.common.exit_codes import end_study
from barchain.cli.common.numbers import ORBITS
from barchain.cli.common.options import (
    engine_option,
    minutes_option,
    optional_scenes,
    out_option,
    overwrite_option,
    repeats_option,
    resume_option,
    time_limit_option,
    timed_alone,
)
from barchain.cli.common.result_folder import run_study_in
from barchain.cli.common.terminal import say
from barchain.studies.defaults import COST

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path


@click.command(short_help="Measure errors against run times.")
@optional_scenes
@engine_option("all that are installed, also those that only studies need")
@out_option()
@click.option("--orbits", metavar="N", type=ORBITS, default=1.0, show_default=True,
              help="Run each scene for this many orbits from its start, or to its end.")  # fmt: skip
@repeats_option(COST.repeats)
@minutes_option(COST.minutes, more="; each setting is run once in any case")
@time_limit_option(COST.time_limit_s, more=", and leave out a run that is expected to take longer")
@resume_option
@overwrite_option
@timed_alone
def cost(
    scenes: tuple[str, ...], names: tuple[str, ...], out: Path, orbits: float, repeats: int, minutes: float,
    time_limit: float, resume: bool, overwrite: bool,
) -> None:  # fmt: skip
    """Measure errors and run times of every setting of every engine.

    SCENEs are names, files or folders; default: those of paper/. Errors are against the certified solution. Exits with
    1 if an engine fails at all of its settings in a scene, if an engine that was named runs in none of the scenes, or
    if nothing is measured.
    """
    from barchain.cli.common.progress import verdicts_shown  # noqa: PLC0415
    from barchain.studies.cost.plan import CostOptions  # noqa: PLC0415  # statistics no other command needs
    from barchain.studies.cost.study import CostStudy  # noqa: PLC0415
    from barchain.studies.study import Reporter  # noqa: PLC0415

    study = CostStudy()
    plan = study.plan(CostOptions(scenes or None, names or None, orbits, repeats, minutes, time_limit))
    with verdicts_shown(plan.turns) as show:
        result, rendered = run_study_in(out, study, plan, Reporter(show, show.note), resume=resume, overwrite=overwrite)
    say(f"cost study: {rendered.page}")
    report_idle(result.idle)
    end_study(result, result.failures)


def report_idle(idle: Mapping[str, str]) -> None:
    """Print which engines were left out, and why."""
    for name, reason in idle.items():
        say(f"{name} is left out: {reason}", err=True)
