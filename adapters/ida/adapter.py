"""IDA adapter: four forms of the constraints, one integrator."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, final

import numpy as np

from adapters.bar_loads.chain_loads import SUPPORTED
from adapters.bar_loads.joint_tree import Jumps, reasons
from adapters.common.initial_state import initial_state
from adapters.common.landing import landing_text
from adapters.common.solver_driver import Problem, SolvedSegment, drive
from adapters.engine import AccuracyParameter, AccuracySweep, Coordinates, Engine, EngineError, Setting
from adapters.ida.chain import PLACES, Form, RedundantChain
from adapters.trajectory import Observable, Trajectory
from scenarios.effect_types import COM_SHARE

if TYPE_CHECKING:
    from adapters.trajectory import Array
    from scenarios import Scene

DIFFERENCES = 8.3
"""Norm of the coefficients of the fifth backward formula: what h times a derivative makes of independent errors"""
STEP = 0.23
"""Step in radians over the sixth root of the tolerance of places, measured at 1e-4 to 1e-11: the fifth formula's"""
DEVIATIONS = 30.0
"""Largest error over a standard deviation: where step and order change, of bars that come to turn faster than at the
start; up to 22 was measured, on paper/fig09"""
MOST_STEPS = 10_000_000  # between two samples; IDA's default of 500 is too small for long intervals


@dataclass(frozen=True)
class IdaSolver:
    """IDA at one accuracy; states have the chain's components in SI units."""

    chain: RedundantChain
    rtol: float
    locates_events: ClassVar[bool] = False

    def solve(self, problem: Problem, start_s: float, instants_s: Array, y: Array) -> SolvedSegment:
        """Integrate from state `y` at `start_s` through `instants_s`, with output at each.

        Raises
        ------
        EngineError
            If IDA reports a failure.
        """
        from adapters.ida.sundials import Ida

        chain, rate = self.chain, self.chain.rate
        begun, slopes = chain.consistent(start_s * rate, y / chain.units)
        run = Ida(chain, start_s * rate, begun, slopes, self.rtol, MOST_STEPS)
        try:
            found = run.run(instants_s * rate)
        except EngineError as error:
            raise EngineError(f"IDA, {chain.form.name.lower()}: {error}") from error
        finally:
            problem.evaluations += run.evaluations
            problem.event_calls += run.event_calls
            run.close()
        stopped = None if found.stopped_s is None else found.stopped_s / rate
        return SolvedSegment(found.y * chain.units, stopped, found.steps, found.jacobians)


