"""Exudyn adapter: five models of the same chain, run without output, and checks that Exudyn does not make."""

from __future__ import annotations

import dataclasses
from abc import abstractmethod
from typing import TYPE_CHECKING, Any, ClassVar, final

import numpy as np

from adapters.common import face_reversal
from adapters.common.step_alignment import NO_SHADOW, straddled_words
from adapters.engine import (
    GRAVITY_MODELS,
    PRESCRIBED_ROTATIONS,
    AccuracyParameter,
    AccuracySweep,
    Coordinates,
    Engine,
    EngineError,
    Setting,
    UnsupportedMotionError,
)
from adapters.exudyn.effects import jumps_s, off_step_s
from adapters.exudyn.model import FrozenOrbitTreeModel, RedundantModel, TreeModel, tree_readings
from adapters.exudyn.noise import engine_noise, tree_noise
from adapters.exudyn.readout import SensorReadings, gaps, landing, positions, trajectory
from adapters.exudyn.solver import (
    StartForces,
    method_for,
    offset_follows_motion,
    run_segments,
    segments_of,
    set_start_forces,
    settings_of,
    solver_of,
    start_forces,
    steps_of,
)
from adapters.trajectory import Observable, Trajectory
from scenarios.effect_types import COM_SHARE

if TYPE_CHECKING:
    from adapters.exudyn.model import Model
    from adapters.exudyn.time_inputs import Steps
    from adapters.trajectory import Array
    from scenarios import Scene

OBSERVED = frozenset({Observable.COM, Observable.ATTITUDE, Observable.RATE, Observable.REACTION})
START_TOLERANCE = 1e-12  # rad, and relative to the largest coordinate, between the first sample and the initial state
SUPPORTED = frozenset({
    *GRAVITY_MODELS, "oblateness", "third_body", "drag", "solar_pressure", "joint_spring_damper", "joint_torque",
    "thrust.body", "thrust.inertial", COM_SHARE,
})  # fmt: skip
UNSUPPORTED = {
    "solar_pressure.shadow": NO_SHADOW,
    "impulse": "impulse is not supported: Exudyn has no jump of velocities under closed joints",
}
JOINT_MOTOR = "prescribed_rotation.joint"
JOINT_ANGLE = "prescribed_rotation.previous_bar"
AT_ITS_TOLERANCE = (
    "a prescribed rotation by a joint's motor is not supported: Newton's method ends at its tolerance, the round-off "
    "of absolute positions, which over a step squared is a force"
)
RESTARTED = (
    "a thrust or a joint's torque with a prescribed rotation is not supported: the run restarts where it jumps, "
    "and Exudyn computes wrong accelerations there"
)
BRIEF = 1e-12  # duration over a step: a run so short that the state does not change in its last digit


