"""Options and arguments with one meaning in every command."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from barchain.cli.common.names import ENGINE, SCENE, scenes_of
from barchain.cli.common.numbers import MINUTES, MOST_REPEATS, MOST_WORKERS, POSITIVE_SECONDS, WORDS, NamedPath
from barchain.cli.common.settings import FORM, SETTING
from barchain.runs.cluster.limits import WORKERS_S
from barchain.runs.executors import chosen_executor

if TYPE_CHECKING:
    from collections.abc import Callable

F = TypeVar("F", bound="Callable[..., object]")

JOINS = "Write tables and pages into this folder; beside a comparison, its report includes the study."
OWN_PAGE = "Write tables and a page into this folder."
WORKERS = "Run N runs side by side; default: as many as there are cores."

scene_argument = click.argument("scene", metavar="SCENE", type=SCENE)


def expanded(_ctx: click.Context, _param: click.Parameter, given: tuple[str, ...]) -> tuple[str, ...]:
    """Scenes with those of each named folder in its place."""
    return tuple(dict.fromkeys(name for word in given for name in scenes_of(word)))


optional_scenes = click.argument("scenes", metavar="[SCENE]...", nargs=-1, type=SCENE, callback=expanded)
required_scenes = click.argument("scenes", metavar="SCENE...", nargs=-1, required=True, type=SCENE, callback=expanded)

set_option = click.option(
    "--set", "settings", multiple=True, metavar=FORM, type=SETTING,
    help="Set an engine's accuracy parameter, e.g. rtol=1e-12 or exudyn:steps_per_orbit=2000; without ENGINE: of every "
         "chosen engine that has it. May be repeated; default: each engine's own.",
)  # fmt: skip
workers_option = click.option("--workers", type=click.IntRange(1, MOST_WORKERS), metavar="N", help=WORKERS)
dask_option = click.option(
    "--dask",
    metavar="ADDRESS",
    type=WORDS,
    help="Make the runs on the workers of this Dask scheduler, e.g. tcp://10.0.0.1:8786; default: on this machine.",
)
dask_wait_option = click.option(
    "--dask-wait", metavar="S", type=POSITIVE_SECONDS, default=WORKERS_S, show_default=True,
    help="With --dask: give up if the scheduler has no worker for this time, in seconds.",
)  # fmt: skip
resume_option = click.option("--resume", is_flag=True, help="Go on from results in the folder that the same code made.")
overwrite_option = click.option("--overwrite", is_flag=True, help="Replace results that are already there.")
json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON instead of a table.")


def executor_options(command: Callable[..., None]) -> Callable[..., None]:
    """`--workers`, `--dask` and `--dask-wait`, given to the command as one `executor`."""

    @functools.wraps(command)
    def gathered(**given: Any) -> None:
        workers, dask, wait_s = (given.pop(name) for name in ("workers", "dask", "dask_wait"))
        if dask is not None and workers is not None:
            raise click.UsageError("--workers counts runs on this machine; with --dask the cluster's threads decide")
        command(**given, executor=chosen_executor(workers, dask, wait_s))

    found: Callable[..., None] = gathered
    for option in (dask_wait_option, dask_option, workers_option):
        found = option(found)
    return found


def timed_alone(command: Callable[..., None]) -> Callable[..., None]:
    """Reject `--dask` in a study whose times must come from this machine alone."""

    @functools.wraps(command)
    def local(**given: Any) -> None:
        if given.pop("dask") is not None:
            raise click.UsageError(
                "--dask: this study times its runs, which takes one quiet machine; no cluster is taken"
            )
        command(**given)

    found: Callable[..., None] = click.option("--dask", hidden=True, metavar="ADDRESS")(local)
    return found


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
