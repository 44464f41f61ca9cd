"""Animations of the chain about its centre of mass: GIF, MP4, and a page that needs no script."""

from __future__ import annotations

import io
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

from reports.motion.charts import DrawingError, in_unit
from reports.motion.figure import HUES, UNIT_WORDS, line_style, picture, style
from reports.page import surroundings, templates
from reports.plotting.chain import (
    MOST_TURN_RAD,
    TURN_RAD,
    Geometry,
    along,
    draw_chains,
    joints,
    moving_chain,
)
from reports.plotting.palette import COLOURS
from reports.plotting.panels import Panel
from reports.plotting.series import numbered
from reports.plotting.svg import BOTTOM, LEFT, RIGHT, TOP, Chart, Scale
from scenarios.channels import CHANNELS
from scenarios.effect_types import Gravity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from reports.motion.charts import Chosen, Run
    from reports.plotting.series import Array

AXES = {"vertical": ("local horizontal, m", "local vertical, m"), "inertial": ("x, m", "y, m")}
"""Labels of both axes through the centre of mass, by frame"""
FRAMES = tuple(AXES)
LEAST_FRAMES, MOST_FRAMES = 60, 180
FRAMES_A_SECOND = 15
COLOURS_OF_GIF = 32
INCHES, DPI = (5.0, 5.4), 100
PLACE = (0.15, 0.1, 0.8, 0.74)
"""Of the axes in the figure: a square of its width"""
MARGIN = 1.05
"""Side of the square that is shown, relative to that which the chains stay in"""
SIDE = 340.0
"""Of the plot in a page, px"""
MOST_BYTES = 4_000_000
"""Of one moving chain in a page"""


@dataclass(frozen=True)
class MovingChain:
    """Chain of a run at k equal intervals of time."""

    run: Run
    geometry: Geometry
    times: Array
    """(k,) in the unit of the animation"""
    angle_rad: Array
    """(k, N) in the axes of the animation"""

    @property
    def points_m(self) -> Array:
        """Ends and joints about the centre of mass, (k, N+1, 2)."""
        return joints(self.geometry, self.angle_rad)


def default_frame(runs: Sequence[Run]) -> str:
    """Local vertical where there is one, else inertial axes."""
    free = any(run.scene is not None and run.scene.effects.gravity is Gravity.NONE for run in runs)
    return "inertial" if free else "vertical"


def moving_chains(runs: Sequence[Run], frame: str, unit: str) -> list[MovingChain]:
    """Chains of all runs at common instants; a run that ended earlier stays where it ended.

    Raises
    ------
    DrawingError
        If a run has no angles, or its scene is not known; if the bars turn too often for an animation.
    """
    angles = [bar_angles(run, frame) for run in runs]
    turned = max(float(np.abs(np.diff(angle, axis=0)).sum(axis=0).max(initial=0.0)) for angle in angles)
    if turned > MOST_TURN_RAD * MOST_FRAMES:
        turns, most = turned / (2.0 * np.pi), MOST_TURN_RAD * MOST_FRAMES / (2.0 * np.pi)
        raise DrawingError(
            f"a bar turns {turns:.3g} times, and an animation shows at most {most:.0f} turns; draw a shorter run"
        )
    count = int(np.clip(np.ceil(turned / TURN_RAD), LEAST_FRAMES, MOST_FRAMES))
    instants_s = np.linspace(min(run.t_s[0] for run in runs), max(run.t_s[-1] for run in runs), count + 1)
    found = []
    for run, angle in zip(runs, angles, strict=True):
        assert run.scene is not None
        scene, times = run.scene, np.interp(instants_s, run.t_s, in_unit(run, unit))
        geometry = Geometry(
            np.array(scene.chain.length_m), np.array(scene.chain.mass_kg), 0.0, scene.period_s,
            closed=True, com_share=scene.chain.com_share,
        )  # fmt: skip
        found.append(MovingChain(run, geometry, times, along(instants_s, run.t_s, angle)))
    return found


def bar_angles(run: Run, frame: str) -> Array:
    """Angles of the bars, (n, N) rad, from the x axis of a frame: in that of the vertical, y points away from the body.

    Raises
    ------
    DrawingError
        If they are not known.
    """
    if run.scene is None:
        raise DrawingError(f"{run.name}: an animation needs the scene of the run, for the lengths of the bars")
    angle = numbered(run.table, CHANNELS["attitude"].columns[0])
    track = list(CHANNELS["com"].columns)
    if angle is None or angle.shape[1] != run.scene.bars:
        there = "no angles" if angle is None else f"angles of {angle.shape[1]} bars"
        raise DrawingError(
            f"{run.name} has {there}, and {run.scene.name} {run.scene.bars} bars, which an animation shows"
        )
    if frame == "vertical":
        if not set(track) <= set(run.table.columns):
            raise DrawingError(f"{run.name} has no {' and '.join(track)}, which the local vertical needs")
        com = run.table[track].to_numpy(float)
        angle = angle - np.unwrap(np.arctan2(com[:, 1], com[:, 0]))[:, None] + 0.5 * np.pi
    if len(angle) < 2 or not np.isfinite(angle).all():
        raise DrawingError(f"{run.name} has fewer than two samples, or some that are no numbers")
    return angle


def need_writer(ending: str) -> None:
    """Check that an animation can be written into a file of some ending.

    Raises
    ------
    DrawingError
        If the program that writes it is missing.
    """
    if ending == ".mp4" and shutil.which("ffmpeg") is None:
        raise DrawingError("an .mp4 needs the program ffmpeg, which is not there; install it, or write a .gif or .html")


