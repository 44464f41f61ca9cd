"""`barchain releases`: accuracy and speed of an engine against its release."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from barchain.cli.common.exit_codes import end_study
from barchain.cli.common.numbers import WORDS
from barchain.cli.common.options import OWN_PAGE, out_option, overwrite_option, resume_option
from barchain.cli.common.result_folder import run_study_in
from barchain.cli.common.terminal import say

if TYPE_CHECKING:
    from pathlib import Path


@click.command(short_help="Measure every release of an engine.")
@click.argument("engine", metavar="ENGINE", type=WORDS)
@click.argument("scenes", metavar="[SCENE]...", nargs=-1, type=WORDS)
@click.option("--from", "since", metavar="V", type=WORDS, help="Begin with this version; default: the first one.")
@out_option("releases", help_text=OWN_PAGE)
@resume_option
@overwrite_option
def releases(engine: str, scenes: tuple[str, ...], since: str | None, out: Path, resume: bool, overwrite: bool) -> None:
    """Measure every release of ENGINE that the package index has, each in an environment of its own.

    ENGINE is an engine of `barchain engines`, or a distribution such as scipy. SCENEs are names; default: three that
    the engine supports. Today's barchain runs each release: errors, trajectories, times at equal error, size, import
    time. Exits with 1 if no release runs.
    """
    from barchain.cli.common.progress import verdicts_shown  # noqa: PLC0415
    from barchain.nightly.faults import need_extra  # noqa: PLC0415

    need_extra("packaging", "pypi_simple")
    from barchain.nightly.release_runs import ReleasesOptions, ReleasesStudy  # noqa: PLC0415
    from barchain.studies.study import Reporter  # noqa: PLC0415

    study = ReleasesStudy()
    plan = study.plan(ReleasesOptions(engine, scenes, since))
    with verdicts_shown(plan.turns) as show:
        result, rendered = run_study_in(out, study, plan, Reporter(show, show.note), resume=resume, overwrite=overwrite)
    say(f"releases: {rendered.page}")
    end_study(result)
