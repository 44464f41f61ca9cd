"""Charts of the torques of prescribed rotations: judging solution and engines."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reports.chapters.crossval.scene_data import group
from reports.plotting.palette import COLOURS, DASHES, Pen
from reports.plotting.panels import ChartFrame, Legend, Line, linear_panel
from reports.plotting.series import column
from reports.tables.crossval import SOLUTION
from reports.text.numerals import prefixed

if TYPE_CHECKING:
    from reports.chapters.crossval.differences import DifferenceCharts
    from reports.chapters.crossval.scene_data import ChartGroup, SceneData

SOLUTION_PEN = Pen(COLOURS["ink"], "", DASHES[1])


def torques(data: SceneData, differences: DifferenceCharts) -> ChartGroup | None:
    """Torque of each prescribed rotation over its first few durations, and differences between engines."""
    panels, used = [], []
    for p, law in enumerate(data.scene.prescribed):
        start, end = data.manoeuvre(law)
        lines, engines = torque_lines(data, p, start, end)
        largest = max((float(np.nanmax(np.abs(li.y), initial=0.0)) for li in lines), default=0.0)
        factor, unit = prefixed(largest, "N m")
        scaled = [Line(li.x, factor * li.y, li.pen, width=li.width) for li in lines]
        name = f"Torque on bar {law.get('bar', '?')}"
        panels.append(linear_panel(ChartFrame(f"{data.id}-torque-{p}", name, "time, s", unit, (start, end), scaled)))
        used += [e for e in engines if e not in used]
    panels.append(differences.difference_panel("torque", "Difference from the judging solution")[0])
    legend = (*(Legend(e, data.pens[e]) for e in used), Legend("judging solution", SOLUTION_PEN))
    return group("Prescribed torque", "Positive counter-clockwise.", legend, panels)


def torque_lines(data: SceneData, p: int, start_s: float, end_s: float) -> tuple[list[Line], list[str]]:
    """Torque p of every engine that has it, the judging solution on top; and these engines."""
    lines, engines = [], []
    for engine in (*data.summary.engines, SOLUTION):
        table = data.solution if engine == SOLUTION else data.results.trajectory(data.scene.name, engine)
        values = None if table is None else column(table, f"torque_{p + 1}_N_m")
        if table is None or values is None:
            continue
        t = table["t_s"].to_numpy(float)
        shown = (t >= start_s) & (t <= end_s)
        pen = SOLUTION_PEN if engine == SOLUTION else data.pens[engine]
        lines.append(Line(t[shown], values[shown], pen, width=1.8 if engine == SOLUTION else 1.4))
        engines += [] if engine == SOLUTION else [engine]
    return lines, engines
