"""`barchain scaling`: what more bars cost."""

from __future__ import annotations

from pathlib import Path

import click

from barchain.record.command import typed
from barchain.studies.scaling.plan import BARS, MINUTES, REPEATS, TIME_LIMIT_S


@click.command()
@click.option(
    "--engine", "names", multiple=True, metavar="NAME", help="Engine to measure; may be repeated; all by default."
)
@click.option("--bars", multiple=True, type=click.IntRange(min=2), metavar="N", default=BARS,
              help=f"Number of bars; may be repeated; {BARS[0]} to {BARS[-1]} by default.")  # fmt: skip
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), default=Path("report"), show_default=True,
              help="Folder for tables and chapter; that of a comparison gets the chapter into its report.")  # fmt: skip
@click.option("--repeats", type=click.IntRange(min=1), default=REPEATS, show_default=True,
              help="Times that each point is measured.")  # fmt: skip
@click.option("--budget", "minutes", type=click.FloatRange(min=0), default=MINUTES, show_default=True,
              help="Minutes after which nothing more is begun.")  # fmt: skip
@click.option("--time-limit", type=click.FloatRange(min=0, min_open=True), default=TIME_LIMIT_S, show_default=True,
              help="Orbits expected to take longer, s, are run in part, or not at all.")  # fmt: skip
@click.option("--resume", is_flag=True, help="Go on from what an earlier, cut-off study of the same bars left.")
def scaling(
    names: tuple[str, ...], bars: tuple[int, ...], out: Path, repeats: int, minutes: float, time_limit: float,
    resume: bool,
) -> None:  # fmt: skip
    """Measure what more bars cost: time of an evaluation and of an orbit, and memory.

    The chain is the paper's 80° one, cut into N bars.
    """
    from barchain.cli.progress import verdicts_shown  # noqa: PLC0415
    from barchain.studies.scaling.study import ScalingOptions, ScalingStudy  # noqa: PLC0415  # statistics no other command needs
    from barchain.studies.study import Reporter, run_study  # noqa: PLC0415
    from reports.render import render_study  # noqa: PLC0415

    study = ScalingStudy()
    plan = study.plan(ScalingOptions(names or None, bars, repeats, minutes, time_limit))
    with verdicts_shown(plan.turns) as show:
        idle = run_study(study, plan, out, command=typed(), reporter=Reporter(show, show.note), resume=resume).idle
    click.echo(f"scaling study: {render_study('scaling', out).page}")
    for name, reason in idle.items():
        click.echo(f"{name} is left out: {reason}", err=True)
    if set(names) & set(idle):  # asked for by name, and not there
        raise click.exceptions.Exit(1)
