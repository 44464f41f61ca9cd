"""One scene's section: its facts and its charts."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from reports.charts import Frame, Line, Panel, linear_panel, log_panel
from reports.numerals import each, number, prefixed, significant, span
from reports.orbit_chart import Geometry, Motion, orbit_panels
from reports.palette import COLOURS, DASHES, Pen, engine_pen, joint_pen
from reports.record import SceneRecord
from reports.series import Array, column, numbered
from reports.summary import SHORT_OF_THE_RUN
from reports.tables import GROWTH, QUANTITY_UNITS, TRUTH, Results

if TYPE_CHECKING:
    from reports.summary import Cell, Summary

DIFFERENCES = {
    "attitude": "Attitude",
    "reaction": "Reactions",
    "com": "CM track",
}
DRIFTS = {
    "gap": "Joint gap",
    "identity": "Identity (6)",
    "energy": "Energy",
    "angular_momentum": "Angular momentum",
}
MOST_JOINTS = 4  # as many as the paper's chain has
MANOEUVRES = 4.0  # durations of the prescribed rotation that its torque is shown for
Fact = str | tuple[float, str]  # words, or a number and its unit
TRUTH_PEN = Pen(COLOURS["ink"], "", DASHES[1])


@dataclass(frozen=True)
class Legend:
    """One entry of a legend set beside the charts."""

    label: str
    pen: Pen


@dataclass(frozen=True)
class Group:
    """Charts that share a legend."""

    heading: str
    text: str
    legend: tuple[Legend, ...]
    panels: tuple[Panel, ...]


@dataclass(frozen=True)
class SceneView:
    """What the template shows of a scene."""

    scene: SceneRecord
    anchor: str
    facts: tuple[tuple[str, Fact], ...]
    orbits: tuple[Panel, ...]
    groups: tuple[Group, ...]
    cells: tuple[Cell, ...]


def anchor(name: str) -> str:
    """Name fit for an id."""
    return "scene-" + re.sub(r"[^A-Za-z0-9_.]", lambda m: "-" if m[0] == "/" else f"-{ord(m[0]):x}-", name)


class SceneCharts:
    """Draws the charts of one scene from its stored tables."""

    def __init__(self, results: Results, summary: Summary, scene: SceneRecord) -> None:
        self.results, self.summary, self.scene = results, summary, scene
        self.truth = results.trajectory(scene.name, TRUTH)
        self.id = anchor(scene.name)
        self.unit_s = scene.period_s if scene.closed else 1.0
        self.x_label = "orbits" if scene.closed else "time, s"
        self.pens = {e: engine_pen(k) for k, e in enumerate(summary.engines)}
        found = {e: results.differences(scene.name, e) for e in summary.engines}
        self.differences = {e: d for e, d in found.items() if d is not None and len(d) > 1}
        self.end_s = self.longest()

    def longest(self) -> float:
        """End of the run: as recorded, or as far as any table goes."""
        ends = [self.scene.value("duration_s") or 0.0]
        tables = [*self.differences.values(), *([self.truth] if self.truth is not None else [])]
        ends += [float(t["t_s"].max()) for t in tables if "t_s" in t and len(t)]
        return max(ends) or 1.0

    def frame(self, name: str, title: str, y_label: str, lines: list[Line]) -> Frame:
        """Frame over the whole run."""
        return Frame(f"{self.id}-{name}", title, self.x_label, y_label, (0.0, self.end_s / self.unit_s), lines)

    def orbits(self) -> list[Panel]:
        """Chain along its orbit."""
        s, length, mass = self.scene, self.scene.values("length_m"), self.scene.values("mass_kg")
        angle = None if self.truth is None else numbered(self.truth, r"angle_(\d+)_rad")
        if self.truth is None or angle is None or not len(length) == len(mass) == angle.shape[1]:
            return []
        radius = 0.0 if s.text("gravity") == "none" else s.value("body_radius_m") or 0.0
        geometry = Geometry(np.array(length), np.array(mass), radius, s.period_s or 1.0, s.closed)
        com = self.truth[["com_x_m", "com_y_m"]].to_numpy(float)
        return orbit_panels(self.id, geometry, Motion(self.truth["t_s"].to_numpy(float), com, angle))

    def reactions(self) -> Group | None:
        """Reaction components of the truth."""
        if self.truth is None:
            return None
        components = [numbered(self.truth, rf"reaction_(\d+)_{c}_N") for c in "xy"]
        x, y = components
        if x is None or y is None:
            return None
        shown = np.unique(np.linspace(0, x.shape[1] - 1, min(x.shape[1], MOST_JOINTS)).round().astype(int))
        panels = [
            self.reaction_panel(f"{letter}{k}", f"Component along z{axis}{when}", values[:, shown], window)
            for k, (when, window) in enumerate(self.windows())
            for letter, axis, values in (("x", 1, x), ("y", 2, y))
        ]
        legend = tuple(Legend(f"joint {j + 1}", joint_pen(k)) for k, j in enumerate(shown))
        text = "Force on bar j from bar j+1, inertial axes; the truth."
        if self.truth_end_s < self.end_s:
            text += f" Faint after its own horizon ({truth_holds(self.scene)}): one of many motions possible there."
        return group("Reactions", text, legend, panels)

    @property
    def truth_end_s(self) -> float:
        """Instant after which the truth is no longer one, s; infinite where it holds."""
        horizon = self.scene.value("truth_horizon_s")
        return np.inf if horizon is None or horizon > SHORT_OF_THE_RUN * self.end_s else horizon

    def windows(self) -> list[tuple[str, tuple[float, float] | None]]:
        """Give the whole run, and the first manoeuvre where it would not be seen in the whole."""
        found: list[tuple[str, tuple[float, float] | None]] = [("", None)]
        if self.scene.prescribed:
            start, end = self.manoeuvre(self.scene.prescribed[0])
            if end - start < 0.5 * self.end_s:
                found.append((", at the manoeuvre", (start, end)))
        return found

    def manoeuvre(self, law: dict[str, object]) -> tuple[float, float]:
        """Stretch of time in which a prescribed rotation is looked at, s."""
        start, length = number(law.get("start_s")) or 0.0, number(law.get("duration_s")) or 0.0
        return start, min(start + MANOEUVRES * length, self.end_s) if length > 0.0 else self.end_s

    def reaction_panel(
        self, name: str, title: str, values: Array, window_s: tuple[float, float] | None
    ) -> Panel | None:
        """One component of some joints, over the whole run or over a stretch of it."""
        assert self.truth is not None
        t = self.truth["t_s"].to_numpy(float)
        start, end = window_s or (0.0, self.end_s)
        seen = (t >= start) & (t <= end)
        factor, unit = prefixed(float(np.nanmax(np.abs(values[seen]), initial=0.0)), "N")
        unit_s = self.unit_s if window_s is None else 1.0
        sure, unsure = seen & (t <= self.truth_end_s), seen & (t >= self.truth_end_s)
        lines = [
            Line(t[part] / unit_s, factor * values[part, k], joint_pen(k), faint=part is unsure)
            for part in (unsure, sure)
            if part.any()
            for k in range(values.shape[1])
        ]
        label = self.x_label if window_s is None else "time, s"
        span_shown = (start / unit_s, end / unit_s)
        return linear_panel(Frame(f"{self.id}-reaction-{name}", title, label, unit, span_shown, lines))

    def torques(self) -> Group | None:
        """Torque of each prescribed rotation in its first few durations, truth and engines."""
        panels, used = [], []
        for p, law in enumerate(self.scene.prescribed):
            start, end = self.manoeuvre(law)
            lines, engines = self.torque_lines(p, start, end)
            largest = max((float(np.nanmax(np.abs(li.y), initial=0.0)) for li in lines), default=0.0)
            factor, unit = prefixed(largest, "N m")
            scaled = [Line(li.x, factor * li.y, li.pen, width=li.width) for li in lines]
            name = f"Torque on bar {law.get('bar', '?')}"
            panels.append(linear_panel(Frame(f"{self.id}-torque-{p}", name, "time, s", unit, (start, end), scaled)))
            used += [e for e in engines if e not in used]
        panels.append(self.difference_panel("torque", "Difference from the truth")[0])
        legend = (*(Legend(e, self.pens[e]) for e in used), Legend("truth", TRUTH_PEN))
        return group("Prescribed torque", "Positive counter-clockwise.", legend, panels)

    def torque_lines(self, p: int, start_s: float, end_s: float) -> tuple[list[Line], list[str]]:
        """Torque p of every engine that has it, the truth on top."""
        lines, engines = [], []
        for engine in (*self.summary.engines, TRUTH):
            table = self.truth if engine == TRUTH else self.results.trajectory(self.scene.name, engine)
            values = None if table is None else column(table, f"torque_{p + 1}_N_m")
            if table is None or values is None:
                continue
            t = table["t_s"].to_numpy(float)
            seen = (t >= start_s) & (t <= end_s)
            pen = TRUTH_PEN if engine == TRUTH else self.pens[engine]
            lines.append(Line(t[seen], values[seen], pen, width=1.8 if engine == TRUTH else 1.4))
            engines += [] if engine == TRUTH else [engine]
        return lines, engines

    def difference_panel(self, quantity: str, title: str) -> tuple[Panel | None, list[str]]:
        """Differences of one quantity on a log axis, with what is explained dashed."""
        lines, engines = [], []
        for engine, table in self.differences.items():
            y = column(table, f"{quantity}_difference")
            if y is None:
                continue
            t, horizon = table["t_s"].to_numpy(float), self.horizon(engine, quantity)
            seen = t <= horizon
            tolerance = column(table, f"{quantity}_tolerance")
            shown = None if tolerance is None else tolerance[seen]
            cut = horizon < 0.999 * self.end_s
            lines.append(Line(t[seen] / self.unit_s, y[seen], self.pens[engine], shown, cut))
            engines.append(engine)
        return log_panel(self.frame(quantity, title, QUANTITY_UNITS[quantity], lines)), engines

    def horizon(self, engine: str, quantity: str) -> float:
        """End of the pointwise comparison, s; infinite where none is stored."""
        cell = self.summary.cell(self.scene.name, engine)
        row = cell.row(quantity) if cell else None
        return np.inf if row is None or row.horizon_s is None else row.horizon_s

    def drift_panel(self, quantity: str, title: str) -> tuple[Panel | None, list[str]]:
        """One drift over the whole run, with its band dashed."""
        lines, engines = [], []
        for engine, table in self.differences.items():
            y = column(table, f"{quantity}_drift")
            if y is not None:
                band = column(table, f"{quantity}_band")
                t = table["t_s"].to_numpy(float) / self.unit_s
                lines.append(Line(t, np.abs(y), self.pens[engine], band))
                engines.append(engine)
        unit = QUANTITY_UNITS[quantity]
        return log_panel(self.frame(quantity, title, "relative" if unit == "1" else unit, lines)), engines

    def difference_group(self) -> Group | None:
        """All differences."""
        found = [self.difference_panel(q, title) for q, title in DIFFERENCES.items()]
        text = "Dashed: what the errors of both sides explain. A tick ends a line at its horizon."
        return group("Differences from the truth", text, self.legend(found), [p for p, _ in found])

    def drift_group(self) -> Group | None:
        """All drifts, and the growth of a small perturbation."""
        found = [self.drift_panel(q, title) for q, title in DRIFTS.items()]
        text = "Over the whole run, whatever the horizon; bands dashed." if any(p for p, _ in found) else ""
        panels = [*(p for p, _ in found), self.growth_panel()]
        return group("Drift and growth", text, self.legend(found), panels)

    def growth_panel(self) -> Panel | None:
        """How a small perturbation of the attitude grows."""
        table = self.results.differences(self.scene.name, GROWTH)
        y = None if table is None else column(table, "growth")
        if table is None or y is None:
            return None
        lines = [Line(table["t_s"].to_numpy(float) / self.unit_s, y, Pen(COLOURS["ink"]))]
        return log_panel(self.frame("growth", "Growth of a small perturbation", "times", lines))

    def legend(self, found: list[tuple[Panel | None, list[str]]]) -> tuple[Legend, ...]:
        """Entries of the engines that appear in any of the panels."""
        used = {e for panel, engines in found if panel for e in engines}
        return tuple(Legend(e, self.pens[e]) for e in self.summary.engines if e in used)


def group(heading: str, text: str, legend: tuple[Legend, ...], panels: list[Panel | None]) -> Group | None:
    """Group of the panels that exist; None if none does."""
    found = tuple(p for p in panels if p)
    return Group(heading, text, legend, found) if found else None


def view_scene(results: Results, summary: Summary, scene: SceneRecord) -> SceneView:
    """Everything the page shows of a scene."""
    charts = SceneCharts(results, summary, scene)
    groups = (charts.reactions(), charts.torques(), charts.difference_group(), charts.drift_group())
    return SceneView(
        scene,
        charts.id,
        tuple(facts(scene)),
        tuple(charts.orbits()),
        tuple(g for g in groups if g),
        tuple(summary.of_scene(scene.name)),
    )


def facts(scene: SceneRecord) -> list[tuple[str, Fact]]:
    """Physics of a scene as pairs of a name and a value; what is not recorded is left out."""
    found: list[tuple[str, str | tuple[float | None, str]]] = [
        ("Bars", each(scene.values("length_m"), "m")),
        ("Masses", each(scene.values("mass_kg"), "kg")),
        ("Altitude", altitude(scene)),
        ("Gravity", GRAVITY_WORDS.get(scene.text("gravity"), scene.text("gravity"))),
        ("Period", span(scene.value("period_s")) if scene.closed else ""),
        ("Duration", duration(scene)),
        *((f"Bar {p.get('bar', '?')} turned", prescription_words(p)) for p in scene.prescribed),
        ("Truth", scene.text("truth_setting")),
        ("Truth holds", truth_holds(scene)),
        ("The truth's error", (scene.value("truth_error_rad"), "rad")),
        ("Growth per orbit", (scene.value("growth_per_orbit"), "times")),
        ("Growth in all", (scene.value("growth_total"), "times")),
        ("Model difference", model_difference(scene)),
    ]
    kept: list[tuple[str, Fact]] = []
    for name, value in found:
        if isinstance(value, str):
            kept += [(name, value)] if value else []
        elif value[0] is not None:
            kept.append((name, (value[0], value[1])))
    return kept


def truth_holds(scene: SceneRecord) -> str:
    """Until when the truth is one, where that is before the end of the run."""
    horizon, end = scene.value("truth_horizon_s"), scene.value("duration_s")
    if horizon is None or end is None or horizon > SHORT_OF_THE_RUN * end:
        return "to the end of the run"
    return f"to {horizon / scene.period_s:.2f} orbits" if scene.closed else f"to {horizon:.4g} s"


GRAVITY_WORDS = {
    "gradient": "point force and gradient torque",
    "point": "point mass at each bar",
    "none": "none",
}


def altitude(scene: SceneRecord) -> str:
    """Height of the centre of mass at the start."""
    r, body = scene.value("radius0_m"), scene.value("body_radius_m")
    return "" if r is None or body is None else f"{(r - body) / 1e3:g} km"


def duration(scene: SceneRecord) -> str:
    """``5 orbits in 501 samples``."""
    seconds, samples = scene.value("duration_s"), scene.value("samples")
    if seconds is None:
        return ""
    orbits = seconds / scene.period_s if scene.closed else 0.0
    length = f"{orbits:.4g} orbit{'' if f'{orbits:.4g}' == '1' else 's'}" if scene.closed else f"{seconds:g} s"
    return length + (f" in {samples:.0f} samples" if samples else "")


def prescription_words(law: dict[str, object]) -> str:
    """One prescribed rotation in words."""
    by = {"external": "an outside torque", "joint": "a motor in its joint"}.get(str(law.get("actuator")), "")
    against = str(law.get("frame", "")).replace("_", " ")
    angle, length, start = (number(law.get(k)) for k in ("amplitude_deg", "duration_s", "start_s"))
    parts = [f"by {angle:g}°" if angle is not None else "", f"in {length:g} s" if length is not None else ""]
    parts += [f"from {start:g} s" if start else "", f"by {by}" if by else ""]
    return " ".join(p for p in parts if p) + (f", against the {against} frame" if against else "")


def model_difference(scene: SceneRecord) -> str:
    """Put the declared difference of models into words."""
    declared = scene.model_difference
    com = SceneRecord("", declared).value("com_m")
    note = str(declared.get("note") or "")
    if com is None:
        return note
    return f"CM {significant(com)} m" + (f": {note}" if note else "")
