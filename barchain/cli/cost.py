"""`barchain cost`: what accuracy costs in time."""

from __future__ import annotations

from pathlib import Path

import click

from barchain.record.command import typed
from barchain.studies.cost.plan import MINUTES, REPEATS, TIME_LIMIT_S


@click.command()
@click.argument("scenes", metavar="[SCENE]...", nargs=-1)
@click.option(
    "--engine", "names", multiple=True, metavar="NAME", help="Engine to measure; may be repeated; all by default."
)
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), default=Path("report"), show_default=True,
              help="Folder for tables and chapter; that of a comparison gets the chapter into its report.")  # fmt: skip
@click.option("--orbits", type=click.FloatRange(min=0, min_open=True), default=1.0, show_default=True,
              help="How much of each scene is run, from its start.")  # fmt: skip
@click.option("--repeats", type=click.IntRange(min=1), default=REPEATS, show_default=True,
              help="Times that each point is measured.")  # fmt: skip
@click.option("--budget", "minutes", type=click.FloatRange(min=0), default=MINUTES, show_default=True,
              help="Minutes aimed at: repeats, then long runs are given up; each setting is run once.")  # fmt: skip
@click.option("--time-limit", type=click.FloatRange(min=0, min_open=True), default=TIME_LIMIT_S, show_default=True,
              help="Runs expected to take longer, s, are left out.")  # fmt: skip
@click.option("--markdown", is_flag=True, help="Print the table of speed ratios as Markdown.")
@click.option("--resume", is_flag=True, help="Go on from what an earlier, cut-off study left in the folder.")
def cost(
    scenes: tuple[str, ...], names: tuple[str, ...], out: Path, orbits: float, repeats: int, minutes: float,
    time_limit: float, markdown: bool, resume: bool,
) -> None:  # fmt: skip
    """Measure what accuracy costs: errors against the oracle and times, for every setting of every engine.

    SCENEs are names or files; the paper's by default, each over its first orbit.
    """
    from barchain.cli.progress import verdicts_shown  # noqa: PLC0415
    from barchain.studies.cost.study import CostOptions, CostStudy  # noqa: PLC0415  # statistics no other command needs
    from barchain.studies.study import Reporter, run_study  # noqa: PLC0415
    from reports.render import render_study  # noqa: PLC0415

    study = CostStudy()
    plan = study.plan(CostOptions(scenes or None, names or None, orbits, repeats, minutes, time_limit))
    with verdicts_shown(plan.turns) as show:
        result = run_study(study, plan, out, command=typed(), reporter=Reporter(show, show.note), resume=resume)
    page, ratios = render_study("cost", out)
    if markdown and ratios:
        click.echo(ratios.read_text(encoding="utf-8"))
    click.echo(f"cost study: {page}", err=markdown)
    idle = result.idle
    for name, reason in idle.items():
        click.echo(f"{name} is left out: {reason}", err=True)
    if set(names) & set(idle):  # asked for by name, and not there
        raise click.exceptions.Exit(1)
