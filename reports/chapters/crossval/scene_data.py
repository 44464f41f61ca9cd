"""Stored tables of one scene, and the axes and pens that all its charts share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from reports.chapters.crossval.summary import SHORT_OF_THE_RUN
from reports.plotting.palette import engine_pen
from reports.plotting.panels import ChartFrame
from reports.tables.crossval import SOLUTION
from reports.text.numerals import number
from reports.text.words import anchor

if TYPE_CHECKING:
    from reports.chapters.crossval.summary import Summary
    from reports.plotting.panels import Legend, Line, Panel
    from reports.tables.crossval import Results
    from reports.text.record import SceneRecord

MANOEUVRES = 4.0  # durations of a prescribed rotation that its own charts cover


@dataclass(frozen=True)
class ChartGroup:
    """Charts that share a legend."""

    heading: str
    text: str
    legend: tuple[Legend, ...]
    panels: tuple[Panel, ...]


def group(heading: str, text: str, legend: tuple[Legend, ...], panels: list[Panel | None]) -> ChartGroup | None:
    """Group of the existing panels; None without any."""
    found = tuple(p for p in panels if p)
    return ChartGroup(heading, text, legend, found) if found else None


class SceneData:
    """Tables of one scene with the shared axes of its charts."""

    def __init__(self, results: Results, summary: Summary, scene: SceneRecord) -> None:
        self.results, self.summary, self.scene = results, summary, scene
        self.solution = results.trajectory(scene.name, SOLUTION)
        self.id = anchor(scene.name)
        self.unit_s = scene.period_s if scene.in_orbits else 1.0
        self.x_label = "orbits" if scene.in_orbits else "time, s"
        self.pens = {e: engine_pen(k) for k, e in enumerate(summary.engines)}
        found = {e: results.differences(scene.name, e) for e in summary.engines}
        self.differences = {e: d for e, d in found.items() if d is not None and len(d) > 1}
        self.end_s = self.longest()

    def longest(self) -> float:
        """End of the run: as recorded, or as far as any table goes."""
        ends = [self.scene.value("duration_s") or 0.0]
        tables = [*self.differences.values(), *([self.solution] if self.solution is not None else [])]
        ends += [float(t["t_s"].max()) for t in tables if "t_s" in t and len(t)]
        return max(ends) or 1.0

    @property
    def solution_end_s(self) -> float:
        """Predictability limit of the judging solution, s; infinite where it covers the run."""
        predictability_limit = self.scene.value("solution_limit_s")
        return (
            np.inf
            if predictability_limit is None or predictability_limit > SHORT_OF_THE_RUN * self.end_s
            else predictability_limit
        )

    def predictability_limit(self, engine: str, quantity: str) -> float:
        """End of the pointwise comparison, s; infinite where none is stored."""
        cell = self.summary.cell(self.scene.name, engine)
        row = cell.row(quantity) if cell else None
        return np.inf if row is None or row.limit_s is None else row.limit_s

    def manoeuvre(self, law: dict[str, object]) -> tuple[float, float]:
        """Interval of time of a prescribed rotation's own charts, s."""
        start, length = number(law.get("start_s")) or 0.0, number(law.get("duration_s")) or 0.0
        return start, min(start + MANOEUVRES * length, self.end_s) if length > 0.0 else self.end_s

    def frame(self, title: str, y_label: str, lines: list[Line]) -> ChartFrame:
        """Chart frame over the whole run."""
        return ChartFrame(title, self.x_label, y_label, (0.0, self.end_s / self.unit_s), lines)
