"""One scene's section: its facts and its charts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from reports.chapters.crossval.differences import DifferenceCharts
from reports.chapters.crossval.external_coverage import coverage_words
from reports.chapters.crossval.facts import Fact, facts
from reports.chapters.crossval.orbit import DrawnMotion, Geometry, orbit_panels
from reports.chapters.crossval.prescribed import prescribed_motion
from reports.chapters.crossval.reactions import ReactionCharts
from reports.chapters.crossval.scene_data import SceneData
from reports.plotting.series import numbered

if TYPE_CHECKING:
    from reports.chapters.crossval.scene_data import ChartGroup
    from reports.chapters.crossval.summary import RunCell, Summary
    from reports.plotting.panels import Panel
    from reports.tables.crossval import Results
    from reports.text.record import SceneRecord


@dataclass(frozen=True)
class SceneView:
    """Contents of a scene's section."""

    scene: SceneRecord
    anchor: str
    facts: tuple[tuple[str, Fact], ...]
    orbits: tuple[Panel, ...]
    groups: tuple[ChartGroup, ...]
    cells: tuple[RunCell, ...]
    coverage: tuple[str, str] | None
    """Reasons why independent engines were skipped: a headline where all were, and details; None without any"""


def view_scene(results: Results, summary: Summary, scene: SceneRecord) -> SceneView:
    """View of one scene."""
    data = SceneData(results, summary, scene)
    differences = DifferenceCharts(data)
    groups = (
        ReactionCharts(data).group(),
        prescribed_motion(data, differences),
        differences.difference_group(),
        differences.drift_group(),
    )
    return SceneView(
        scene,
        data.id,
        tuple(facts(scene, of_track=summary.of_track(scene.name))),
        tuple(orbits(data)),
        tuple(g for g in groups if g),
        tuple(summary.shown_in(scene.name)),
        coverage_words(summary, scene),
    )


def orbits(data: SceneData) -> list[Panel]:
    """Drawings of the chain along its orbit."""
    s, length, mass = data.scene, data.scene.values("length_m"), data.scene.values("mass_kg")
    angle = None if data.solution is None else numbered(data.solution, r"angle_(\d+)_rad")
    if data.solution is None or angle is None or not len(length) == len(mass) == angle.shape[1]:
        return []
    radius = 0.0 if s.text("gravity") == "none" else s.value("body_radius_m") or 0.0
    geometry = Geometry(np.array(length), np.array(mass), radius, s.period_s or 1.0, s.closed)
    com = data.solution[["com_x_m", "com_y_m"]].to_numpy(float)
    return orbit_panels(
        data.id, geometry, DrawnMotion(data.solution["t_s"].to_numpy(float), com, angle, data.solution_end_s)
    )
