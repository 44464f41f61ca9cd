"""Charts of a stability study: drifts of long runs on log-log axes, and the run of the largest deviation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from reports.plotting.palette import COLOURS, Pen
from reports.plotting.panels import ChartFrame, Legend, Line, Panel, draw, guide, linear_panel, log_panel
from reports.plotting.series import Array, decade_range, numbered, thin
from reports.plotting.svg import Chart, across, upwards

if TYPE_CHECKING:
    import pandas as pd

GUIDES = {0.5: "√t", 1.0: "t", 2.0: "t²"}
LEVEL_DASHES = {"coarse": (2.0, 1.6), "default": (), "finer": (6.0, 2.0)}
SOLUTION_PEN = Pen(COLOURS["ink"])
OUTSIDE_RAD = 2.0 * np.pi  # beyond the range of the reference solution: a diverged run is not drawn farther


@dataclass(frozen=True)
class DriftCurve:
    """One run's drift over time."""

    label: str
    t: Array
    size: Array
    pen: Pen


def long_panel(title: str, x_label: str, y_label: str, tracks: list[DriftCurve]) -> Panel | None:
    """Log-log chart of drifts against time with guide lines of known powers; None if there is nothing to draw."""
    shown = [t for t in tracks if (t.size > 0.0).any()]
    up = decade_range([t.size for t in shown])
    if up is None:
        return None
    ends = min(float(t.t[t.t > 0.0].min()) for t in shown), max(float(t.t.max()) for t in shown)
    chart = Chart(across(*ends, log=True), upwards(up.low, up.high, log=True))
    chart.axes(x_label, y_label)
    for power, word in GUIDES.items():
        guide(chart, power, word)
    for track in shown:
        good = (track.size > 0.0) & (track.t > 0.0)
        draw(chart, Line(track.t[good], track.size[good], track.pen), *thin(track.t[good], track.size[good]))
    legend = tuple(Legend(t.label, t.pen) for t in shown)
    return Panel(title, chart.svg(title), "Dotted: powers of t. Curves are running maxima.", legend)


def worst_panels(
    engine: str, runs: dict[str, pd.DataFrame], solution: pd.DataFrame, unit_s: float, x_label: str
) -> list[Panel]:
    """Charts of the bar with the largest error beside the reference solution, and of the error at each setting."""
    right = numbered(solution, r"angle_(\d+)_rad")
    if right is None:
        return []
    angles = {k: a for k, f in runs.items() if (a := numbered(f, r"angle_(\d+)_rad")) is not None}
    times = {k: runs[k]["t_s"].to_numpy(float) / unit_s for k in angles}
    t = solution["t_s"].to_numpy(float) / unit_s
    span = (0.0, float(t[-1]))
    bar = worst_bar(angles, right)
    lines = [Line(t, right[:, bar], SOLUTION_PEN)]
    lines += [Line(times[k], near(a[:, bar], right[:, bar]), level_pen(k)) for k, a in angles.items()]
    followed = linear_panel(ChartFrame(f"Angle of bar {bar + 1}", x_label, "rad", span, lines))
    off = [Line(times[k][: len(e)], e, level_pen(k)) for k, a in angles.items() if len(e := error(a, right))]
    lost = log_panel(ChartFrame("Largest error of all angles", x_label, "rad", span, off))
    legend = tuple(Legend(f"{engine}, {k} setting", level_pen(k)) for k in angles)
    found = [(followed, (Legend("reference solution", SOLUTION_PEN), *legend)), (lost, legend)]
    return [Panel(p.title, p.svg, p.note, words) for p, words in found if p is not None]


def worst_bar(angles: dict[str, Array], right: Array) -> int:
    """Index of the bar with the largest error of all runs."""
    n = min(len(a) for a in (*angles.values(), right))
    apart = np.max([np.abs(a[:n] - right[:n]).max(axis=0) for a in angles.values()], axis=0)
    return int(np.argmax(apart))


def error(angle: Array, right: Array) -> Array:
    """Largest difference of all bars' angles, (n,)."""
    n = min(len(angle), len(right))
    largest: Array = np.abs(angle[:n] - right[:n]).max(axis=1)
    return largest


def near(angle: Array, right: Array) -> Array:
    """Angle until it leaves the range of the reference solution."""
    inside = (angle >= right.min() - OUTSIDE_RAD) & (angle <= right.max() + OUTSIDE_RAD)
    return np.where(np.logical_and.accumulate(inside), angle, np.nan)


def level_pen(level: str) -> Pen:
    """Pen of one setting."""
    return Pen(COLOURS["s3"], "", LEVEL_DASHES.get(level, ()))
