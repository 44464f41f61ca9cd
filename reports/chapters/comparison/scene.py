"""One scene's part of a report: its facts, its tables, and the axes and pens that all its charts share."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from reports.chapters.comparison.summary import SHORT_OF_THE_RUN
from reports.page import paragraphs
from reports.plotting.palette import engine_pen
from reports.plotting.panels import ChartFrame
from reports.results.comparison import LINEAR_GROWTH, SOLUTION
from reports.results.outcome import Outcome
from reports.text.numerals import number
from reports.text.words import anchor

if TYPE_CHECKING:
    from collections.abc import Sequence

    from reports.chapters.comparison.summary import Summary
    from reports.plotting.panels import Legend, Line, Panel
    from reports.results.files import StudyTables
    from reports.text.record import SceneRecord

MANOEUVRES = 4.0  # durations of a prescribed rotation that its own charts cover
COVERAGE = {"lack": {}, "instants": {}, "not_requested": [], "not_installed": [], "not_loaded": {}, "solution": ""}


def judged_by(scene: SceneRecord) -> str:
    """Solution that judges the engines: its origin, its engine and the accuracy of its runs."""
    made = ", ".join(filter(None, [scene.text("solution_engine"), scene.text("solution_setting")]))
    source = scene.text("solution_source")
    return f"{source} ({made})" if source and made else source or made


def facts(scene: SceneRecord, *, of_track: bool = True) -> list[tuple[str, str]]:
    """Physics of a scene as pairs of a name and a value, without values that are not recorded.

    Parameters
    ----------
    scene : SceneRecord
    of_track : bool
        Whether an engine ran that follows the centre of mass alone: the model difference applies to such engines.
    """
    shown = {"of_track": of_track, "judge": judged_by(scene), "whole": SHORT_OF_THE_RUN, "most": LINEAR_GROWTH}
    pairs = (part.partition(": ")[::2] for part in paragraphs("comparison/facts.txt.j2", scene=scene, **shown))
    return [(name, value.strip()) for name, value in pairs if value.strip()]


class Coverage(NamedTuple):
    """Why independent engines did not run a scene."""

    alone: bool
    """Whether none of them did"""
    text: str


def coverage_of(summary: Summary, scene: SceneRecord) -> Coverage | None:
    """Reasons why independent engines did not run a scene; None if all of them could."""
    outside = [c for c in summary.of_scene(scene.name) if summary.external(c.engine)]
    stored = scene.data.get("external_coverage") or {}
    known = COVERAGE | stored
    alone = bool(outside) and all(c.outcome is Outcome.UNSUPPORTED for c in outside)
    lacking = bool(stored) and all(c.engine in known["lack"] for c in outside)
    lines = paragraphs("comparison/coverage.txt.j2", alone=alone, known=known, lacking=lacking)
    return Coverage(alone, " ".join(lines)) if lines else None


class ChartGroup(NamedTuple):
    """Charts that share a legend; those without anything to draw are None."""

    heading: str
    text: str
    legend: Sequence[Legend]
    panels: Sequence[Panel | None]


class SceneData:
    """Tables of one scene with the shared axes of its charts."""

    def __init__(self, results: StudyTables, summary: Summary, scene: SceneRecord) -> None:
        self.results, self.summary, self.scene = results, summary, scene
        self.solution = results.trajectory(scene.name, SOLUTION)
        self.id = anchor(scene.name)
        self.unit_s = scene.period_s if scene.in_orbits else 1.0
        self.x_label = "orbits" if scene.in_orbits else "time, s"
        self.pens = {e: engine_pen(k) for k, e in enumerate(summary.engines)}
        found = {e: results.differences(scene.name, e) for e in summary.engines}
        self.differences = {e: d for e, d in found.items() if d is not None and len(d) > 1}
        tables = [*self.differences.values(), *([] if self.solution is None else [self.solution])]
        ends = [float(t["t_s"].max()) for t in tables if "t_s" in t and len(t)]
        self.end_s = max(scene.value("duration_s") or 0.0, *ends, 0.0) or 1.0

    @property
    def solution_end_s(self) -> float:
        """Predictability limit of the judging solution, s; infinite where it covers the run."""
        limit_s = self.scene.value("solution_limit_s")
        return np.inf if limit_s is None or limit_s > SHORT_OF_THE_RUN * self.end_s else limit_s

    def limit_s(self, engine: str, quantity: str) -> float:
        """End of the pointwise comparison, s; infinite where none is stored."""
        cell = self.summary.cell(self.scene.name, engine)
        row = cell.row(quantity) if cell else None
        return np.inf if row is None or row.limit_s is None else row.limit_s

    def manoeuvre(self, law: dict[str, object]) -> tuple[float, float]:
        """Interval of time of a prescribed rotation's own charts, s."""
        start, length = number(law.get("start_s")) or 0.0, number(law.get("duration_s")) or 0.0
        return start, min(start + MANOEUVRES * length, self.end_s) if length > 0.0 else self.end_s

    def frame(
        self, title: str, y_label: str, lines: list[Line], span_s: tuple[float, float] | None = None
    ) -> ChartFrame:
        """Chart frame over the whole run, or over a part of it in seconds; its lines are in s."""
        start, end = span_s or (0.0, self.end_s)
        label, unit_s = (self.x_label, self.unit_s) if span_s is None else ("time, s", 1.0)
        scaled = [replace(line, x=line.x / unit_s) for line in lines]
        return ChartFrame(title, label, y_label, (start / unit_s, end / unit_s), scaled)
