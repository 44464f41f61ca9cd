"""Accelerations and multipliers at t = 0, where Exudyn's own would be wrong.

Exudyn computes initial accelerations with zero for the second time derivative of a prescribed offset. That is correct
for a law relative to inertial axes. It fails where the offset follows the motion (the bar's longitude, a motor's
neighbour), and the trapezoidal rule propagates the error undamped. One step of implicit Euler (Newmark with gamma = 1)
does not depend on the initial accelerations: it gives their mean over the step. Two such steps, h and 2h, extrapolate
to t = 0 with an error O(h²), the method's own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.engine import EngineError
from adapters.exudyn.library import exu
from adapters.exudyn.solve.solver import Method, settings_of, solver_of
from adapters.exudyn.timetable import Steps
from scenarios import Actuator, Frame

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.exudyn.models.model import Model
    from adapters.trajectory import Array
    from scenarios import Scene

FRACTION = 0.25  # relative to the run's step: short, yet long enough for Newton's tolerance over the step to be small


@dataclass(frozen=True)
class StartForces:
    """Initial accelerations and multipliers of a run."""

    accelerations: Array
    """all coordinates, in Exudyn's order"""
    multipliers: Array


def offset_follows_motion(scene: Scene) -> bool:
    """Whether a prescribed offset depends on more than time."""
    laws = scene.effects.prescribed_rotation
    return any(p.actuator is Actuator.JOINT or p.frame is Frame.LOCAL_HORIZONTAL for p in laws)


def start_forces(make: Callable[[Steps], Model], steps: Steps, method: Method) -> StartForces:
    """Extrapolate from two implicit Euler steps to t = 0."""
    h = FRACTION * steps.size_s
    near, far = (euler_step(make, Steps(size, 1), method) for size in (h, 2.0 * h))
    return StartForces(2.0 * near.accelerations - far.accelerations, 2.0 * near.multipliers - far.multipliers)


def euler_step(make: Callable[[Steps], Model], step: Steps, method: Method) -> StartForces:
    """Mean accelerations over one step, and the multipliers at its end.

    Raises
    ------
    EngineError
        If Newton's method fails.
    """
    model = make(step)
    try:
        settings = settings_of(step, 2, method)
        alpha = settings.timeIntegration.generalizedAlpha
        alpha.useNewmark = alpha.useIndex2Constraints = True
        alpha.newmarkGamma, alpha.newmarkBeta = 1.0, 0.5
        if not solver_of(method).SolveSystem(model.mbs, settings):
            raise EngineError("Exudyn: Newton's method failed for the accelerations at t = 0")
        data = model.mbs.systemData
        return StartForces(np.array(data.GetODE2Coordinates_tt()), np.array(data.GetAECoordinates()))
    finally:
        model.close()


def set_start_forces(model: Model, settings: Any, start: StartForces) -> None:
    """Start a run with `start` instead of Exudyn's own initial accelerations."""
    initial = exu().ConfigurationType.Initial
    model.mbs.systemData.SetODE2Coordinates_tt(start.accelerations.tolist(), initial)
    model.mbs.systemData.SetAECoordinates(start.multipliers.tolist(), initial)
    settings.timeIntegration.generalizedAlpha.computeInitialAccelerations = False
