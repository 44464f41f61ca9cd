"""A run in pieces, from one jump of what acts to the next.

The trapezoidal rule and generalized-alpha carry the accelerations of one step's end into the next step. Where a
thrust starts or ends these are not the same, so that the run ends there, and begins anew from the state reached with
accelerations found for what acts from then on. An explicit method keeps nothing, and needs no pieces.
"""

from __future__ import annotations

import functools
import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.exudyn.library import exu
from adapters.exudyn.loads.thrust import jump_steps
from adapters.exudyn.solve.solver import SAMPLE_SLACK, solver_of

if TYPE_CHECKING:
    from adapters.exudyn.models.model import Model
    from adapters.exudyn.solve.solver import Method
    from adapters.exudyn.timetable import Steps
    from adapters.trajectory import Array
    from scenarios import Scene


@dataclass(frozen=True)
class RestartSegments:
    """A run's steps, divided."""

    steps: Steps
    per_sample: int
    """Steps from sample to sample"""
    boundaries: tuple[int, ...]
    """Steps at whose ends pieces start and end, 0 and the last one included"""

    @property
    def stride(self) -> int:
        """Steps from one stored row to the next: samples and marks are among them."""
        return math.gcd(self.per_sample, *self.boundaries)

    def samples(self, first: int, rows: int) -> Array:
        """Whether each of `rows` stored in the piece from step `first` is a sample.

        At a mark it is the piece before that shows what the sample is: the motion just before the jump.
        """
        step = first + self.stride * np.arange(rows)
        chosen: Array = (step % self.per_sample == 0) & ((step > first) | (first == 0))
        return chosen


def segments_of(scene: Scene, steps: Steps, method: Method) -> RestartSegments:
    """Pieces of a run; one only, where nothing jumps."""
    boundaries = [] if method.explicit else jump_steps(scene, steps)
    return RestartSegments(steps, steps.count // (scene.run.samples - 1), (0, *boundaries, steps.count))


def run_segments(model: Model, segments: RestartSegments, settings: Any, method: Method) -> bool:
    """Run one piece after the other; whether the last one got to its end."""
    h = segments.steps.size_s
    settings.solution.sensors.writePeriod = segments.stride * h * (1.0 - SAMPLE_SLACK)
    time = settings.timeIntegration
    for first, last in itertools.pairwise(segments.boundaries):
        if first:
            resume(model, first)
        time.startTime, time.endTime, time.numberOfSteps = h * first, h * last, last - first
        finished = bool(solver_of(method).SolveSystem(model.mbs, settings))
        model.store_segment(functools.partial(segments.samples, first))
        if not finished:
            return False
    return True


def resume(model: Model, step: int) -> None:
    """Start from the state reached, with what acts after the end of `step`."""
    kinds, data = exu().ConfigurationType, model.mbs.systemData
    data.SetSystemState(data.GetSystemState(kinds.Current), kinds.Initial)
    for table in model.tables:
        table.resume(step)