class ExudynEngine(Engine):
    """Common part: settings, run, and checks that Exudyn does not make."""

    observables = OBSERVED
    options = frozenset({"repeated_load"})
    absolute: ClassVar[bool] = False
    index3: ClassVar[bool] = False
    explicit: ClassVar[bool] = False

    def __init__(self, *, repeated_load: bool = False) -> None:
        """Prepare a run; `repeated_load` applies each load twice at half strength, to time the loads."""
        self.load_copies = 2 if repeated_load else 1

    @classmethod
    def unsupported(cls, scene: Scene) -> str | None:
        """Reason why the engine does not support `scene`: corners of a table in time inside a step included."""
        off = off_step_s(scene)
        return super().unsupported(scene) or (None if off is None else straddled_words(scene, off))

    @classmethod
    def unsupported_motion(cls, scene: Scene, motion: Trajectory) -> str | None:
        """Reason why equal steps do not support a motion: a bar turns its other face to the wind or the Sun."""
        return face_reversal.unsupported_motion(scene, motion)

    def build(self, scene: Scene, setting: Setting) -> None:
        """Assemble the model and the solver."""
        self.scene = scene
        self.steps = steps_of(scene, setting.value)
        self.method = method_for(scene, explicit=self.explicit, index3=self.index3, absolute=self.absolute)
        self.model = self.make(self.steps)
        self.settings = settings_of(self.steps, scene.run.samples, self.method)
        self.solver = solver_of(self.method)
        self.segments = segments_of(scene, self.steps, self.method)

    @abstractmethod
    def make(self, steps: Steps) -> Model:
        """Model of the scene."""

    def simulate(self) -> None:
        """Run the solver; :meth:`read` checks whether it reached the end."""
        try:
            self.finished = self._solve()
        except Exception as error:
            raise EngineError(f"Exudyn: {str(error).strip().splitlines()[0]}") from error

    def _solve(self) -> bool:
        if len(self.segments.boundaries) > 2:
            return run_segments(self.model, self.segments, self.settings, self.method)
        return bool(self.solver.SolveSystem(self.model.mbs, self.settings))

    def read(self) -> Trajectory:
        """Return the samples above the surface, in inertial axes."""
        try:
            return self._read()
        finally:
            self.model.close()

    @abstractmethod
    def readings(self) -> tuple[SensorReadings, dict[str, float | str]]:
        """Sensor readings, and further entries of `info`."""

    def _read(self) -> Trajectory:
        readings, info = self.readings()
        stored = len(readings.angle_rad)
        axes = self.model.frame.at(self.scene.times_s[:stored])
        landed = landing(self.scene, axes, readings)
        self._check(readings, stored if landed is None else landed, whole=landed is None)
        ended = ""
        if landed is not None:
            ended = f"a bar was below the surface at t = {self.scene.times_s[landed]:.6g} s, the next sample"
            readings, axes = readings.first(landed), self.model.frame.at(self.scene.times_s[:landed])
        found = trajectory(self.scene, axes, readings, ended=ended, info=info | {"steps": self.steps.count})
        turns = face_reversal.first_reversal(self.scene, found)
        if turns:
            raise UnsupportedMotionError(f"Exudyn: {turns}")
        loose = Observable.GAP in self.observables  # the bars' positions are coordinates, so that joints may have gaps
        return found.replace(
            gap_m=gaps(self.scene, readings) if loose else None,
            position_m=positions(self.scene, axes, readings) if loose else None,
            torque_N_m=readings.torque_N_m if Observable.TORQUE in self.observables else None,
        )

    def _check(self, readings: SensorReadings, used: int, *, whole: bool) -> None:
        """Reject results that Exudyn reports without an error."""
        t = self.scene.times_s
        good = readings.finite[:used]
        if not good.all():
            raise EngineError(f"Exudyn: the state is not finite at t = {t[int(np.argmin(good))]:.6g} s")
        if whole and (not self.finished or used != self.scene.run.samples):
            raise EngineError(f"Exudyn: the solver stopped after t = {t[used - 1]:.6g} s of {t[-1]:.6g} s")
        start = self.model.start
        off = np.abs(readings.position_m[0] - start.position_m).max() / (
            np.abs(start.position_m).max() + self.scene.size_m
        )
        if max(off, np.abs(readings.angle_rad[0] - start.angle_rad).max()) > START_TOLERANCE:
            raise EngineError("Exudyn: the first sample is not the initial state")


class ExudynRedundant(ExudynEngine):
    """Rigid bodies and joints in redundant coordinates."""

    effects = SUPPORTED | set(PRESCRIBED_ROTATIONS) - {JOINT_ANGLE}
    unsupported_reasons: ClassVar[dict[str, str]] = UNSUPPORTED | {
        JOINT_ANGLE: "the law of a joint's angle is not supported: the adapter's constraints hold a bar's angle"
    }
    observables = OBSERVED | {Observable.GAP, Observable.TORQUE}
    order = 2.0
    model: RedundantModel

    @classmethod
    def unsupported(cls, scene: Scene) -> str | None:
        """Reason why the engine does not support `scene`: restarts lose accelerations of prescribed bars."""
        divided = scene.effects.prescribed_rotation and jumps_s(scene)
        return super().unsupported(scene) or (RESTARTED if divided else None)

    @classmethod
    def noise(cls, scene: Scene, setting: Setting, t_s: Array) -> dict[str, float | Array]:
        """See :func:`adapters.exudyn.noise.engine_noise`."""
        method = method_for(scene, explicit=False, index3=cls.index3, absolute=cls.absolute)
        return engine_noise(scene, steps_of(scene, setting.value).size_s, method, t_s)

    def build(self, scene: Scene, setting: Setting) -> None:
        """Assemble, with accelerations at t = 0 where Exudyn's would be wrong."""
        super().build(scene, setting)
        self.start_forces: StartForces | None = None
        if offset_follows_motion(scene):
            self.start_forces = start_forces(self.make, self.steps, self.method)
            set_start_forces(self.model, self.settings, self.start_forces)

    def make(self, steps: Steps) -> RedundantModel:
        """Bodies with joints."""
        return RedundantModel(self.scene, steps, absolute=self.absolute, load_copies=self.load_copies)

    def readings(self) -> tuple[SensorReadings, dict[str, float | str]]:
        """Bodies' coordinates and joints' multipliers; the multiplier of a prescribed rotation is minus its torque."""
        m = self.model
        q, v = stacked(m, m.coordinates), stacked(m, m.rates)
        n, bars = q.shape[:2]
        reaction = stacked(m, m.reactions)[..., :2] if m.reactions else np.empty((n, bars - 1, 2))
        torque = -stacked(m, m.torques)[..., 0] if m.torques else np.empty((n, 0))
        if self.start_forces is not None:  # sensors store zeros at t = 0 where the multipliers are given
            joints, prescribed = np.split(self.start_forces.multipliers, [2 * (bars - 1)])
            reaction[0], torque[0] = joints.reshape(-1, 2), -prescribed
        return SensorReadings(q[..., :2], v[..., :2], q[..., 2], v[..., 2], reaction, torque), {}


