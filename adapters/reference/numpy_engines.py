"""Engines of the NumPy reference."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar, Protocol, final

import numpy as np

from adapters.common.initial_state import initial_state
from adapters.common.landing import landing_text
from adapters.common.reference_model import chain_model
from adapters.engine import (
    GRAVITY_MODELS,
    PRESCRIBED_ROTATIONS,
    AccuracyParameter,
    AccuracySweep,
    Coordinates,
    Engine,
    EngineError,
    Setting,
)
from adapters.trajectory import ENDED, Observable, Trajectory
from reference_impl.integrate.roundings import ROUNDINGS
from scenarios.effect_types import COM_SHARE

if TYPE_CHECKING:
    from adapters.common.initial_state import InitialState
    from reference_impl.integrate.coordinate_sets import CoordinateSet
    from reference_impl.integrate.simulate import History
    from reference_impl.integrate.stepper import Integration
    from reference_impl.model.arrays import Array
    from reference_impl.model.chain import ChainModel
    from scenarios import Scene

EVERYTHING = frozenset({
    *GRAVITY_MODELS, *PRESCRIBED_ROTATIONS, "oblateness", "third_body", "drag", "solar_pressure",
    "solar_pressure.shadow", "joint_spring_damper", "joint_torque", "thrust.body", "thrust.inertial", "impulse",
    COM_SHARE,
})  # fmt: skip
FEW_STEPS = 10.0  # largest component over the norm of step control, and interpolation between steps


class SimulationRun(Protocol):
    """One simulation, in NumPy or compiled."""

    most_events: float
    """State events after which the run gives up"""

    def integrate(self, t_s: Array) -> Integration:
        """Integrate over the samples."""

    def history(self, result: Integration, *, condition: bool = False) -> History:
        """Observables at the samples."""


class ReferenceEngine(Engine):
    """Common part of all forms of the reference."""

    order = None
    sweep = AccuracySweep(
        AccuracyParameter.RTOL, (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14), default=1e-10
    )
    effects = EVERYTHING
    observables = frozenset(Observable)
    options = frozenset({"condition"})

    def __init__(self, *, condition: bool = False) -> None:
        """Prepare a run; `condition` requests the joint system's condition number at every sample."""
        self.condition = condition

    @abstractmethod
    def prepare(self, model: ChainModel, start: InitialState, rtol: float) -> SimulationRun:
        """Set up the integrator."""

    def build(self, scene: Scene, setting: Setting) -> None:
        """Set up the integrator."""
        self.times_s = scene.times_s
        self.prepared = self.prepare(chain_model(scene), initial_state(scene), setting.value)

    def simulate(self) -> None:
        """Integrate."""
        try:
            self.seen = self.prepared.integrate(self.times_s)
        except (ArithmeticError, np.linalg.LinAlgError) as error:
            raise EngineError(str(error)) from error

    def read(self) -> Trajectory:
        """Observables at the samples."""
        try:
            h = self.prepared.history(self.seen, condition=self.condition)
        except np.linalg.LinAlgError as error:  # the refinement of reactions at samples may not converge
            raise EngineError(str(error)) from error
        info: dict[str, float | str] = {"steps": h.steps, "evaluations": h.evaluations, "method": h.method}
        if h.landed_s is not None:
            info[ENDED] = h.landed_s
        return Trajectory(
            h.t_s,
            h.com_m,
            h.com_velocity_m_s,
            h.angle_rad,
            h.rate_rad_s,
            h.reaction_N,
            h.gap_m,
            h.com_residual_m,
            h.torque_N_m,
            position_m=h.position_m,
            impulse_N_s=h.impulse_N_s,
            condition=h.condition,
            ended=landing_text(h.landed_s),
            info=info,
        )


class ReferenceNumPy(ReferenceEngine):
    """Common part of both coordinate sets of the NumPy reference."""

    coordinate_set: ClassVar[CoordinateSet]

    def prepare(self, model: ChainModel, start: InitialState, rtol: float) -> SimulationRun:
        """SciPy's stepper on the NumPy right-hand side."""
        from reference_impl.integrate.simulate import Simulation

        state = (start.com_m, start.com_velocity_m_s, start.angle_rad, start.rate_rad_s)
        return Simulation(model, *state, rtol=rtol, coordinates=self.coordinate_set)


@final
class Reference(ReferenceNumPy):
    """Relative formulation, minimal coordinates."""

    title = "NumPy reference, relative formulation, DOP853"
    coordinates = Coordinates.RELATIVE
    coordinate_set = "minimal"


@final
class ReferenceAbsolute(ReferenceNumPy):
    """Absolute inertial coordinates."""

    title = "NumPy reference in absolute inertial coordinates, DOP853"
    coordinates = Coordinates.ABSOLUTE
    coordinate_set = "absolute"
    track_by_length = True

    @classmethod
    def noise(cls, scene: Scene, setting: Setting, t_s: Array) -> dict[str, float | Array]:
        """Smallest errors of the steps, whatever the requested accuracy.

        No step is held to less than GRAINS roundings of a radius, in velocities times the fastest rate w. With one step
        per radian of w, the roundings add up as a random walk of w t steps; those of velocities integrate further, by
        t. In angles the error is that of a position over half of the shortest bar, as a bar's centre and its end have
        positions of their own; FEW_STEPS of them may stand in one sample. A step is held by the root mean square over
        all bars, so that one bar of N may have sqrt(N) times that error.
        """
        del setting
        position, w = ROUNDINGS * np.finfo(float).eps * scene.radius0_m, scene.fastest_rate_rad_s
        steps, lever = np.sqrt(1.0 + w * t_s), 0.5 * min(scene.chain.length_m) / math.sqrt(scene.bars)
        rate = position * w * np.maximum(steps, FEW_STEPS) / lever
        turn = FEW_STEPS * position / lever
        force = 2.0 * scene.mass_kg * max(scene.chain.length_m) * w * rate  # centrifugal forces follow the rates
        return {
            "com": position * steps * (1.0 + w * t_s),
            "com_velocity": position * w * steps,
            "rate": rate,
            "attitude": turn,
            "reaction": force,
        }
