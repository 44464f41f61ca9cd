"""Command `plot`: runs as charts or animations, each a file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from barchain.cli.common.numbers import MOST_BARS, NamedPath
from barchain.cli.common.options import (
    ENGINE,
    SCENE,
    overwrite_option,
    programs_option,
    set_option,
    time_limit_option,
)
from barchain.cli.common.progress import note
from barchain.cli.common.result_folder import need_writable
from barchain.cli.common.terminal import say
from barchain.cli.simulate import channel_names, run
from barchain.runs.job import TIME_LIMIT_S

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from barchain.cli.common.options import GivenSetting
    from reports.motion.charts import Run

CHARTS, FILMS = (".svg", ".png"), (".gif", ".mp4")
ENDINGS = (*CHARTS, *FILMS, ".html")
TABLES = (".csv", ".parquet", ".txt", ".tsv", ".dat", ".gz")
"""Endings of files of runs"""
TIME_UNITS = ("s", "min", "h", "orbits")
FRAMES = ("vertical", "inertial")
"""As :mod:`reports.motion` has them, which help does not import"""


@click.command(short_help="Draw runs as charts, or as an animation of the chain.")
@click.argument("sources", metavar="RUN|SCENE...", nargs=-1, required=True, type=SCENE)
@click.option("--out", metavar="FILE", type=NamedPath(path_type=Path, dir_okay=False), required=True,
              help="Write charts into this file, .svg or .png, or an animation, .gif, .mp4 (needs ffmpeg) or .html "
              "(with charts).")  # fmt: skip
@click.option("--channel", "channels", metavar="NAME", multiple=True, callback=channel_names,
              help="Draw this channel, stored or derived, e.g. joint_angle; `barchain explain channels` lists them. "
              "May be repeated, or a list with commas; default: attitude, reactions, radius and residual.")  # fmt: skip
@click.option("--bar", "bars", metavar="N", multiple=True, type=click.IntRange(1, MOST_BARS),
              help="Draw this bar, from 1. May be repeated; default: all.")  # fmt: skip
@click.option("--joint", "joints", metavar="N", multiple=True, type=click.IntRange(1, MOST_BARS),
              help="Draw this joint, from 1. May be repeated; default: all.")  # fmt: skip
@click.option("--engine", "names", metavar="NAME", multiple=True, type=ENGINE,
              help="Simulate each SCENE in this engine. May be repeated: runs lie over each other; default: "
              "reference-fast where it is built, else reference.")  # fmt: skip
@programs_option
@set_option
@click.option("--of", "of_scene", metavar="SCENE", type=SCENE,
              help="Take each RUN as one of this scene, for derived channels, orbits and animations; default: the "
              "scene of its folder in a comparison.")  # fmt: skip
@click.option("--time", "unit", type=click.Choice(TIME_UNITS),
              help="Count the time in this unit; default: one that fits the run.")  # fmt: skip
@click.option("--degrees", is_flag=True, help="Draw angles in degrees, and rates in degrees a second.")
@click.option("--frame", type=click.Choice(FRAMES),
              help="Animate in the local vertical frame, or in inertial axes about the centre of mass; default: "
              "vertical where there is gravity.")  # fmt: skip
@time_limit_option(TIME_LIMIT_S)
@overwrite_option
def plot(
    sources: tuple[str, ...], out: Path, channels: tuple[str, ...], bars: tuple[int, ...], joints: tuple[int, ...],
    names: tuple[str, ...], settings: tuple[GivenSetting, ...], of_scene: str | None, unit: str | None,
    degrees: bool, frame: str | None, time_limit_s: float, overwrite: bool,
) -> None:  # fmt: skip
    """Draw each RUN (a table with the columns of `simulate`), or each SCENE as an engine runs it, into one file."""
    ending = out.suffix
    if ending not in ENDINGS:
        raise click.UsageError(f"--out {out}: ending {ending!r} given, allowed: {', '.join(ENDINGS)}")
    still = ending in CHARTS
    if frame and still:
        raise click.UsageError(f"--frame goes with an animation, .gif, .mp4 or .html; --out {out} has charts")
    if (channels or bars or joints or degrees) and ending in FILMS:
        raise click.UsageError(
            f"--channel, --bar, --joint and --degrees are of charts; --out {out} has none, an .html has both"
        )
    need_writable(out, "--out")
    from barchain.drawing import with_channels, write_animation, write_charts
    from barchain.record.claim import claim
    from reports.motion.animation import need_writer
    from reports.motion.charts import Chosen, DrawingError, Run

    files = [source for source in sources if is_file(source)]
    if (names or settings) and len(files) == len(sources):
        raise click.UsageError(f"--engine and --set go with a SCENE; {files[0]} is the file of a run")
    if of_scene and not files:
        raise click.UsageError("--of goes with the file of a RUN; a SCENE is its own")
    claim([out], f"{out} is there", overwrite=overwrite)
    try:
        need_writer(ending)
        drawn, chosen = list[Run](), Chosen(bars, joints, degrees)
        for source in sources:
            if is_file(source):
                drawn.append(read_run(Path(source), of_scene))
            else:
                drawn += simulated(source, names, settings, time_limit_s)
        drawn, reasons = with_channels(distinct(drawn), channels)
        for reason in reasons:
            note(reason)
        if still:
            write_charts(drawn, out, channels, chosen, unit or "")
        else:
            write_animation(drawn, out, frame or "", channels, chosen, unit or "")
    except DrawingError as error:
        raise click.UsageError(str(error)) from None
    say(f"wrote {out}: {', '.join(run.name for run in drawn)}")


def is_file(source: str) -> bool:
    """Whether a word on the command line is the file of a run, and no scene."""
    path = Path(source)
    return path.suffix.lower() in TABLES or (path.is_file() and path.suffix != ".toml")


def read_run(path: Path, of_scene: str | None) -> Run:
    """Run of a file."""
    from barchain.result_files.drawn_runs import read_run_table, scene_of
    from reports.motion.charts import Run
    from scenarios import load_scene

    table, scene = read_run_table(path), of_scene or scene_of(path)
    return Run(path.name, table, load_scene(scene) if scene else None)


def simulated(
    source: str, names: Sequence[str], settings: Sequence[GivenSetting], time_limit_s: float
) -> Iterable[Run]:
    """Runs of a scene in some engines; in the default one where none is named."""
    from adapters.registry import find_engine
    from barchain.cli.common.options import GivenSetting, settings_by_engine
    from barchain.drawing import run_of

    chosen = settings_by_engine(settings, {name: find_engine(name) for name in names}) if names else {}
    for name in names or (None,):
        own = [GivenSetting(name, *one) for one in chosen.get(name, {}).items()] if name else settings
        trajectory = run(source, name, own, time_limit_s)
        yield run_of(trajectory)


def distinct(runs: Sequence[Run]) -> list[Run]:
    """Runs with names for a legend: of one scene the engines alone, and a number where two are alike."""
    scenes = {each.scene.name for each in runs if each.scene}
    names = [each.name for each in runs]
    if len(runs) > 1 and len(scenes) == 1:
        names = [name.removeprefix(f"{next(iter(scenes))} in ") for name in names]
    numbered = [
        f"{name} ({names[:k].count(name) + 1})" if names.count(name) > 1 else name for k, name in enumerate(names)
    ]
    return [replace(each, name=name) for each, name in zip(runs, numbered, strict=True)]
