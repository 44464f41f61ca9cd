"""Command `simulate`: one run as a table."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from barchain.cli.common.numbers import NamedPath
from barchain.cli.common.options import (
    ENGINE,
    overwrite_option,
    programs_option,
    scene_argument,
    set_option,
    time_limit_option,
)
from barchain.cli.common.progress import note
from barchain.cli.common.result_folder import need_writable
from barchain.cli.common.terminal import say
from barchain.runs.job import TIME_LIMIT_S

if TYPE_CHECKING:
    from collections.abc import Iterable

    import pandas as pd

    from adapters.trajectory import Trajectory
    from barchain.cli.common.options import GivenSetting

ENDINGS = (".parquet", ".csv")


def channel_names(context: click.Context, option: click.Parameter, given: tuple[str, ...]) -> tuple[str, ...]:
    """Names of channels of all lists, and of columns where these may be chosen, each once, before anything runs."""
    from scenarios.channels import STORED
    from scenarios.derived_channels import DERIVED, channel_of
    from scenarios.nearest import nearest
    from scenarios.text import shorten

    del context
    names = tuple(dict.fromkeys(name.strip() for text in given for name in text.split(",")))
    known = [channel.name for channel in (*STORED, *DERIVED)]
    for name in names:
        if name not in known and not (option.name == "columns" and channel_of(name)):
            near, allowed = nearest(name, known), ", ".join(known)
            raise click.BadParameter(f"{shorten(name)}: no such channel{near}, allowed: {allowed}")
    return names


@click.command(short_help="Run a scene in one engine and write its samples.")
@scene_argument
@click.option("--engine", metavar="NAME", type=ENGINE,
              help="Run this engine; default: reference-fast where it is built, else reference.")  # fmt: skip
@programs_option
@set_option
@click.option("--out", metavar="FILE", type=NamedPath(path_type=Path, dir_okay=False), required=True,
              help="Write the samples into this table, .parquet or .csv.")  # fmt: skip
@time_limit_option(TIME_LIMIT_S)
@click.option("--columns", metavar="NAME", multiple=True, callback=channel_names,
              help="Write this channel, stored or derived, e.g. joint_angle, or a column of it, joint_angle_2_rad, in "
              "place of all stored ones; `barchain explain channels` lists them. May be repeated, or a list with "
              "commas.")  # fmt: skip
@click.option("--degrees", is_flag=True,
              help="Write angles in degrees and rates in degrees a second: angle_1_deg, rate_1_deg_s.")  # fmt: skip
@click.option("--condition", is_flag=True, help="Add the condition number of the joint system (reference only).")
@overwrite_option
def simulate(
    scene: str, engine: str | None, settings: tuple[GivenSetting, ...], out: Path, time_limit_s: float,
    columns: tuple[str, ...], degrees: bool, condition: bool, overwrite: bool,
) -> None:  # fmt: skip
    """Run SCENE (a name or a file) in one engine and write its samples."""
    if out.suffix not in ENDINGS:
        raise click.UsageError(f"--out {out}: ending {out.suffix!r} given, allowed: {', '.join(ENDINGS)}")
    need_writable(out, "--out")
    from barchain.record.claim import claim

    claim([out], f"{out} is there", overwrite=overwrite)
    trajectory = run(scene, engine, settings, time_limit_s, condition=condition)
    frame = chosen(trajectory, columns) if columns else trajectory.to_frame()
    write(in_degrees(frame) if degrees else frame, out)
    say(f"wrote {out}: {len(trajectory.t_s)} samples" + (f"; {trajectory.ended}" if trajectory.ended else ""))


def chosen(trajectory: Trajectory, columns: tuple[str, ...]) -> pd.DataFrame:
    """Table of some channels; one that the run does not give is bad usage."""
    from barchain.metrics.derived import DerivedError, chosen_columns

    try:
        return chosen_columns(trajectory, columns)
    except DerivedError as error:
        raise click.UsageError(f"--columns: {error}") from None


def in_degrees(frame: pd.DataFrame) -> pd.DataFrame:
    """Table with angles and rates in degrees, under the names of these."""
    import numpy as np

    from scenarios.channels import degree_column

    angles = [name for name in map(str, frame.columns) if degree_column(name) != name]
    return frame.assign(**{name: np.degrees(frame[name]) for name in angles}).rename(columns=degree_column)


def run(
    scene: str, engine: str | None, settings: Iterable[GivenSetting], time_limit_s: float, *, condition: bool = False
) -> Trajectory:
    """Trajectory of a run; a scene that the engine does not support is bad usage."""
    from adapters.engine import SettingError
    from adapters.registry import find_engine
    from barchain import api
    from barchain.cli.common.options import settings_by_engine
    from barchain.runs.other_settings import default_engine, quicker_advice
    from scenarios import SceneError, load_scene

    loaded = load_scene(scene)
    engine = engine or default_engine(loaded, condition=condition)
    chosen = settings_by_engine(settings, {engine: find_engine(engine)}).get(engine, {})
    try:
        start = time.perf_counter()
        found = api.simulate(loaded, engine, time_limit_s=time_limit_s, condition=condition, **chosen)
        if advice := quicker_advice(loaded, engine, time.perf_counter() - start):
            note(advice)
        return found
    except (SceneError, SettingError):
        raise
    except ValueError as error:  # the engine does not support the scene
        raise click.UsageError(str(error)) from error


def write(frame: pd.DataFrame, path: Path) -> None:
    """Write a table by the ending of its file; numbers in CSV read back in every digit."""
    from reports.results.writing import parquet, write_atomically

    if path.suffix == ".parquet":
        write_atomically(path, parquet(frame))
    else:
        write_atomically(path, frame.to_csv(index=False))
