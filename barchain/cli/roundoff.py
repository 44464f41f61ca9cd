"""`barchain roundoff`: digits of the reactions in absolute and in relative coordinates."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from barchain.cli.common.exit_codes import end_study
from barchain.cli.common.options import out_option, overwrite_option, workers_option
from barchain.cli.common.terminal import say
from barchain.record.command import typed

if TYPE_CHECKING:
    from pathlib import Path

PARTS = ("evaluation", "trajectories", "engines", "times")


@click.command()
@out_option()
@click.option("--part", "parts", multiple=True, metavar="PART", type=click.Choice(PARTS), default=PARTS,
              help=f"Run this part of the study: {', '.join(PARTS)}. May be repeated; default: all four.")  # fmt: skip
@click.option("--full", is_flag=True, help="Take all sizes, arithmetics and numbers of bars, finer steps, longer runs.")
@workers_option
@overwrite_option
def roundoff(out: Path, parts: tuple[str, ...], full: bool, workers: int | None, overwrite: bool) -> None:
    """Measure the digits of the reactions that absolute and relative coordinates leave.

    Exits with 1 if a task fails.
    """
    from barchain.cli.common.progress import verdicts_shown  # noqa: PLC0415
    from barchain.studies.roundoff.study import RoundoffOptions, RoundoffStudy  # noqa: PLC0415  # multiple precision
    from barchain.studies.study import Reporter, run_study  # noqa: PLC0415
    from reports.render import render_study  # noqa: PLC0415

    study = RoundoffStudy()
    plan = study.plan(RoundoffOptions(parts, full, workers))
    claim_parts(out, parts, overwrite=overwrite)
    with verdicts_shown(plan.turns) as show:
        result = run_study(study, plan, out, command=typed(), reporter=Reporter(show, show.note))
    say(f"round-off study: {render_study('roundoff', out).page}")
    end_study(result, result.failures)


def claim_parts(out: Path, parts: tuple[str, ...], *, overwrite: bool) -> None:
    """Make sure that the tables of some parts may be written; those of other parts stay."""
    from barchain.cli.common.result_folder import claim, need_readable  # noqa: PLC0415
    from barchain.studies.roundoff.rows import OF_PARTS  # noqa: PLC0415

    folder = out / "roundoff"
    tables = [folder / f"{table}.csv" for part in parts for table in OF_PARTS[part]]
    need_readable(out, "roundoff")
    claim(tables, f"{folder} holds results of these parts", overwrite=overwrite)
