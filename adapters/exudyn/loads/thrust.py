"""Thrust: a force on a bar's end as a function of time, and the instants of its jumps."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, final

import numpy as np

from adapters.common.step_alignment import half_interval_s
from adapters.exudyn.loads.interface import ExudynLoad, directions_of
from scenarios import Axes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.exudyn.frames.axes import ReferenceFrame
    from adapters.exudyn.frames.inertial_view import InertialView
    from adapters.exudyn.frames.numbers import Number
    from adapters.exudyn.loads.interface import BarForce
    from adapters.exudyn.timetable import Steps
    from adapters.trajectory import Array
    from scenarios import Scene, Thrust

WHOLE = 1e-9  # of half a sample interval: a break this near to a step's end is at it


@final
class ExudynThrust(ExudynLoad):
    """One thruster."""

    def __init__(self, scene: Scene, thrust: Thrust, frame: ReferenceFrame) -> None:
        self.thrust, self.frame = thrust, frame
        self.arm = thrust.end.sign * 0.5 * scene.chain.length_m[thrust.bar - 1]
        self.in_body = thrust.axes is Axes.BODY
        self.time_input_count = 1 if self.in_body else 2

    def acts_on(self, bar: int) -> bool:
        """Whether the thruster is on `bar`."""
        return bar == self.thrust.bar - 1

    def time_inputs(self, at_s: Array, inside_s: Array) -> Array:
        """Force along the bar's axes, or its components in the frame's axes."""
        size = sizes(self.thrust, at_s, inside_s)[:, None]
        if self.in_body:
            return size
        return size * directions_of(self.frame, at_s, np.full_like(at_s, self.thrust.direction_rad))

    def load(self, _bar: int, view: InertialView, inputs: Sequence[Number], _xp: Any) -> BarForce:
        """Force F and torque ±h (u × F)."""
        if not self.in_body:
            x, y = inputs
            return x, y, self.arm * view.to_bar(x, y)[1]
        along, across = math.cos(self.thrust.direction_rad), math.sin(self.thrust.direction_rad)
        x, y = view.to_frame(along, across)
        return inputs[0] * x, inputs[0] * y, inputs[0] * (self.arm * across)


def sizes(thrust: Thrust, at_s: Array, inside_s: Array) -> Array:
    """Force at instants (k,) on the straight segment around other instants (k,), N; 0 outside the table."""
    t, f = np.array(thrust.times_s), np.array(thrust.force_N)
    i = np.searchsorted(t, inside_s) - 1
    within = (i >= 0) & (i < len(t) - 1)
    i = np.clip(i, 0, len(t) - 2)
    line: Array = f[i] + (f[i + 1] - f[i]) * ((at_s - t[i]) / (t[i + 1] - t[i]))
    return np.where(within, line, 0.0)


def jumps_s(scene: Scene) -> list[float]:
    """Instants inside the run at which a thrust starts or ends with a jump."""
    ends = {(t.times_s[i], t.force_N[i]) for t in scene.effects.thrust for i in (0, -1)}
    return sorted({t for t, force in ends if force and 0.0 < t < scene.run.duration_s})


def jump_steps(scene: Scene, steps: Steps) -> list[int]:
    """Steps that end where a thrust starts or ends, without the last step."""
    return sorted({steps.index(t) for t in jumps_s(scene)} - {0, steps.count})


def off_step_s(scene: Scene) -> float | None:
    """First instant of a thrust's table that some number of steps leaves inside a step; None if there is none."""
    half = half_interval_s(scene)
    inside = sorted(t for p in scene.effects.thrust for t in p.times_s if 0.0 < t < scene.run.duration_s)
    return next((t for t in inside if abs(t / half - round(t / half)) > WHOLE), None)
