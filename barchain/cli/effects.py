"""`barchain effects`: what each effect is worth in a scene."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import click

from barchain.record.command import typed
from barchain.studies.effects.limits import FAST, MATTERS, REPEATS, RTOL, RTOLS, SECONDS, SLOW

if TYPE_CHECKING:
    from rich.table import Table

    from reports.chapters.effects.view import EffectsTable, EffectsView

SCREEN, WORDS, NUMBERS = 120, 20, 28  # columns of the screen, and at most of a cell of words or of numbers


@click.command()
@click.argument("scene", metavar="SCENE")
@click.option("--out", type=click.Path(path_type=Path, file_okay=False),
              help="Folder for table and page; that of a comparison gets the chapter into its report.")  # fmt: skip
@click.option("--rtol", type=click.FloatRange(*RTOLS), default=RTOL, show_default=True,
              help="Accuracy of a step; what the numerics leave is told by a run ten times looser.")  # fmt: skip
@click.option("--matters", type=click.FloatRange(0.0, 1.0, min_open=True), default=MATTERS, show_default=True,
              help="Change from which an effect matters: rad of attitude, share of the largest reaction, share of "
                   "the initial distance from the centre.")  # fmt: skip
@click.option("--engine", type=click.Choice([FAST, SLOW]),
              help="Form of the reference that runs all; by default the compiled one where it can.")  # fmt: skip
@click.option("--repeats", type=click.IntRange(min=1), default=REPEATS, show_default=True,
              help="Times that each run is timed.")  # fmt: skip
@click.option("--budget", "seconds", type=click.FloatRange(min=0), default=SECONDS, show_default=True,
              help="Seconds after which no further round of timing is begun.")  # fmt: skip
@click.option("--workers", type=click.IntRange(min=1), help="Processes side by side; all cores by default.")
def effects(
    scene: str, out: Path | None, rtol: float, matters: float, engine: str | None, repeats: int, seconds: float,
    workers: int | None,
) -> None:  # fmt: skip
    """Measure what each effect is worth in SCENE, on or off there: its size, what it changes, what it costs.

    Effects that the scene does not have are switched on with stated defaults. SCENE is a name or a file.
    """
    from barchain.cli.progress import verdicts_shown  # noqa: PLC0415
    from barchain.studies.effects.study import EffectsOptions, EffectsStudy  # noqa: PLC0415  # statistics no other command needs
    from barchain.studies.study import Reporter, run_study  # noqa: PLC0415
    from reports.chapters.effects.view import view_effects  # noqa: PLC0415
    from reports.render import render_study  # noqa: PLC0415
    from scenarios import load_scene  # noqa: PLC0415

    need(engine)
    study = EffectsStudy()
    plan = study.plan(EffectsOptions(load_scene(scene), rtol, matters, repeats, seconds, workers, engine))
    with tempfile.TemporaryDirectory() as scratch:
        folder = out or Path(scratch)
        with verdicts_shown(plan.turns) as show:
            run_study(study, plan, folder, command=typed(), reporter=Reporter(show, show.note))
        page = render_study("effects", folder).page if out else None
        view = view_effects(folder)
    assert view is not None
    show_view(view)
    if page:
        click.echo(f"effects: {page}")


def need(engine: str | None) -> None:
    """Say how to get an engine that was asked for and is not there."""
    from adapters.registry import ENGINES  # noqa: PLC0415

    if engine and ENGINES[engine].missing:
        raise click.UsageError(f"--engine {engine}: {ENGINES[engine].missing}")


def show_view(view: EffectsView) -> None:
    """Print the tables and the advice."""
    from barchain.cli.listing import show  # noqa: PLC0415

    for table in view.tables:
        show(printed(table))
    click.echo(view.headline)
    for advice in view.advice:
        click.echo(f"  {advice.text}")
    if view.timing:
        click.echo(view.timing)


def printed(table: EffectsTable) -> Table:
    """Table for the terminal: it fits 120 columns, its longest words folded."""
    from rich.markup import escape  # noqa: PLC0415
    from rich.table import Table  # noqa: PLC0415

    made = Table(box=None, header_style="bold", title=table.title, title_justify="left", title_style="")
    columns = len(table.headings)
    room = (SCREEN - WORDS * table.wordy - 2 * columns) // (columns - table.wordy)
    for k, heading in enumerate(table.headings):
        wordy = k < table.wordy
        width = WORDS if wordy else min(NUMBERS, room)
        made.add_column(heading, justify="left" if wordy else "right", max_width=width)
    for row in table.rows:
        made.add_row(*map(escape, row))
    return made
