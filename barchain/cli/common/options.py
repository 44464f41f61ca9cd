"""Options and arguments with one meaning in every command."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import click

from barchain.cli.common.names import ENGINE, SCENE
from barchain.cli.common.numbers import MINUTES, MOST_REPEATS, MOST_WORKERS, POSITIVE_SECONDS, NamedPath
from barchain.cli.common.settings import FORM, SETTING

if TYPE_CHECKING:
    from collections.abc import Callable

F = TypeVar("F", bound="Callable[..., object]")

JOINS = "Write tables and pages into this folder; beside a comparison, its report includes the study."
OWN_PAGE = "Write tables and a page into this folder."
WORKERS = "Run N runs side by side; default: as many as there are cores."

scene_argument = click.argument("scene", metavar="SCENE", type=SCENE)
optional_scenes = click.argument("scenes", metavar="[SCENE]...", nargs=-1, type=SCENE)
required_scenes = click.argument("scenes", metavar="SCENE...", nargs=-1, required=True, type=SCENE)

set_option = click.option(
    "--set", "settings", multiple=True, metavar=FORM, type=SETTING,
    help="Set an engine's accuracy parameter, e.g. rtol=1e-12 or exudyn:steps_per_orbit=2000; without ENGINE: of every "
         "chosen engine that has it. May be repeated; default: each engine's own.",
)  # fmt: skip
workers_option = click.option("--workers", type=click.IntRange(1, MOST_WORKERS), metavar="N", help=WORKERS)
resume_option = click.option("--resume", is_flag=True, help="Go on from results in the folder that the same code made.")
overwrite_option = click.option("--overwrite", is_flag=True, help="Replace results that are already there.")
json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON instead of a table.")


def engine_option(default: str, names: str = "names") -> Callable[[F], F]:
    """`--engine NAME`, repeatable; `default` says which engines take part without it."""
    return click.option(
        "--engine", names, multiple=True, metavar="NAME", type=ENGINE,
        help=f"Take this engine. May be repeated; default: {default}.",
    )  # fmt: skip


def out_option(default: str | None = "report", *, required: bool = False, help_text: str = "") -> Callable[[F], F]:
    """`--out DIR`: where results are written."""
    return click.option(
        "--out", metavar="DIR", type=NamedPath(path_type=Path, file_okay=False), required=required,
        default=Path(default) if default and not required else None, show_default=bool(default) and not required,
        help=help_text or JOINS,
    )  # fmt: skip


def time_limit_option(default_s: float, more: str = "") -> Callable[[F], F]:
    """`--time-limit S`: wall time after which one run is ended."""
    return click.option(
        "--time-limit", metavar="S", type=POSITIVE_SECONDS, default=default_s, show_default=True,
        help=f"End a run after this wall time, in seconds{more}.",
    )  # fmt: skip


def minutes_option(default: float, shown: str | None = None, more: str = "") -> Callable[[F], F]:
    """`--minutes M`: wall time that a study may take."""
    return click.option(
        "--minutes", metavar="M", type=MINUTES, default=default, show_default=shown or True,
        help=f"Give the study a budget of this wall time, in minutes{more}.",
    )  # fmt: skip


def repeats_option(default: int) -> Callable[[F], F]:
    """`--repeats N`: how often each point is timed."""
    return click.option(
        "--repeats", metavar="N", type=click.IntRange(1, MOST_REPEATS), default=default, show_default=True,
        help="Time each point N times, as far as the budget goes.",
    )  # fmt: skip
