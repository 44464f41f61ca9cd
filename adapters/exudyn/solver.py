"""Exudyn's solvers: settings without output and files, tolerances in the scene's own units, segments, starts."""

from __future__ import annotations

import functools
import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.common.departure import departure
from adapters.common.equal_steps import steps_between_samples
from adapters.engine import EngineError
from adapters.exudyn.effects import jump_steps
from adapters.exudyn.library import exu
from adapters.exudyn.time_inputs import Steps
from scenarios import Actuator, Frame

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.exudyn.model import Model
    from adapters.trajectory import Array
    from scenarios import Scene

SAMPLE_SLACK = 1e-7  # relative to a sample interval: Exudyn's summed time falls short of a sample by round-off
# Relative to the smallest bar's inertia forces. On paper/fig05 1e-6 changes the angles, 1e-8 their last digits, 1e-10
# and less nothing (index 2 in the moving frame; index 3 needs 1e-10 at 10000 steps per orbit).
RESIDUAL_FRACTION = 1e-10
# Relative to the largest force or velocity: 45 units in the last place. On paper/fig05 in absolute coordinates Newton's
# method reaches 1.3e-15 of the velocity and fails at 1.7e-16.
FLOOR = 1e-14
POSITION_FLOOR = 1e-15  # of a position, for joints held at position level
DIFFERENCE_FRACTION = 1e-2  # of a bar: least coordinate by which Exudyn's numerical derivatives step
LARGEST_DIFFERENCE = 100.0  # in absolute coordinates; larger ones turn angles so far that it shows in multipliers
ITERATIONS = 200  # joint motors converge linearly
START_FRACTION = 0.5  # of the run's step: short, yet long enough for Newton's tolerance over it to be small


def steps_of(scene: Scene, steps_per_orbit: float) -> Steps:
    """Steps of a run: at least the requested number, an integer number of them between samples."""
    count = steps_between_samples(scene, steps_per_orbit) * (scene.run.samples - 1)
    return Steps(scene.run.duration_s / count, count)


@dataclass(frozen=True)
class Method:
    """Integrator and tolerances of Newton's method."""

    explicit: bool = False
    index3: bool = False
    spectral_radius: float = 0.9
    """for index 3: with 1 the multipliers oscillate undamped"""
    residual_N: float = 1e-12
    difference_m: float = 1.0
    absolute: bool = False
    position_m: float = 0.0
    """largest coordinate of a place"""


def settings_of(steps: Steps, samples: int, method: Method) -> Any:
    """SimulationSettings for a run."""
    settings = exu().SimulationSettings()
    end_s = steps.size_s * steps.count
    time = settings.timeIntegration
    time.endTime, time.numberOfSteps = end_s, steps.count
    time.verboseMode = time.verboseModeFile = 0
    time.adaptiveStep = False
    time.stepInformation = 0
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = end_s / (samples - 1) * (1.0 - SAMPLE_SLACK)
    if method.explicit:
        time.solverType = exu().DynamicSolverType.RK67
        time.explicit.computeEndOfStepAccelerations = True
        return settings
    time.newton.relativeTolerance = 0.0
    time.newton.absoluteTolerance = method.residual_N
    time.newton.useModifiedNewton = True
    time.newton.maxIterations = time.newton.maxModifiedNewtonIterations = ITERATIONS
    time.newton.numericalDifferentiation.minimumCoordinateSize = method.difference_m
    alpha = time.generalizedAlpha
    alpha.computeInitialAccelerations = True
    alpha.useNewmark = alpha.useIndex2Constraints = not method.index3
    alpha.spectralRadius = method.spectral_radius
    return settings


def solver_of(method: Method) -> Any:
    """Solver object; a direct call avoids the banner of mbs.SolveDynamic on failure."""
    return exu().MainSolverExplicit() if method.explicit else exu().MainSolverImplicitSecondOrder()


@dataclass(frozen=True)
class Scales:
    """Scales of Newton's residual, a sum of forces, velocities and (index 3) positions."""

    least_force_N: float
    """smallest inertia force of a bar"""
    force_N: float
    """largest force in the residual"""
    velocity_m_s: float
    position_m: float
    torque_per_gap_N: float = 1.0
    """Weight of a gap of 1 m in the residual: at least 1, or the reactions' torque on a bar whose rotation closes
    the gap"""


