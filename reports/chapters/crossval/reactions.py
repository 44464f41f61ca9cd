"""Charts of joint reactions: the judging solution as lines, independent engines as marks on them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from reports.chapters.crossval.scene_data import group
from reports.plotting.palette import COLOURS, Pen, hollow, joint_pen
from reports.plotting.panels import ChartFrame, Legend, Line, linear_panel
from reports.plotting.series import Array, numbered
from reports.text.numerals import prefixed

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray

    from reports.chapters.crossval.scene_data import ChartGroup, SceneData
    from reports.plotting.panels import Panel

MOST_JOINTS = 4  # as many as the paper's chain has
MARKS = 12  # of one engine on a line: those of six stay apart
AXES = {"x": "z1", "y": "z2"}
SOLUTION_PEN = Pen(COLOURS["ink"])


@dataclass(frozen=True)
class Reactions:
    """Reactions of one run."""

    t_s: Array
    """(n,)"""
    of: dict[str, Array]
    """Component x or y: (n, joints)"""
    limit_s: float


class ReactionCharts:
    """Charts of one scene's reactions."""

    def __init__(self, data: SceneData) -> None:
        self.data = data
        self.solution = stored_reactions(data.solution, data.solution_end_s)
        count = self.solution.of["x"].shape[1] if self.solution else 0
        self.shown = np.unique(np.linspace(0, count - 1, min(count, MOST_JOINTS)).round().astype(int))

    def group(self) -> ChartGroup | None:
        """Charts of both components over the whole run and at the first manoeuvre, and of the engines' largest one."""
        if self.solution is None:
            return None
        panels = [
            self.panel(f"Component along {axis}{when}", component, window)
            for when, window in self.windows()
            for component, axis in AXES.items()
        ]
        legend = tuple(Legend(f"joint {j + 1}", joint_pen(k)) for k, j in enumerate(self.shown))
        text = "Force on bar j from bar j+1 in inertial axes; judging solution."
        if self.data.solution_end_s < self.data.end_s:
            text += " Faint: beyond its predictability limit."
        return group("Reactions", text, legend, [*panels, self.engines_panel()])

    def windows(self) -> list[tuple[str, tuple[float, float] | None]]:
        """Whole run, and the first manoeuvre where it is short beside the run."""
        found: list[tuple[str, tuple[float, float] | None]] = [("", None)]
        if self.data.scene.prescribed:
            start, end = self.data.manoeuvre(self.data.scene.prescribed[0])
            if end - start < 0.5 * self.data.end_s:
                found.append((", at the manoeuvre", (start, end)))
        return found

    def panel(self, title: str, component: str, window_s: tuple[float, float] | None) -> Panel | None:
        """One component of some joints over the whole run or a window of it."""
        frame = self.frame(title, window_s)
        start, end = window_s or (0.0, self.data.end_s)
        if start < self.data.solution_end_s < end:
            frame.mark, frame.mark_label = self.data.solution_end_s / self.unit_s(window_s), "predictability limit"
        return linear_panel(self.scaled(frame, self.solution_lines(component, start, end), window_s))

    def solution_lines(self, component: str, start_s: float, end_s: float) -> list[Line]:
        """Lines of the judging solution; those beyond the predictability limit come first, below the others."""
        assert self.solution is not None
        t, values = self.solution.t_s, self.solution.of[component]
        seen = (t >= start_s) & (t <= end_s)
        parts = ((True, seen & (t >= self.solution.limit_s)), (False, seen & (t <= self.solution.limit_s)))
        return [
            Line(t[part], values[part, joint], joint_pen(k), faint=faint)
            for faint, part in parts
            if part.any()
            for k, joint in enumerate(self.shown)
        ]

    def engines_panel(self) -> Panel | None:
        """Largest component: judging solution as a line, marks of every independent engine on it."""
        runs = self.independent_runs()
        if self.solution is None or not runs:
            return None
        window = self.windows()[-1][1]
        start, end = window or (0.0, min(self.data.end_s, float(np.median([r.limit_s for r in runs.values()]))))
        seen = (self.solution.t_s >= start) & (self.solution.t_s <= end)
        if seen.sum() < 2:
            return None
        largest = {c: np.nanmax(np.abs(v[seen]), axis=0, initial=0.0) for c, v in self.solution.of.items()}
        component = max(largest, key=lambda c: float(largest[c].max()))
        joint = int(largest[component].argmax())
        t, y = self.solution.t_s[seen], self.solution.of[component][seen, joint]
        lines = [Line(t, y, SOLUTION_PEN, width=1.0)]
        for k, (engine, run) in enumerate(runs.items()):
            at = nearest(run, spread(t, y, k / len(runs)))
            lines.append(Line(run.t_s[at], run.of[component][at, joint], hollow(self.data.pens[engine])))
        frame = self.frame(f"Joint {joint + 1} along {AXES[component]}, independent engines", window)
        frame.x_span = (start / self.unit_s(window), end / self.unit_s(window))
        made = linear_panel(self.scaled(frame, lines, window))
        legend = (Legend("judging solution", SOLUTION_PEN), *(Legend(e, hollow(self.data.pens[e])) for e in runs))
        note = "Marks: samples of each engine up to its predictability limit."
        if window is None and end < self.data.end_s:
            note += " The panel ends at the median of these limits."
        return made and replace(made, note=note, legend=legend)

    def independent_runs(self) -> dict[str, Reactions]:
        """Reactions of independent engines, each up to its predictability limit."""
        found: dict[str, Reactions] = {}
        for engine in filter(self.data.summary.external, self.data.summary.engines):
            predictability_limit = min(self.data.predictability_limit(engine, "reaction"), self.data.solution_end_s)
            run = stored_reactions(self.data.results.trajectory(self.data.scene.name, engine), predictability_limit)
            if run and self.solution and run.of["x"].shape[1] == self.solution.of["x"].shape[1]:
                found[engine] = run
        return found

    def unit_s(self, window_s: tuple[float, float] | None) -> float:
        """Unit of a panel's time, s: a manoeuvre is shown in seconds."""
        return self.data.unit_s if window_s is None else 1.0

    def frame(self, title: str, window_s: tuple[float, float] | None) -> ChartFrame:
        """Empty frame over the whole run or a window of it."""
        start, end = window_s or (0.0, self.data.end_s)
        label, unit_s = self.data.x_label if window_s is None else "time, s", self.unit_s(window_s)
        return ChartFrame(title, label, "N", (start / unit_s, end / unit_s))

    def scaled(self, frame: ChartFrame, lines: list[Line], window_s: tuple[float, float] | None) -> ChartFrame:
        """Frame with `lines`, converted from s and N into its units."""
        factor, frame.y_label = prefixed(
            max((float(np.nanmax(np.abs(x.y), initial=0.0)) for x in lines), default=0.0), "N"
        )
        frame.lines = [line.scaled(1.0 / self.unit_s(window_s), factor) for line in lines]
        return frame


