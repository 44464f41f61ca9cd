"""`barchain stability`: whether engines stay stable where scenes are hard."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from barchain.record.command import typed
from barchain.studies.stability.limits import TIME_LIMIT_S

if TYPE_CHECKING:
    from barchain.studies.stability.plan import StabilityPlan
    from barchain.studies.stability.run import StabilityResult

FAILED = 1


@click.command()
@click.argument("scenes", metavar="[SCENE]...", nargs=-1)
@click.option("--engine", "names", multiple=True, metavar="NAME",
              help="Engine to run; may be repeated; the everyday ones and SciPy's solvers by default.")  # fmt: skip
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), default=Path("report"), show_default=True,
              help="Folder for tables and page.")  # fmt: skip
@click.option("--time-limit", type=click.FloatRange(min=0, min_open=True), default=TIME_LIMIT_S, show_default=True,
              help="Wall time allowed to one run, s; ten times that to a form of the reference.")  # fmt: skip
@click.option("--workers", type=click.IntRange(min=1), help="Processes side by side; all cores by default.")
@click.option("--resume", is_flag=True, help="Go on from what an earlier, cut-off study left in the folder.")
@click.option("--accept", "accepted", is_flag=True, help="Record these outcomes as the expected ones.")
def stability(
    scenes: tuple[str, ...], names: tuple[str, ...], out: Path, time_limit: float, workers: int | None, resume: bool,
    accepted: bool,
) -> None:  # fmt: skip
    """Run every engine on every hard scene at three settings, and say how it fares there.

    SCENEs are names or files; all of hard/ by default but those tagged huge. Ends with exit code 1 if a form of the
    reference is not stable in a well-posed scene, or if an outcome is not the one recorded.
    """
    from barchain.cli.progress import verdicts_shown  # noqa: PLC0415
    from barchain.studies.stability.study import StabilityStudy  # noqa: PLC0415  # what no other command needs
    from barchain.studies.study import Reporter, run_study  # noqa: PLC0415
    from reports.render import render_study  # noqa: PLC0415

    plan = plan_of(scenes, names, time_limit, workers)
    with verdicts_shown(plan.turns) as show:
        reporter = Reporter(show, show.note)
        result = run_study(StabilityStudy(), plan, out, command=typed(), reporter=reporter, resume=resume)
    page = render_study("stability", out).page
    show_result(result)
    if accepted:
        accept(result)
    click.echo(f"stability: {page}")
    if result.ours or (result.changes and not accepted):
        raise click.exceptions.Exit(FAILED)


def plan_of(scenes: tuple[str, ...], names: tuple[str, ...], time_limit: float, workers: int | None) -> StabilityPlan:
    """What is asked for."""
    from barchain.studies.stability.study import StabilityOptions, StabilityStudy  # noqa: PLC0415

    plan = StabilityStudy().plan(StabilityOptions(scenes, names, time_limit, workers))
    for name, registration in plan.engines.items():
        if registration.missing:
            raise click.UsageError(f"--engine {name}: {registration.missing}")
    return plan


def show_result(result: StabilityResult) -> None:
    """Print how many ended how, what changed, and where ours are not stable."""
    from collections import Counter  # noqa: PLC0415

    counts = Counter(str(f.stability) for f in result.findings.values())
    click.echo(", ".join(f"{count} {outcome}" for outcome, count in counts.most_common()))
    for changed in result.changes:
        click.echo(changed.words)
    for scene, engine in result.ours:
        found = result.findings[scene, engine]
        click.echo(f"{scene}  {engine} must be stable, and is {found.stability}: {found.reason}")


def accept(result: StabilityResult) -> None:
    """Record the outcomes of shipped scenes."""
    from barchain.studies.stability import expected  # noqa: PLC0415
    from scenarios import scene_names  # noqa: PLC0415

    shipped = set(scene_names())
    expected.accept({pair: f for pair, f in result.findings.items() if pair[0] in shipped})
    click.echo(f"recorded in {expected.PATH}")
