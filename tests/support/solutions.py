"""Runs of the reference and its solutions, made as the harness makes them: compiled where that is installed."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

from adapters.engine import AccuracyParameter, Setting
from adapters.registry import ENGINES
from barchain.solutions.judging import solution_engine
from barchain.solutions.reference import FINE_RTOL, densely_sampled, establish, with_perturbed_start

if TYPE_CHECKING:
    from adapters.trajectory import Trajectory
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

REFERENCE = ENGINES[solution_engine()].load()


@functools.lru_cache(256)
def run(scene: Scene, rtol: float) -> Trajectory:
    """Run of the reference."""
    found: Trajectory = REFERENCE().run(scene, Setting(AccuracyParameter.RTOL, rtol))
    return found


@functools.lru_cache(8)
def solution_of(scene: Scene, *, dense: bool = True) -> ReferenceSolution:
    """Reference solution of a scene, with samples close together or with the scene's own alone."""
    close = run(densely_sampled(scene), FINE_RTOL) if dense else None
    return establish(scene, run(scene, 1e-13), run(scene, 1e-12), run(with_perturbed_start(scene), 1e-13), close)
