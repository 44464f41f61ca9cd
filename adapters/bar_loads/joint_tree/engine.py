"""Common part of the engines whose library gives a tree's accelerations and leaves the frame and the events to us."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from adapters.bar_loads.assemble import SUPPORTED
from adapters.bar_loads.joint_tree.jumps import HeldFaces, Jumps
from adapters.common.accuracy_scales import accuracy_scales
from adapters.common.initial_state import initial_state
from adapters.common.joint_coordinates import from_joint_coordinates, to_joint_coordinates
from adapters.common.landing import landing_text
from adapters.common.scipy_solver import RTOL_FLOOR, ScipySolver
from adapters.common.solver_driver import Problem, drive
from adapters.engine import AccuracyParameter, AccuracySweep, Coordinates, Engine, EngineError, Setting
from adapters.trajectory import Observable, Trajectory

if TYPE_CHECKING:
    from adapters.bar_loads.joint_tree.chain import JointTree
    from adapters.common.solver_driver import Solver
    from adapters.trajectory import Array
    from scenarios import Scene

NO_SHADOW = (
    "solar_pressure.shadow is not supported: the solver restarts at instants known beforehand, "
    "and the shadow's edges depend on the motion"
)


def reasons(no_prescribed_rotation: str) -> dict[str, str]:
    """Reasons for the unsupported effects; the library's own reason against prescribed rotations."""
    kinds = ("inertial", "local_horizontal", "external", "joint")
    rotations = {f"prescribed_rotation.{kind}": no_prescribed_rotation for kind in kinds}
    return rotations | {"solar_pressure.shadow": NO_SHADOW}


class JointTreeEngine(Engine):
    """Joint coordinates in a freely falling frame, with error control."""

    coordinates = Coordinates.JOINT
    order = None
    sweep = AccuracySweep(
        AccuracyParameter.RTOL, (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13), default=1e-10
    )
    effects = SUPPORTED
    observables: ClassVar[frozenset[Observable]] = frozenset(
        {Observable.COM, Observable.ATTITUDE, Observable.RATE, Observable.REACTION, Observable.IMPULSE}
    )

    @abstractmethod
    def tree(self, scene: Scene) -> JointTree:
        """The library's model of the chain."""

    def solver(self, rtol: float, units: Array) -> Solver:
        """SciPy's DOP853; `units` has the unit of each component of the state."""
        return ScipySolver("DOP853", RTOL_FLOOR, rtol * units)

    def build(self, scene: Scene, setting: Setting) -> None:
        """Make the model and the initial value problem."""
        start, self.times_s = initial_state(scene), scene.times_s
        self.mass_kg = np.array(scene.chain.mass_kg)
        self.chain = self.tree(scene)
        q, q_t = to_joint_coordinates(self.chain.length_m, start)
        self.jumps, self.breaks_s = Jumps(scene, self.chain), scene.effects.breaks_s
        self.struck = bool(scene.effects.impulse)
        y0 = self.jumps.begin(np.concatenate([start.com_m, start.com_velocity_m_s, q, q_t]))
        unit = accuracy_scales(scene)
        self.problem = Problem(self.chain.rate, y0, self.chain.height)
        self.integrator = self.solver(setting.value, np.concatenate([unit.track, unit.joint_coordinates(scene.bars)]))
        if self.integrator.locates_events and self.chain.incidences(0.0, y0):
            self.jumps.faces = self.problem.mode_events = HeldFaces(self.chain)

    def simulate(self) -> None:
        """Integrate."""
        try:
            self.walk = drive(self.integrator, self.problem, self.times_s, self.breaks_s, self.jumps).walk
        except ArithmeticError as error:
            raise EngineError(str(error)) from error

    def read(self) -> Trajectory:
        """Observables at the samples."""
        if self.jumps.faces:
            self.jumps.faces.release()
        y, width = self.walk.y, self.chain.width
        bars = from_joint_coordinates(self.chain.length_m, y[:, 4 : 4 + width], y[:, 4 + width :])
        return Trajectory(
            self.walk.t_s,
            *bars.track(self.mass_kg, y[:, :2], y[:, 2:4]),
            bars.angle_rad,
            bars.rate_rad_s,
            np.array([self.reaction_N(t, row) for t, row in zip(self.walk.t_s, y, strict=True)]),
            impulse_N_s=self.jumps.impulses(self.walk.t_s) if self.struck else None,
            ended=landing_text(self.walk.stopped_s),
            info={"steps": self.walk.steps, "evaluations": self.walk.evaluations},
        )

    def reaction_N(self, t_s: float, state: Array) -> Array:
        """Force on each bar from the next, (N-1, 2), at a sample; just before an event."""
        self.chain.inside_s = self.jumps.before(t_s)
        return self.chain.reactions(state, t_s)
