"""Exudyn adapter: five models of the same chain."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any, ClassVar, final

import numpy as np

from adapters.common.step_alignment import NO_SHADOW
from adapters.engine import AccuracyParameter, AccuracySweep, Coordinates, EngineError, Setting
from adapters.exudyn.base_engine import OBSERVED, ExudynEngine
from adapters.exudyn.loads.thrust import jumps_s
from adapters.exudyn.models.bodies import RedundantModel
from adapters.exudyn.models.tree import FrozenOrbitTreeModel, TreeModel, tree_readings
from adapters.exudyn.noise import engine_noise, tree_noise
from adapters.exudyn.readout import SensorReadings
from adapters.exudyn.solve.solver import method_for, settings_of, solver_of, steps_of
from adapters.exudyn.solve.start import StartForces, offset_follows_motion, set_start_forces, start_forces
from adapters.trajectory import Observable

if TYPE_CHECKING:
    from adapters.exudyn.models.model import Model
    from adapters.exudyn.timetable import Steps
    from adapters.trajectory import Array
    from scenarios import Scene

GRAVITY = frozenset(f"gravity.{name}" for name in ("none", "point", "gradient", "quadrupole", "slender"))
FIELDS = frozenset({"oblateness", "third_body"})
PUSHES = frozenset({"drag", "solar_pressure", "joint_spring_damper", "thrust.body", "thrust.inertial"})
SUPPORTED = GRAVITY | FIELDS | PUSHES
PRESCRIBED = frozenset(f"prescribed_rotation.{w}" for w in ("inertial", "local_horizontal", "external", "joint"))
UNSUPPORTED = {
    "solar_pressure.shadow": NO_SHADOW,
    "impulse": "impulse is not supported: Exudyn has no jump of velocities under closed joints",
}
RESTARTED = (
    "thrust with a prescribed rotation is not supported: the run restarts where the thrust starts or ends, "
    "and Exudyn computes wrong accelerations there"
)
BRIEF = 1e-12  # duration over a step: a run so short that the state does not change in its last digit


class ExudynRedundant(ExudynEngine):
    """Rigid bodies and joints in redundant coordinates."""

    effects = SUPPORTED | PRESCRIBED
    unsupported_reasons = UNSUPPORTED
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
    """Multipliers at index 3 in absolute coordinates."""

    title = "Exudyn, redundant absolute inertial coordinates, generalized-alpha index 3"
    coordinates = Coordinates.ABSOLUTE
    sweep = AccuracySweep(AccuracyParameter.STEPS_PER_ORBIT, (1000, 5000, 10000, 50000, 100000), default=5000)
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
        sorted(PRESCRIBED),
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
