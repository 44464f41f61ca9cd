"""Pictures and animations of trajectories: their tables with derived channels, and files by their endings."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from adapters.trajectory import from_frame
from barchain.metrics.derived import DerivedError, chosen_columns
from reports.motion.animation import FRAMES, default_frame, film, moving_chains, page
from reports.motion.charts import ALL_CHANNELS, EVERY, TIME_UNITS, Chosen, DrawingError, Run, columns_of, fitting_unit
from reports.motion.figure import draw, picture
from reports.results.writing import write_atomically
from scenarios.channels import CHANNELS, CLOCK, TIME
from scenarios.derived_channels import DERIVED_CHANNELS
from scenarios.nearest import nearest
from scenarios.text import shorten

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Sequence

    import numpy as np
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from adapters.trajectory import Trajectory

ANIMATIONS = (".gif", ".mp4", ".html")
"""Endings of files of animations"""


def need_one_of(what: str, given: object, allowed: Collection[str]) -> None:
    """Check a name.

    Raises
    ------
    DrawingError
        If it is none of the allowed ones; with the nearest.
    """
    if given not in allowed:
        near = nearest(str(given), allowed)
        raise DrawingError(f"{what} {shorten(given)} given{near}, allowed: {', '.join(allowed)}")


def run_of(trajectory: Trajectory, name: str = "") -> Run:
    """Run of a trajectory."""
    named = name or " in ".join(filter(None, [trajectory.scene, trajectory.engine])) or "this trajectory"
    return Run(named, trajectory.to_frame(), trajectory.run_scene)


def with_channels(runs: Sequence[Run], channels: Iterable[str]) -> tuple[list[Run], list[str]]:
    """Runs with the columns of some channels in their tables, and why some of them lack one.

    Raises
    ------
    DrawingError
        If no run has a channel, or can have it.
    """
    found, reasons = list(runs), list[str]()
    for channel in channels:
        lacking = []
        for k, run in enumerate(found):
            try:
                found[k] = with_channel(run, channel)
            except (DrawingError, DerivedError) as error:
                lacking.append(f"{run.name}: {error}")
        if len(lacking) == len(found):
            raise DrawingError(lacking[0])
        reasons += lacking
    return found, reasons


def with_channel(run: Run, channel: str) -> Run:
    """Run with the columns of a channel in its table.

    Raises
    ------
    DrawingError, DerivedError
        If the table lacks them, or what they are computed of.
    """
    if columns_of(run.table, channel):
        return run
    track = [c for name in ("com", "com_velocity") for c in CHANNELS[name].columns]
    missing = [column for column in track if column not in run.table]
    if channel not in DERIVED_CHANNELS or missing:
        needs = f", which would be computed of {', '.join(missing)}" if channel in DERIVED_CHANNELS else ""
        raise DrawingError(f"no column of {channel}{needs}")
    if run.scene is None:
        raise DrawingError(f"{channel} is computed, which needs the scene of the run (--of SCENE, Trajectory.of_run)")
    added = chosen_columns(from_frame(run.table).of_run(run.scene), [channel])
    return replace(run, table=pd.concat([run.table, added.drop(columns=[TIME, CLOCK], errors="ignore")], axis=1))


def plot(
    trajectory: Trajectory,
    channels: Sequence[str],
    bars: Collection[int],
    joints: Collection[int],
    time: str,
    degrees: bool,
) -> tuple[Figure, NDArray[np.object_]]:
    """Draw a trajectory as :meth:`adapters.trajectory.Trajectory.plot`."""
    import matplotlib.pyplot as plt  # noqa: PLC0415  # chooses a backend, which files have no need of

    if isinstance(channels, str):
        raise DrawingError(f"channels is {channels!r}, allowed: a list of names, e.g. [{channels!r}]")
    for channel in channels:
        need_one_of("channel", channel, ALL_CHANNELS)
    if time:
        need_one_of("time", time, TIME_UNITS)
    runs, _ = with_channels([run_of(trajectory)], channels)
    made = plt.figure()
    try:
        return made, draw(made, runs, channels, Chosen(bars, joints, degrees), time)
    except BaseException:
        plt.close(made)
        raise


def animate(trajectory: Trajectory, path: str | Path, frame: str) -> Path:
    """Write an animation as :meth:`adapters.trajectory.Trajectory.animate`."""
    file = Path(path)
    need_one_of(f"{file}: ending", file.suffix, ANIMATIONS)
    write_animation([run_of(trajectory)], file, frame)
    return file


def write_charts(runs: Sequence[Run], path: Path, channels: Sequence[str], chosen: Chosen, unit: str) -> None:
    """Write charts of some runs, by the ending of the file.

    Raises
    ------
    DrawingError
        If there is nothing to draw, or too much of it.
    """
    write_atomically(path, picture(runs, channels, chosen, unit, path.suffix[1:]))


def write_animation(
    runs: Sequence[Run],
    path: Path,
    frame: str = "",
    channels: Sequence[str] = (),
    chosen: Chosen = EVERY,
    unit: str = "",
) -> None:
    """Write an animation of some runs, by the ending of the file; charts of the channels are in a page alone.

    Raises
    ------
    DrawingError
        If the runs can't be shown so, or a program that is needed is missing.
    """
    frame, unit = frame or default_frame(runs), unit or fitting_unit(runs)
    need_one_of("frame", frame, FRAMES)
    chains = moving_chains(runs, frame, unit)
    if path.suffix == ".html":
        shown = page(chains, frame, channels, chosen, unit)
    else:
        shown = film(chains, frame, unit, path.suffix)
    write_atomically(path, shown)