def stacked(model: Model, sensors: list[Any]) -> Array:
    """Histories of several sensors without their times, (n, sensors, width)."""
    return np.stack([model.history(s)[:, 1:] for s in sensors], axis=1)


@final
class Exudyn(ExudynRedundant):
    """Multipliers at index 2 in the moving frame."""

    title = "Exudyn, redundant coordinates in a frame on the Kepler orbit, trapezoidal index 2"
    coordinates = Coordinates.ROTATING_FRAME
    sweep = AccuracySweep(AccuracyParameter.STEPS_PER_ORBIT, (100, 500, 1000, 5000, 10000, 50000, 100000), default=5000)


@final
class ExudynIndex3(ExudynRedundant):
    """Multipliers at index 3 in the moving frame."""

    title = "Exudyn, redundant coordinates in a frame on the Kepler orbit, generalized-alpha index 3"
    coordinates = Coordinates.ROTATING_FRAME
    sweep = AccuracySweep(AccuracyParameter.STEPS_PER_ORBIT, (100, 500, 1000, 5000, 10000, 50000, 100000), default=5000)
    index3 = True
    joints_in_place = True


@final
class ExudynAbsolute(ExudynRedundant):
    """Multipliers at index 2 in absolute coordinates."""

    title = "Exudyn, redundant absolute inertial coordinates, trapezoidal index 2"
    coordinates = Coordinates.ABSOLUTE
    sweep = AccuracySweep(AccuracyParameter.STEPS_PER_ORBIT, (1000, 5000, 10000, 50000, 100000), default=5000)
    absolute = True


@final
class ExudynAbsoluteIndex3(ExudynRedundant):
    """Multipliers at index 3 in absolute coordinates.

    A joint's motor follows the other bar's angle, which Newton's Jacobian does not know. Its method then ends at its
    tolerance and not far below: an angle is wrong by the residual, and the ends of its bar move by half a length times
    that. Over a step squared this was 1.5 to 44 % of the reactions of three scenes at 31 250 steps per orbit.
    """

    title = "Exudyn, redundant absolute inertial coordinates, generalized-alpha index 3"
    coordinates = Coordinates.ABSOLUTE
    sweep = AccuracySweep(AccuracyParameter.STEPS_PER_ORBIT, (1000, 5000, 10000, 50000, 100000), default=5000)
    effects = ExudynRedundant.effects - {JOINT_MOTOR}
    unsupported_reasons: ClassVar[dict[str, str]] = UNSUPPORTED | {JOINT_MOTOR: AT_ITS_TOLERANCE}
    absolute = True
    index3 = True
    joints_in_place = True


@final
class ExudynTree(ExudynEngine):
    """Kinematic tree with an explicit method, in the moving frame."""

    title = "Exudyn, kinematic tree in a frame on the Kepler orbit, RK67"
    coordinates = Coordinates.JOINT
    order = 6.0
    sweep = AccuracySweep(AccuracyParameter.STEPS_PER_ORBIT, (20, 50, 100, 150, 200, 400, 800, 1600), default=400)
    effects = SUPPORTED
    explicit = True
    model: TreeModel
    unsupported_reasons: ClassVar[dict[str, str]] = UNSUPPORTED | dict.fromkeys(
        PRESCRIBED_ROTATIONS,
        "prescribed rotation is not supported: Exudyn's explicit solvers accept no constraint on a kinematic tree",
    )

    @classmethod
    def noise(cls, scene: Scene, setting: Setting, t_s: Array) -> dict[str, float | Array]:
        """See :func:`adapters.exudyn.noise.tree_noise`."""
        del setting, t_s
        return {"reaction": tree_noise(scene)}

    def make(self, steps: Steps) -> TreeModel:
        """Kinematic tree."""
        return TreeModel(self.scene, steps, absolute=False, load_copies=self.load_copies)

    def readings(self) -> tuple[SensorReadings, dict[str, float | str]]:
        """Bars' states from tree coordinates, reactions from the bars' momentum."""
        q, q_t, q_tt = (self.model.history(s)[:, 1:] for s in self.model.sensors)
        q_tt[0] = self._first_accelerations()
        readings, left_over = tree_readings(self.model, q, q_t, q_tt)
        return readings, {"free_end_N": float(left_over.max())}

    def _first_accelerations(self) -> Array:
        """Accelerations at t = 0, where an explicit run stores zeros, from a very short run of the model."""
        brief = dataclasses.replace(self.steps, size_s=BRIEF * self.steps.size_s, count=1)
        model = FrozenOrbitTreeModel(self.scene, brief, absolute=False)
        try:
            if not solver_of(self.method).SolveSystem(model.mbs, settings_of(brief, 2, self.method)):
                raise EngineError("Exudyn: the solver failed to compute the accelerations at t = 0")
            return model.history(model.sensors[2])[-1, 1:]
        finally:
            model.close()
