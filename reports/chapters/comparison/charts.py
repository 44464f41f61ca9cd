"""Charts of a scene against time: reactions, prescribed rotations, differences, drifts, error amplification."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from reports.chapters.comparison.scene import ChartGroup
from reports.chapters.comparison.summary import SHORT_OF_THE_RUN
from reports.plotting.palette import COLOURS, DASHES, Pen, hollow, joint_pen
from reports.plotting.panels import Legend, Line, linear_panel, log_panel
from reports.plotting.series import column, numbered
from reports.results.comparison import AMPLIFICATION, SOLUTION
from reports.text.numerals import prefixed
from scenarios.channels import CHANNELS
from scenarios.derived_channels import DERIVED_CHANNELS

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray

    from reports.chapters.comparison.scene import SceneData
    from reports.plotting.panels import Panel
    from reports.plotting.series import Array

DIFFERENCES = ("attitude", "reaction", "com", "com_velocity")
DRIFTS = ("gap", "com_residual", "energy", "angular_momentum")
"""Channels whose differences, and whose drifts, are drawn"""
LITTLE_AMPLIFICATION = 10.0  # times; up to it a linear axis shows more than whole decades do
MOST_LINES = 4  # joints or bars that are shown: as many as the paper's chain has joints, and pens are told apart
MARKS = 12  # of one engine on a line: those of six stay apart
AXES = {"x": "z1", "y": "z2"}
SOLUTION_PEN = Pen(COLOURS["ink"])
TORQUE_PEN = Pen(COLOURS["ink"], "", DASHES[1])
Window = tuple[float, float] | None
"""Part of a run that a chart shows, s; None for the whole run"""


def chart_groups(data: SceneData) -> list[ChartGroup]:
    """All charts of a scene."""
    found = (reaction_group(data), joint_group(data), prescribed_group(data), difference_group(data), drift_group(data))
    return [g for g in found if g and any(g.panels)]


def error_panel(
    data: SceneData, quantity: str, what: str = "difference", title: str = ""
) -> tuple[Panel | None, list[str]]:
    """One difference, up to its predictability limit, or one drift, over the whole run; and the engines shown.

    What explains it (a difference's tolerance, a drift's bound) is dashed.
    """
    lines = {}
    for engine, table in data.differences.items():
        y = column(table, f"{quantity}_{what}")
        if y is not None:
            t, limit_s = table["t_s"].to_numpy(float), np.inf
            bound = column(table, f"{quantity}_{'tolerance' if what == 'difference' else 'bound'}")
            if what == "difference":
                limit_s = data.limit_s(engine, quantity)
            seen = t <= limit_s
            cut = limit_s < SHORT_OF_THE_RUN * data.end_s
            dashed = None if bound is None else bound[seen]
            lines[engine] = Line(t[seen], np.abs(y[seen]), data.pens[engine], dashed, cut)
    channel = CHANNELS[quantity]
    label = channel.share_of or channel.unit
    return log_panel(data.frame(title or channel.shown_title, label, list(lines.values()))), list(lines)


def difference_group(data: SceneData) -> ChartGroup:
    """Charts of all differences."""
    found = [error_panel(data, q) for q in DIFFERENCES]
    text = "Dashed: explained part of the difference. A tick marks a line that ends at its predictability limit."
    return ChartGroup("Differences from the judging solution", text, shared_legend(data, found), [p for p, _ in found])


def drift_group(data: SceneData) -> ChartGroup:
    """Charts of all drifts and of the error amplification."""
    found = [error_panel(data, q, "drift") for q in DRIFTS]
    drawn = [p for p, _ in found if p]
    text = "Drifts over the whole run, also beyond the predictability limit. Dashed: their bounds." if drawn else ""
    panels = [*drawn, amplification_panel(data)]
    return ChartGroup("Drifts and error amplification", text, shared_legend(data, found), panels)


def amplification_panel(data: SceneData) -> Panel | None:
    """Error amplification over time; None where it is not stored."""
    table = data.results.differences(data.scene.name, AMPLIFICATION)
    y = None if table is None else column(table, "amplification")
    if table is None or y is None:
        return None
    lines = [Line(table["t_s"].to_numpy(float), y, SOLUTION_PEN)]
    frame = data.frame("Error amplification", "times the initial perturbation", lines)
    return log_panel(frame) if np.nanmax(y) > LITTLE_AMPLIFICATION else linear_panel(frame)


def shared_legend(data: SceneData, found: list[tuple[Panel | None, list[str]]]) -> list[Legend]:
    """Entries of the engines that appear in any of the panels."""
    used = {e for panel, engines in found if panel for e in engines}
    return [Legend(e, data.pens[e]) for e in data.summary.engines if e in used]


def prescribed_group(data: SceneData) -> ChartGroup | None:
    """Attitude over the run, torque of each rotation over its first few durations, and differences between engines."""
    laws = data.scene.prescribed
    if not laws:
        return None
    panels: list[Panel | None] = [attitude_panel(data)]
    used: list[str] = []
    for p, law in enumerate(laws):
        start, end = data.manoeuvre(law)
        lines = torque_lines(data, p, law, start, end)
        panels.append(
            scaled_panel(data, f"Torque on bar {law.get('bar', '?')}", "N m", list(lines.values()), (start, end))
        )
        used += [e for e in lines if e not in (*used, SOLUTION)]
    panels.append(error_panel(data, "torque", title="Difference of the torque from the judging solution")[0])
    legend = (*(Legend(e, data.pens[e]) for e in used), Legend("judging solution", TORQUE_PEN))
    return ChartGroup("Prescribed rotation", "Angles and torques are positive counter-clockwise.", legend, panels)


def attitude_panel(data: SceneData) -> Panel | None:
    """Angles of the judging solution from the start: of bars that a law turns, then of others; None without any."""
    angle = None if data.solution is None else numbered(data.solution, *CHANNELS["attitude"].columns)
    if data.solution is None or angle is None:
        return None
    turned = [int(law["bar"]) - 1 for law in data.scene.prescribed if isinstance(law.get("bar"), int)]
    shown = sorted(list(dict.fromkeys([*turned, *evenly(angle.shape[1])]))[:MOST_LINES])
    axes = "inertial axes"
    if any(law.get("frame") == "local_horizontal" for law in data.scene.prescribed):
        com = data.solution[["com_x_m", "com_y_m"]].to_numpy(float)
        angle = angle - np.unwrap(np.arctan2(com[:, 1], com[:, 0]))[:, None] + 0.5 * np.pi
        axes = "the chain's local horizontal"
    t = data.solution["t_s"].to_numpy(float)
    lines = [Line(t, np.degrees(angle[:, j]), joint_pen(k)) for k, j in enumerate(shown)]
    panel = linear_panel(data.frame(f"Attitude from {axes}", "°", lines))
    legend = tuple(Legend(f"bar {j + 1}", joint_pen(k)) for k, j in enumerate(shown))
    return panel and replace(panel, note="Judging solution.", legend=legend)


def joint_group(data: SceneData) -> ChartGroup | None:
    """Angle and rate of each joint in the judging solution: what bar j+1 has more than bar j; None without joints."""
    if data.solution is None:
        return None
    t, shown = data.solution["t_s"].to_numpy(float), list[int]()
    panels: list[Panel | None] = []
    for derived, of_bars in (("joint_angle", "attitude"), ("joint_rate", "rate")):
        values, channel = numbered(data.solution, *CHANNELS[of_bars].columns), DERIVED_CHANNELS[derived]
        if values is None or values.shape[1] < 2:
            return None
        between = np.diff(values, axis=1)
        shown = evenly(between.shape[1])
        lines = [Line(t, between[:, j], joint_pen(k)) for k, j in enumerate(shown)]
        panels.append(linear_panel(data.frame(channel.shown_title, channel.unit, lines)))
    text = f"{DERIVED_CHANNELS['joint_angle'].meaning} Positive counter-clockwise; judging solution."
    return ChartGroup("Joints", text, [Legend(f"joint {j + 1}", joint_pen(k)) for k, j in enumerate(shown)], panels)


def torque_lines(data: SceneData, p: int, law: dict[str, object], start_s: float, end_s: float) -> dict[str, Line]:
    """Torque of the p-th rotation in every engine that has it, the judging solution on top."""
    # by its bar or by its number; before 0.7 by the number alone
    names = f"torque_bar_{law.get('bar')}_N_m", f"torque_law_{p + 1}_N_m", f"torque_{p + 1}_N_m"
    lines = {}
    for engine in (*data.summary.engines, SOLUTION):
        own = engine == SOLUTION
        table = data.solution if own else data.results.trajectory(data.scene.name, engine)
        found = [] if table is None else [v for name in names if (v := column(table, name)) is not None]
        if table is not None and found:
            t = table["t_s"].to_numpy(float)
            seen = (t >= start_s) & (t <= end_s)
            pen, width = (TORQUE_PEN, 1.8) if own else (data.pens[engine], 1.4)
            lines[engine] = Line(t[seen], found[0][seen], pen, width=width)
    return lines


class Reactions(NamedTuple):
    """Reactions of one run."""

    t_s: Array
    """(n,)"""
    of: dict[str, Array]
    """Component x or y: (n, joints)"""
    limit_s: float


def stored_reactions(table: pd.DataFrame | None, limit_s: float) -> Reactions | None:
    """Reactions of a stored trajectory; None without any."""
    if table is None or not len(table):
        return None
    x, y = (numbered(table, column) for column in CHANNELS["reaction"].columns)
    if x is None or y is None:
        return None
    return Reactions(table["t_s"].to_numpy(float), {"x": x, "y": y}, limit_s)


def reaction_group(data: SceneData) -> ChartGroup | None:
    """Both components over the whole run and at the first manoeuvre, and independent engines on the largest one."""
    solution = stored_reactions(data.solution, data.solution_end_s)
    if solution is None:
        return None
    shown = evenly(solution.of["x"].shape[1])
    windows: list[Window] = [None]
    if data.scene.prescribed:
        start, end = data.manoeuvre(data.scene.prescribed[0])
        windows += [(start, end)] if end - start < 0.5 * data.end_s else []
    panels = [component_panel(data, solution, shown, c, window) for window in windows for c in AXES]
    text = "Force on bar j from bar j+1 in inertial axes; judging solution."
    if data.solution_end_s < data.end_s:
        text += " Faint: beyond its predictability limit."
    legend = [Legend(f"joint {j + 1}", joint_pen(k)) for k, j in enumerate(shown)]
    return ChartGroup("Reactions", text, legend, [*panels, independent_panel(data, solution, windows[-1])])


def component_panel(
    data: SceneData, solution: Reactions, shown: list[int], component: str, window: Window
) -> Panel | None:
    """One component of some joints; lines beyond the predictability limit come first, below the others."""
    start, end = window or (0.0, data.end_s)
    t, values = solution.t_s, solution.of[component]
    seen = (t >= start) & (t <= end)
    parts = ((True, seen & (t >= solution.limit_s)), (False, seen & (t <= solution.limit_s)))
    lines = [
        Line(t[part], values[part, joint], joint_pen(k), faint=faint)
        for faint, part in parts
        if part.any()
        for k, joint in enumerate(shown)
    ]
    mark = data.solution_end_s if start < data.solution_end_s < end else None
    title = f"Component along {AXES[component]}{', at the manoeuvre' if window else ''}"
    return scaled_panel(data, title, "N", lines, window, mark)


def independent_panel(data: SceneData, solution: Reactions, window: Window) -> Panel | None:
    """Largest component: judging solution as a line, marks of every independent engine on it."""
    runs: dict[str, Reactions] = {}
    for engine in filter(data.summary.external, data.summary.engines):
        limit_s = min(data.limit_s(engine, "reaction"), data.solution_end_s)
        run = stored_reactions(data.results.trajectory(data.scene.name, engine), limit_s)
        if run and run.of["x"].shape[1] == solution.of["x"].shape[1]:
            runs[engine] = run
    start, end = window or (
        0.0,
        min([data.end_s, *([float(np.median([r.limit_s for r in runs.values()]))] if runs else [])]),
    )
    seen = (solution.t_s >= start) & (solution.t_s <= end)
    if not runs or seen.sum() < 2:
        return None
    largest = {c: np.nanmax(np.abs(v[seen]), axis=0, initial=0.0) for c, v in solution.of.items()}
    component = max(largest, key=lambda c: float(largest[c].max()))
    joint = int(largest[component].argmax())
    t, y = solution.t_s[seen], solution.of[component][seen, joint]
    lines = [Line(t, y, SOLUTION_PEN, width=1.0)]
    for k, (engine, run) in enumerate(runs.items()):
        at = nearest(run, spread(t, y, k / len(runs)))
        lines.append(Line(run.t_s[at], run.of[component][at, joint], hollow(data.pens[engine])))
    title = f"Joint {joint + 1} along {AXES[component]}, independent engines"
    made = scaled_panel(data, title, "N", lines, window, end_s=end)
    note = "Marks: samples of each engine up to its predictability limit."
    if window is None and end < data.end_s:
        note += " The panel ends at the median of these limits."
    legend = (Legend("judging solution", SOLUTION_PEN), *(Legend(e, hollow(data.pens[e])) for e in runs))
    return made and replace(made, note=note, legend=legend)


def scaled_panel(
    data: SceneData,
    title: str,
    unit: str,
    lines: list[Line],
    window: Window,
    mark_s: float | None = None,
    end_s: float | None = None,
) -> Panel | None:
    """Panel of lines in s and a unit, which gets an SI prefix; `mark_s` is a predictability limit, `end_s` its end."""
    factor, label = prefixed(max((float(np.nanmax(np.abs(x.y), initial=0.0)) for x in lines), default=0.0), unit)
    frame = data.frame(title, label, [line.scaled(1.0, factor) for line in lines], window)
    unit_s = data.unit_s if window is None else 1.0
    if mark_s is not None:
        frame.mark, frame.mark_label = mark_s / unit_s, "predictability limit"
    if end_s is not None:
        frame.x_span = (frame.x_span[0], end_s / unit_s)
    return linear_panel(frame)


def evenly(count: int) -> list[int]:
    """Indices of the joints or bars that are shown of many."""
    return sorted(set(np.linspace(0, count - 1, min(count, MOST_LINES)).round().astype(int).tolist()))


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
