"""`barchain roundoff`: what absolute and relative coordinates leave of the reactions' digits."""

from __future__ import annotations

from pathlib import Path

import click

from barchain.record.command import typed

PARTS = ("evaluation", "trajectories", "engines", "times")


@click.command()
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), default=Path("report"), show_default=True,
              help="Folder for tables and chapter; that of a comparison gets the chapter into its report.")  # fmt: skip
@click.option("--part", "parts", multiple=True, type=click.Choice(PARTS), default=PARTS,
              help="Part of the study; may be repeated; all by default.")  # fmt: skip
@click.option("--full", is_flag=True, help="All sizes, arithmetics and numbers of bars, finer steps, longer runs.")
@click.option("--workers", type=click.IntRange(min=1), help="Processes side by side; all cores by default.")
def roundoff(out: Path, parts: tuple[str, ...], full: bool, workers: int | None) -> None:
    """Measure how many digits of the reactions each kind of coordinates leaves, and at which size the last one goes."""
    from barchain.cli.progress import verdicts_shown  # noqa: PLC0415
    from barchain.studies.roundoff.study import RoundoffOptions, RoundoffStudy  # noqa: PLC0415  # multiple precision no other command needs
    from barchain.studies.study import Reporter, run_study  # noqa: PLC0415
    from reports.render import render_study  # noqa: PLC0415

    study = RoundoffStudy()
    plan = study.plan(RoundoffOptions(parts, full, workers))
    with verdicts_shown(plan.turns) as show:
        run_study(study, plan, out, command=typed(), reporter=Reporter(show, show.note))
    click.echo(f"round-off study: {render_study('roundoff', out).page}")
