"""Pictures at the top of a report: the first scene's chain along its orbit, and all normalised errors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from reports.chapters.crossval.agreement import agreement_panel
from reports.chapters.crossval.scene_data import SceneData
from reports.chapters.crossval.scene_view import orbits

if TYPE_CHECKING:
    from collections.abc import Sequence

    from reports.chapters.crossval.matrix import EngineGroup
    from reports.chapters.crossval.summary import Summary
    from reports.plotting.panels import Panel
    from reports.tables.crossval import Results
    from reports.text.record import SceneRecord


@dataclass(frozen=True)
class OpeningView:
    """Pictures at the top."""

    scene: SceneRecord | None
    """Scene of the chain's picture"""
    chain: Panel | None
    agreement: Panel | None


def opening(results: Results, summary: Summary, groups: Sequence[EngineGroup]) -> OpeningView:
    """Pictures at the top of a report; each is None where the tables hold nothing to draw."""
    agreement = agreement_panel(summary, groups)
    for scene in summary.scenes:
        panels = orbits(SceneData(results, summary, scene), "opening")
        if panels:
            return OpeningView(scene, panels[-1], agreement)
    return OpeningView(None, None, agreement)
