"""The NumPy reference behind the engines' contract."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, final

from adapters.engine import Coordinates, Engine, EngineError, Knob, Ladder, Observable, Setting, Trajectory
from adapters.initial_state import chain_model, initial_state
from reference_impl.simulate import CoordinateSet, Simulation

if TYPE_CHECKING:
    from scenarios import Scene

EVERYTHING = frozenset(
    {"gravity.none", "gravity.point", "gravity.gradient"}
    | {f"prescribed_rotation.{what}" for what in ("inertial", "local_horizontal", "external", "joint")}
)


class ReferenceEngine(Engine):
    """What both coordinate sets of the reference share."""

    order = None
    ladder = Ladder(Knob.RTOL, (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13), default=1e-10)
    effects = EVERYTHING
    observables = frozenset(Observable)
    options = frozenset({"condition"})
    coordinate_set: ClassVar[CoordinateSet]

    def __init__(self, *, condition: bool = False) -> None:
        """Prepare a run; `condition` asks for the joint system's condition number at every sample."""
        self.condition = condition

    def build(self, scene: Scene, setting: Setting) -> None:
        """Set up the integrator."""
        start = initial_state(scene)
        self.times_s = scene.times_s
        self.simulation = Simulation(
            chain_model(scene),
            start.com_m,
            start.com_velocity_m_s,
            start.angle_rad,
            start.rate_rad_s,
            rtol=setting.value,
            coordinates=self.coordinate_set,
        )

    def simulate(self) -> None:
        """Integrate."""
        try:
            self.seen = self.simulation.walk(self.times_s)
        except ArithmeticError as error:
            raise EngineError(str(error)) from error

    def read(self) -> Trajectory:
        """Observables at the samples."""
        h = self.simulation.history(self.seen, condition=self.condition)
        landed = "" if h.landed_s is None else f"a bar reached the surface at t = {h.landed_s:.6f} s"
        return Trajectory(
            h.t_s,
            h.com_m,
            h.com_velocity_m_s,
            h.angle_rad,
            h.rate_rad_s,
            h.reaction_N,
            h.gap_m,
            h.identity_m,
            h.torque_N_m,
            h.condition,
            ended=landed,
            info={"steps": h.steps, "evaluations": h.evaluations},
        )


@final
class Reference(ReferenceEngine):
    """Relative formulation, minimal coordinates."""

    title = "NumPy reference, relative formulation, DOP853"
    coordinates = Coordinates.RELATIVE
    coordinate_set = "minimal"


@final
class ReferenceAbsolute(ReferenceEngine):
    """Absolute inertial coordinates."""

    title = "NumPy reference in absolute inertial coordinates, DOP853"
    coordinates = Coordinates.ABSOLUTE
    coordinate_set = "absolute"
