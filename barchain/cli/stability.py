"""`barchain stability`: stability of engines on hard scenes."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING

import click

from barchain.cli.common.exit_codes import end_study
from barchain.cli.common.numbers import NamedPath
from barchain.cli.common.options import (
    OWN_PAGE,
    engine_option,
    executor_options,
    optional_scenes,
    out_option,
    overwrite_option,
    resume_option,
    time_limit_option,
)
from barchain.cli.common.result_folder import run_study_in
from barchain.cli.common.terminal import say
from barchain.studies.defaults import STABILITY_LIMIT_S

if TYPE_CHECKING:
    from barchain.runs.executors import Executor
    from barchain.studies.stability.plan import StabilityPlan
    from barchain.studies.stability.study import StabilityResult


@click.command(short_help="Classify the stability of engines in hard scenes.")
@optional_scenes
@engine_option("the engines marked so in `barchain engines`, and SciPy's solvers")
@out_option(help_text=OWN_PAGE)
@time_limit_option(STABILITY_LIMIT_S, more="; a run of a form of the reference after ten times that")
@executor_options
@click.option("--full", is_flag=True,
              help="Run pairs that take minutes too, e.g. NumPy in long scenes.")  # fmt: skip
@resume_option
@overwrite_option
@click.option("--accept", "accepted", metavar="FILE", type=NamedPath(path_type=Path, dir_okay=False),
              help="Record these outcomes as expected in this file, and keep those of other pairs there.")  # fmt: skip
def stability(
    scenes: tuple[str, ...], names: tuple[str, ...], out: Path, time_limit: float, executor: Executor, full: bool,
    resume: bool, overwrite: bool, accepted: Path | None,
) -> None:  # fmt: skip
    """Run every engine on every hard scene at three settings, and classify its stability.

    SCENEs are names, files or folders; default: all of hard/ but those tagged huge. Exits with 1 if a form of the
    reference is not stable in a well-posed scene, or if an outcome differs from the recorded one.
    """
    from barchain.cli.common.progress import verdicts_shown  # noqa: PLC0415
    from barchain.studies.stability.study import StabilityStudy  # noqa: PLC0415  # what no other command needs
    from barchain.studies.study import Reporter  # noqa: PLC0415

    plan = plan_of(scenes, names, time_limit, executor, full=full)
    if accepted:
        check_accepted(accepted)
    with verdicts_shown(plan.turns) as show:
        reporter = Reporter(show, show.note)
        result, rendered = run_study_in(out, StabilityStudy(), plan, reporter, resume=resume, overwrite=overwrite)
    show_result(result)
    if accepted:
        accept(result, accepted)
    say(f"stability: {rendered.page}")
    end_study(dataclasses.replace(result, changes=()) if accepted else result, result.failures)


def plan_of(
    scenes: tuple[str, ...], names: tuple[str, ...], time_limit: float, executor: Executor, *, full: bool
) -> StabilityPlan:
    """Plan of a study."""
    from barchain.studies.stability.plan import StabilityOptions  # noqa: PLC0415
    from barchain.studies.stability.study import StabilityStudy  # noqa: PLC0415

    return StabilityStudy().plan(StabilityOptions(scenes, names, time_limit, executor, full))


def check_accepted(file: Path) -> None:
    """Reject a file that can't take the outcomes, before anything runs."""
    from barchain.cli.common.result_folder import need_writable  # noqa: PLC0415
    from barchain.studies.stability import expected  # noqa: PLC0415

    expected.recorded(file)
    need_writable(file, "--accept")


def show_result(result: StabilityResult) -> None:
    """Print how many ended how, what changed, and where the reference is not stable."""
    from collections import Counter  # noqa: PLC0415

    counts = Counter(str(f.stability) for f in result.findings.values())
    say(", ".join(f"{count} {outcome}" for outcome, count in counts.most_common()))
    for changed in result.changes:
        say(changed.words)
    for scene, engine in result.ours:
        found = result.findings[scene, engine]
        say(f"{scene}  {engine} must be stable, and is {found.stability}: {found.reason}")


def accept(result: StabilityResult, file: Path) -> None:
    """Record the outcomes of shipped scenes in a file."""
    from barchain.studies.stability import expected  # noqa: PLC0415
    from scenarios import scene_names  # noqa: PLC0415

    shipped = set(scene_names())
    expected.accept({pair: f for pair, f in result.findings.items() if pair[0] in shipped}, file)
    say(f"recorded in {file}")
