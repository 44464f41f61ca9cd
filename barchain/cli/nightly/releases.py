"""`barchain releases`: accuracy and speed of an engine against its release."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from barchain.cli.common.numbers import WORDS
from barchain.cli.common.options import OWN_PAGE, out_option, overwrite_option, resume_option
from barchain.cli.common.result_folder import end_study, run_shown
from barchain.nightly.errors import need_extra

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
    need_extra("packaging", "pypi_simple", "uv")
    from barchain.nightly.attribution.release_runs import releases_study  # noqa: PLC0415

    result, rendered = run_shown(out, releases_study(engine, scenes, since), {"resume": resume, "overwrite": overwrite})
    end_study(result, rendered.page)