def scales_of(scene: Scene, *, absolute: bool) -> Scales:
    """Scales of a scene in a moving frame or in absolute coordinates."""
    chain = scene.chain
    rate = max(scene.orbital_rate_rad_s, scene.mean_motion_rad_s)
    rate *= max(1.0, *map(abs, chain.rate_factor))
    least = min(m * length for m, length in zip(chain.mass_kg, chain.length_m, strict=True)) * rate**2
    turns = [turn for law in scene.effects.prescribed_rotation for turn in law.turns]
    slews = [turn.reach_rad * (math.pi / turn.duration_s) ** 2 for turn in turns]
    force = max(chain.mass_kg) * scene.size_m * (rate**2 + max(slews, default=0.0))
    force = max(force, joint_torque_N_m(scene))
    if not absolute:
        away = departure(scene)
        force += away.force_N(scene)
        place = scene.size_m + away.distance_m
        if scene.effects.prescribed_rotation:  # their residuals are angles
            place = max(place, largest_angle_rad(scene))
        return Scales(least, force, scene.size_m * rate + away.speed_m_s, place)
    gravity = scene.central_body.mu_m3_s2 / scene.radius0_m**2 * max(chain.mass_kg)
    speed = max(scene.speed0_m_s, scene.size_m * rate)
    return Scales(least, max(force, gravity), speed, scene.radius0_m, max(1.0, force))


def joint_torque_N_m(scene: Scene) -> float:
    """Largest torque of a joint's spring at the start, or of its motor: Newton's method can't go below its rounding."""
    springs, bent = scene.effects.joint_spring_damper, np.diff(scene.chain.angle_rad)
    torques = [max(map(abs, motor.torque_N_m)) for motor in scene.effects.joint_torque]
    if springs is not None:
        torques += [
            k * abs(b - rest) for k, b, rest in zip(springs.stiffness_N_m_rad, bent, springs.rest_rad, strict=True)
        ]
    return float(max(torques, default=0.0))


def largest_angle_rad(scene: Scene) -> float:
    """Largest angle of a prescribed bar, its neighbour or the frame, as far as the start tells, rad."""
    turned = scene.fastest_rate_rad_s * scene.run.duration_s
    return max(map(abs, scene.chain.angle_rad)) + abs(scene.orbit.longitude_rad) + turned


def residual_N(scales: Scales, bars: int, *, index3: bool) -> float:
    """Newton's absolute tolerance: a small fraction of the smallest bar's forces, but never below round-off."""
    floor = FLOOR * math.sqrt(bars) * max(scales.force_N, scales.velocity_m_s)
    if index3:
        floor = max(floor, POSITION_FLOOR * math.sqrt(bars) * scales.position_m * scales.torque_per_gap_N)
    return max(RESIDUAL_FRACTION * scales.least_force_N, floor)


def method_for(scene: Scene, *, explicit: bool, index3: bool, absolute: bool) -> Method:
    """Integrator and tolerances for a scene."""
    bar, scales = min(scene.chain.length_m), scales_of(scene, absolute=absolute)
    return Method(
        explicit=explicit,
        index3=index3,
        residual_N=residual_N(scales, scene.bars, index3=index3),
        difference_m=min(bar, LARGEST_DIFFERENCE) if absolute else DIFFERENCE_FRACTION * bar,
        absolute=absolute,
        position_m=scales.position_m,
    )


@dataclass(frozen=True)
class RestartSegments:
    """Segments of a run's steps, from one jump of the loads to the next.

    The trapezoidal rule and generalized-alpha use the accelerations at one step's end in the next step. Where a thrust
    starts or ends these differ. The run therefore ends there, and restarts from its state with accelerations of the new
    loads. An explicit method has no such memory, and needs no segments.
    """

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
    if model.timetable:
        model.timetable.resume(step)


@dataclass(frozen=True)
class StartForces:
    """Accelerations and multipliers at t = 0, where Exudyn's own would be wrong.

    Exudyn computes initial accelerations with zero for the second time derivative of a prescribed offset. That is
    correct for a law relative to inertial axes. It fails where the offset follows the motion (the bar's longitude, a
    motor's neighbour), and the trapezoidal rule propagates the error undamped. One step of implicit Euler (Newmark with
    gamma = 1) does not depend on the initial accelerations: it gives their mean over the step. Three such steps,
    h, 2h and 3h, extrapolate to t = 0 with an error O(h³). Two would leave the method's own order, with a factor
    that the law's own torque does not bound.
    """

    accelerations: Array
    """all coordinates, in Exudyn's order"""
    multipliers: Array


def offset_follows_motion(scene: Scene) -> bool:
    """Whether a prescribed offset depends on more than time."""
    laws = scene.effects.prescribed_rotation
    return any(p.actuator is Actuator.JOINT or p.frame is Frame.LOCAL_HORIZONTAL for p in laws)


def start_forces(make: Callable[[Steps], Model], steps: Steps, method: Method) -> StartForces:
    """Extrapolate from three implicit Euler steps of one, two and three parts to t = 0; the error is of third order."""
    h = START_FRACTION * steps.size_s
    one, two, three = (euler_step(make, Steps(k * h, 1), method) for k in (1, 2, 3))
    return StartForces(
        3.0 * (one.accelerations - two.accelerations) + three.accelerations,
        3.0 * (one.multipliers - two.multipliers) + three.multipliers,
    )


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