def film(chains: Sequence[MovingChain], frame: str, unit: str, ending: str) -> bytes:
    """Animation as a file, ``.gif`` or ``.mp4``.

    Raises
    ------
    DrawingError
        If the program that writes it is missing.
    """
    from matplotlib import rc_context  # noqa: PLC0415  # a report has no need of it
    from matplotlib.animation import FFMpegWriter, PillowWriter  # noqa: PLC0415
    from matplotlib.figure import Figure  # noqa: PLC0415

    need_writer(ending)
    writer = (FFMpegWriter if ending == ".mp4" else PillowWriter)(fps=FRAMES_A_SECOND)
    half = half_side(chains)
    several = len(chains) > 1
    with rc_context(style()), tempfile.TemporaryDirectory() as folder:
        made, path = Figure(figsize=INCHES), Path(folder, f"animation{ending}")
        ax = made.add_axes(PLACE)
        ax.set(xlim=(-half, half), ylim=(-half, half), xlabel=AXES[frame][0], ylabel=AXES[frame][1], aspect="equal")
        ax.plot([0.0], [0.0], "+", color=COLOURS["muted"].light)
        lines = []
        for k, chain in enumerate(chains):
            colour = HUES[k % len(HUES)] if several else COLOURS["ink"]
            look = {"linewidth": 1.8} | line_style(k, several=several) | {"marker": "o", "markersize": 3.0}
            lines += ax.plot([], [], color=colour.light, label=chain.run.name, **look | {"markevery": None})
        (first,) = ax.plot([], [], color=COLOURS["accent"].light, linewidth=0.0 if several else 3.2)
        made.suptitle(chains[0].run.name if not several else "", fontsize="medium")
        if several:
            made.legend(loc="upper center", ncols=2, fontsize="small", frameon=False)
        points, said = [chain.points_m for chain in chains], ax.set_title("", loc="right", fontsize="small")
        with writer.saving(made, str(path), DPI):
            for k, at in enumerate(chains[0].times):
                for line, own in zip(lines, points, strict=True):
                    line.set_data(own[k, :, 0], own[k, :, 1])
                first.set_data(points[0][k, :2, 0], points[0][k, :2, 1])
                said.set_text(f"{at:.2f} {UNIT_WORDS[unit]}")
                writer.grab_frame()
        return in_one_palette(path) if ending == ".gif" else path.read_bytes()


def in_one_palette(path: Path) -> bytes:
    """GIF with the colours of its first picture, which has all that later ones have: half the size."""
    from PIL import Image, ImageSequence  # noqa: PLC0415  # a report has no need of it

    content = io.BytesIO()
    with Image.open(path) as film:
        duration_ms = film.info["duration"]
        frames = [frame.convert("RGB") for frame in ImageSequence.Iterator(film)]
    palette = frames[0].quantize(COLOURS_OF_GIF)
    first, *later = (frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames)
    first.save(content, "GIF", save_all=True, append_images=later, duration=duration_ms, loop=0)
    return content.getvalue()


def half_side(chains: Sequence[MovingChain]) -> float:
    """Half the side of the square about the centre of mass that all chains stay in, with a margin, m."""
    return MARGIN * float(np.abs(np.concatenate([chain.points_m.ravel() for chain in chains])).max()) or 1.0


def page(chains: Sequence[MovingChain], frame: str, channels: Sequence[str], chosen: Chosen, unit: str) -> bytes:
    """Page with the chain of each run, which moves where the reader lets it, and the charts of all runs.

    Raises
    ------
    DrawingError
        If the chain has too many bars for a page.
    """
    half = half_side(chains)
    panels = [moving_panel(f"run{k}", chain, frame, half, unit) for k, chain in enumerate(chains, start=1)]
    runs = [chain.run for chain in chains]
    charts = picture(runs, channels, chosen, unit, "svg").decode()
    shown = {
        "title": ", ".join(dict.fromkeys(run.name for run in runs)),
        "panels": panels,
        "charts": Markup(charts[charts.index("<svg") :]),
    }
    return templates().get_template("motion.html.j2").render(surroundings({}) | shown).encode()


def moving_panel(name: str, chain: MovingChain, frame: str, half: float, unit: str) -> Panel:
    """Chain of a run at its start, and in motion, on axes of ± `half`, m."""
    x, y = Scale(-half, half, LEFT, LEFT + SIDE), Scale(-half, half, TOP + SIDE, TOP)
    drawn, points = Chart(x, y, (LEFT + SIDE + RIGHT, TOP + SIDE + BOTTOM)), chain.points_m
    drawn.axes(*AXES[frame])
    draw_chains(drawn, points[:1])
    length_px = 0.5 * SIDE / half * chain.geometry.length_m
    moving = moving_chain(name, drawn, points[:, 0], chain.angle_rad, length_px, most_bytes=MOST_BYTES)
    if not moving:
        raise DrawingError(f"{chain.run.name} has too many bars for an .html; write a .gif")
    span = f"{chain.times[0]:.4g} to {chain.times[-1]:.4g} {UNIT_WORDS[unit]}"
    note = f"About the centre of mass, to scale; bar 1 in colour; from {span}."
    return Panel(chain.run.name, drawn.svg(chain.run.name, more=moving), note, moving=f"{name}-moves")