class IdaEngine(Engine):
    """Redundant coordinates in a freely falling frame, with error control by IDA."""

    coordinates = Coordinates.MOVING_FRAME
    order = None
    sweep = AccuracySweep(
        AccuracyParameter.RTOL, (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12), default=1e-9
    )
    effects = SUPPORTED | {COM_SHARE}
    unsupported_reasons = reasons(
        "prescribed rotation is not supported: the adapter's constraints hold the joints, and no bar to a law"
    )
    step_constant = 5.0  # multistep estimates are differences of earlier steps, as CVODE's
    observables = frozenset(Observable) - {Observable.COM_RESIDUAL, Observable.TORQUE}
    form: ClassVar[Form]

    @classmethod
    def noise(cls, scene: Scene, setting: Setting, t_s: Array) -> dict[str, float | Array]:
        """Error of multipliers, which are derivatives of what is requested, by differences over steps of h.

        At index 2 a rate's error over h, at index 3 a place's error over h², as h goes with the sixth root of the
        request: reactions are known to its power 5/6 and 2/3. No test of IDA sees them.
        """
        del t_s
        places = PLACES if cls.form is Form.INDEX_3 else 1.0
        step = STEP * (places * setting.value) ** (1.0 / 6.0)
        derivatives = {Form.INDEX_1: 0, Form.INDEX_3: 2}.get(cls.form, 1)
        share = DEVIATIONS * places * setting.value * (DIFFERENCES / step) ** derivatives if derivatives else 0.0
        force = max(m * size for m, size in zip(scene.chain.mass_kg, scene.chain.length_m, strict=True))
        return {"reaction": share * force * scene.fastest_rate_rad_s**2}

    def build(self, scene: Scene, setting: Setting) -> None:
        """Make the equations and a consistent initial state."""
        self.scene, self.chain = scene, RedundantChain(scene, self.form)
        self.jumps, self.solver = Jumps(scene, self.chain), IdaSolver(self.chain, setting.value)
        struck = self.jumps.begin(self.chain.start(initial_state(scene)))
        begun, _ = self.chain.consistent(0.0, struck / self.chain.units)
        self.problem = Problem(self.slopes, begun * self.chain.units, self.chain.height)

    def slopes(self, t_s: float, y: Array) -> Array:
        """Time derivative of a state."""
        _, slopes = self.chain.consistent(t_s * self.chain.rate, y / self.chain.units)
        found: Array = slopes * self.chain.units * self.chain.rate
        return found

    def simulate(self) -> None:
        """Integrate."""
        try:
            self.driven = drive(self.solver, self.problem, self.scene.times_s, self.scene.effects.breaks_s, self.jumps)
        except (ArithmeticError, ValueError) as error:
            raise EngineError(f"IDA: {error}") from error

    def read(self) -> Trajectory:
        """Observables at the samples; reactions are the multipliers."""
        walk, chain = self.driven.walk, self.chain
        y, share = walk.y, np.array(self.scene.chain.mass_kg) / self.scene.mass_kg
        position, velocity = (y[:, part].reshape(len(y), 3, -1) for part in (chain.q, chain.v))
        com, com_velocity = position[:, :2] @ share, velocity[:, :2] @ share
        unit = chain.units[4]
        gap = np.array([chain.gaps(q) for q in y[:, chain.q] / chain.units[chain.q]]).reshape(len(y), 2, -1) * unit
        return Trajectory(
            walk.t_s,
            y[:, :2] + com,
            y[:, 2:4] + com_velocity,
            position[:, 2],
            velocity[:, 2],
            y[:, chain.reactions].reshape(len(y), 2, -1).transpose(0, 2, 1),
            np.hypot(*gap.transpose(1, 0, 2)),
            position_m=position[:, :2].transpose(0, 2, 1) - com[:, None],
            impulse_N_s=self.jumps.impulses(walk.t_s) if self.scene.effects.impulse else None,
            ended=landing_text(walk.stopped_s),
            info={"steps": walk.steps, "evaluations": walk.evaluations, "jacobians": self.driven.jacobians},
        )


@final
class IdaIndex1(IdaEngine):
    """Constraints of accelerations: the joints drift apart."""

    title = "IDA (SUNDIALS), redundant coordinates in a freely falling frame, index 1"
    form = Form.INDEX_1
    sweep = AccuracySweep(
        AccuracyParameter.RTOL, (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12), default=1e-9
    )


@final
class IdaIndex2(IdaEngine):
    """Constraints of velocities: the joints drift apart, more slowly."""

    title = "IDA (SUNDIALS), redundant coordinates in a freely falling frame, index 2"
    form = Form.INDEX_2


@final
class IdaGgl(IdaEngine):
    """Constraints of velocities and positions, by Gear, Gupta and Leimkuhler."""

    title = "IDA (SUNDIALS), redundant coordinates in a freely falling frame, stabilised index 2"
    form = Form.STABILISED
    sweep = AccuracySweep(
        AccuracyParameter.RTOL, (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11), default=1e-9
    )


@final
class IdaIndex3(IdaEngine):
    """Constraints of positions."""

    title = "IDA (SUNDIALS), redundant coordinates in a freely falling frame, index 3"
    form = Form.INDEX_3
    step_constant = 2.5  # of rates, which are 2 requests off by differences of places
    sweep = AccuracySweep(AccuracyParameter.RTOL, (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7), default=1e-7)
