"""Charts of prescribed rotations: attitude of the bars, and torques of judging solution and engines."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from reports.chapters.crossval.scene_data import group
from reports.plotting.palette import COLOURS, DASHES, Pen, joint_pen
from reports.plotting.panels import ChartFrame, Legend, Line, linear_panel
from reports.plotting.series import column, numbered
from reports.tables.crossval import SOLUTION
from reports.text.numerals import prefixed

if TYPE_CHECKING:
    from reports.chapters.crossval.differences import DifferenceCharts
    from reports.chapters.crossval.scene_data import ChartGroup, SceneData
    from reports.plotting.panels import Panel

SOLUTION_PEN = Pen(COLOURS["ink"], "", DASHES[1])
MOST_BARS = 4  # of which the attitude is shown: as many pens are told apart


def prescribed_motion(data: SceneData, differences: DifferenceCharts) -> ChartGroup | None:
    """Attitude over the run, torque of each rotation over its first few durations, and differences between engines."""
    laws = data.scene.prescribed
    if not laws:
        return None
    panels, used = [attitude_panel(data)], []
    for p, law in enumerate(laws):
        start, end = data.manoeuvre(law)
        lines, engines = torque_lines(data, torque_columns(p, law), start, end)
        largest = max((float(np.nanmax(np.abs(li.y), initial=0.0)) for li in lines), default=0.0)
        factor, unit = prefixed(largest, "N m")
        scaled = [Line(li.x, factor * li.y, li.pen, width=li.width) for li in lines]
        name = f"Torque on bar {law.get('bar', '?')}"
        panels.append(linear_panel(ChartFrame(name, "time, s", unit, (start, end), scaled)))
        used += [e for e in engines if e not in used]
    panels.append(differences.difference_panel("torque", "Difference of the torque from the judging solution")[0])
    legend = (*(Legend(e, data.pens[e]) for e in used), Legend("judging solution", SOLUTION_PEN))
    return group("Prescribed rotation", "Angles and torques are positive counter-clockwise.", legend, panels)


def attitude_panel(data: SceneData) -> Panel | None:
    """Angles of the judging solution from the start: of bars that a law turns, then of others; None without any."""
    angle = None if data.solution is None else numbered(data.solution, r"angle_(\d+)_rad")
    if data.solution is None or angle is None:
        return None
    turned = [int(law["bar"]) - 1 for law in data.scene.prescribed if isinstance(law.get("bar"), int)]
    spread = np.linspace(0, angle.shape[1] - 1, min(angle.shape[1], MOST_BARS)).round().astype(int).tolist()
    shown = sorted(list(dict.fromkeys([*turned, *spread]))[:MOST_BARS])
    axes = "inertial axes"
    if any(law.get("frame") == "local_horizontal" for law in data.scene.prescribed):
        com = data.solution[["com_x_m", "com_y_m"]].to_numpy(float)
        angle = angle - np.unwrap(np.arctan2(com[:, 1], com[:, 0]))[:, None] + 0.5 * np.pi
        axes = "the chain's local horizontal"
    t = data.solution["t_s"].to_numpy(float)
    lines = [Line(t / data.unit_s, np.degrees(angle[:, j]), joint_pen(k)) for k, j in enumerate(shown)]
    panel = linear_panel(data.frame(f"Attitude from {axes}", "°", lines))
    legend = tuple(Legend(f"bar {j + 1}", joint_pen(k)) for k, j in enumerate(shown))
    return panel and replace(panel, note="Judging solution.", legend=legend)


def torque_columns(p: int, law: dict[str, object]) -> tuple[str, ...]:
    """Possible columns of a rotation's torque: by its bar or by its number p; before 0.7 by the number alone."""
    return f"torque_bar_{law.get('bar')}_N_m", f"torque_law_{p + 1}_N_m", f"torque_{p + 1}_N_m"


def torque_lines(data: SceneData, names: tuple[str, ...], start_s: float, end_s: float) -> tuple[list[Line], list[str]]:
    """Torque of every engine that has it, the judging solution on top; and these engines."""
    lines, engines = [], []
    for engine in (*data.summary.engines, SOLUTION):
        table = data.solution if engine == SOLUTION else data.results.trajectory(data.scene.name, engine)
        found = () if table is None else (v for v in (column(table, name) for name in names) if v is not None)
        values = next(iter(found), None)
        if table is None or values is None:
            continue
        t = table["t_s"].to_numpy(float)
        shown = (t >= start_s) & (t <= end_s)
        pen = SOLUTION_PEN if engine == SOLUTION else data.pens[engine]
        lines.append(Line(t[shown], values[shown], pen, width=1.8 if engine == SOLUTION else 1.4))
        engines += [] if engine == SOLUTION else [engine]
    return lines, engines
