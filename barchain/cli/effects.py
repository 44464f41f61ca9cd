"""`barchain effects`: relevance and cost of each effect in a scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from barchain.cli.common.exit_codes import end_study
from barchain.cli.common.numbers import RealNumber
from barchain.cli.common.options import (
    JOINS,
    executor_options,
    minutes_option,
    out_option,
    overwrite_option,
    repeats_option,
    resume_option,
    scene_argument,
)
from barchain.cli.common.result_folder import need_kept, run_study_in
from barchain.cli.common.terminal import literal, say
from barchain.studies.defaults import EFFECTS, FAST, MATTERS, RTOL, RTOLS, SLOW, WIDTHS_M

if TYPE_CHECKING:
    from pathlib import Path

    from rich.table import Table

    from barchain.runs.executors import Executor
    from reports.chapters.effects import BudgetTable

SCREEN, WORDS, NUMBERS = 120, 20, 28  # columns of the screen, and at most of a cell of words or of numbers


@click.command(short_help="Measure relevance and run time of each effect.")
@scene_argument
@out_option(None, help_text=f"{JOINS[:-1]}; default: print only.")
@click.option("--rtol", metavar="R", type=RealNumber(*RTOLS), default=RTOL, show_default=True,
              help="Request this relative accuracy of a step; a run at 10 R shows the numerical error.")  # fmt: skip
@click.option("--matters", metavar="X", type=RealNumber(0.0, 1.0, min_open=True), default=MATTERS,
              show_default=True,
              help="Call an effect relevant from this change on: rad of attitude, or relative to the largest reaction "
                   "or to the initial distance from the centre.")  # fmt: skip
@click.option("--width", "width_m", metavar="M", type=RealNumber(*WIDTHS_M),
              help="Take every bar to be so wide, in m, for drag and sunlight that SCENE does not have; default: the "
                   "width of the one that it has. Without a width there is no conclusion on them.")  # fmt: skip
@click.option("--engine", metavar="NAME", type=click.Choice([FAST, SLOW]),
              help=f"Run this form of the reference, {FAST} or {SLOW}; default: {FAST} where it is installed and "
                   "supports the scene.")  # fmt: skip
@repeats_option(EFFECTS.repeats)
@minutes_option(EFFECTS.minutes, shown="a third", more="; no further round of timing is begun after it")
@executor_options
@resume_option
@overwrite_option
def effects(
    scene: str, out: Path | None, rtol: float, matters: float, width_m: float | None, engine: str | None, repeats: int,
    minutes: float, executor: Executor, resume: bool, overwrite: bool,
) -> None:  # fmt: skip
    """Measure relevance and run time of each effect in SCENE.

    SCENE is a name or a file. Each effect is switched off, or on with stated defaults where the scene does not
    have it. Exits with 1 if a run fails.
    """
    from barchain.cli.common.names import need_loaded  # noqa: PLC0415
    from barchain.cli.common.progress import verdicts_shown  # noqa: PLC0415
    from barchain.runs.environment import kept_or_temporary  # noqa: PLC0415
    from barchain.studies.effects.study import EffectsOptions, EffectsStudy  # noqa: PLC0415  # statistics no other needs
    from barchain.studies.study import Reporter  # noqa: PLC0415
    from scenarios import load_scene  # noqa: PLC0415

    need_kept(out, resume=resume)
    if engine:
        need_loaded(engine)
    study = EffectsStudy()
    options = EffectsOptions(load_scene(scene), rtol, matters, repeats, 60.0 * minutes, executor, engine, width_m)
    try:
        plan = study.plan(options)
    except ValueError as error:
        raise click.UsageError(f"--width: {error}") from error
    with kept_or_temporary(out) as folder, verdicts_shown(plan.turns) as show:
        reporter = Reporter(show, show.note)
        result, rendered = run_study_in(folder, study, plan, reporter, resume=resume, overwrite=overwrite)
    show_view(rendered.view)
    if out:
        say(f"effects: {rendered.page}")
    end_study(result, result.failures)


def show_view(view: Any) -> None:
    """Print the tables, the effects by relevance, and what limits the conclusions."""
    from barchain.cli.common.terminal import show  # noqa: PLC0415

    for table in view.tables:
        show(printed(table))
    for name, titles in view.groups.items():
        say(f"{name}: {', '.join(titles)}")
    for remark in view.remarks:
        say(f"  {remark}")
    if view.rounds:
        say(f"rounds of timing: {view.rounds}; more --minutes, and more --repeats, narrow the intervals")


def printed(table: BudgetTable) -> Table:
    """Table for the terminal: it fits 120 columns, its longest words folded."""
    from rich.table import Table  # noqa: PLC0415

    made = Table(box=None, header_style="bold", title=table.title, title_justify="left", title_style="")
    columns = len(table.headings)
    room = (SCREEN - WORDS * table.wordy - 2 * columns) // (columns - table.wordy)
    for k, heading in enumerate(table.headings):
        wordy = k < table.wordy
        width = WORDS if wordy else min(NUMBERS, room)
        made.add_column(heading, justify="left" if wordy else "right", max_width=width)
    for row in table.rows:
        made.add_row(*map(literal, row))
    return made
