"""A run in segments, from one jump of the loads to the next.

The trapezoidal rule and generalized-alpha use the accelerations at one step's end in the next step. Where a thrust
starts or ends these differ. The run therefore ends there, and restarts from its state with accelerations of the new
loads. An explicit method has no such memory, and needs no segments.
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
    """Segments of a run's steps."""

    steps: Steps
    per_sample: int
    """Steps from sample to sample"""
    boundaries: tuple[int, ...]
    """Steps at whose ends segments start and end, 0 and the last one included"""

    @property
    def stride(self) -> int:
        """Steps from one stored row to the next; samples and boundaries are among the rows."""
        return math.gcd(self.per_sample, *self.boundaries)

    def samples(self, first: int, rows: int) -> Array:
        """Whether each of `rows` stored in the segment from step `first` is a sample.

        At a boundary the earlier segment gives the sample: the motion just before the jump.
        """
        step = first + self.stride * np.arange(rows)
        chosen: Array = (step % self.per_sample == 0) & ((step > first) | (first == 0))
        return chosen


def segments_of(scene: Scene, steps: Steps, method: Method) -> RestartSegments:
    """Segments of a run; a single one without jumps."""
    boundaries = [] if method.explicit else jump_steps(scene, steps)
    return RestartSegments(steps, steps.count // (scene.run.samples - 1), (0, *boundaries, steps.count))


def run_segments(model: Model, segments: RestartSegments, settings: Any, method: Method) -> bool:
    """Run one segment after the other; return whether the last one reached its end."""
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
    """Start from the current state, with the loads after the end of `step`."""
    kinds, data = exu().ConfigurationType, model.mbs.systemData
    data.SetSystemState(data.GetSystemState(kinds.Current), kinds.Initial)
    for table in model.tables:
        table.resume(step)