def spread(t_s: Array, y: Array, phase: float) -> Array:
    """Instants at even distances along a drawn curve, so that peaks get marks too.

    `phase` between 0 and 1 shifts them, so that marks of several engines do not pile up.
    """
    y = np.nan_to_num(y)
    way = np.hypot(np.diff(t_s) / (np.ptp(t_s) or 1.0), np.diff(y) / (np.ptp(y) or 1.0))
    along = np.concatenate([[0.0], np.cumsum(way)])
    instants: Array = np.interp(along[-1] * (np.arange(MARKS) + phase) / MARKS, along, t_s)
    return instants


def nearest(run: Reactions, instants_s: Array) -> NDArray[np.intp]:
    """Indices of the samples nearest to some instants before a run's predictability limit."""
    wanted = instants_s[instants_s <= min(run.limit_s, float(run.t_s[-1]))]
    return np.unique(np.abs(run.t_s[:, None] - wanted).argmin(axis=0))


def stored_reactions(table: pd.DataFrame | None, limit_s: float) -> Reactions | None:
    """Reactions of a stored trajectory; None without any."""
    if table is None or not len(table):
        return None
    x, y = (numbered(table, rf"reaction_(\d+)_{c}_N") for c in AXES)
    if x is None or y is None:
        return None
    return Reactions(table["t_s"].to_numpy(float), {"x": x, "y": y}, limit_s)
