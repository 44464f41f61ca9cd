"""Drake's simulator with an integrator of error control, on the state of a chain in units of its own.

Drake's error control counts every component of a state in units of 1. The continuous state is therefore the chain's
state over the unit of each component.

Caching is disabled in the simulator's context: with caching Drake's RK5 repeats a rejected step with a stale
derivative (`benchmarks/drake_caching.py`). The plant has a context of its own, where caching stays on. Without caching
a plant computes its kinematics anew for each result that depends on them: 4 times as long for 5 bars, 58 times for 200.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from adapters.common.solver_driver import SolvedSegment
from adapters.engine import EngineError

if TYPE_CHECKING:
    from adapters.common.solver_driver import Problem
    from adapters.trajectory import Array

FIRST_STEP = 0.01  # of a segment; Drake's own first step is a tenth of the longest, and is rejected many times


@dataclass(frozen=True)
class DrakeIntegrator:
    """One of Drake's integrators at one accuracy."""

    scheme: str
    """Name as `ResetIntegratorFromFlags` reads it"""
    accuracy: float
    units: Array
    """Unit of each component of a state"""
    locates_events: ClassVar[bool] = False

    def solve(self, problem: Problem, start_s: float, instants_s: Array, y: Array) -> SolvedSegment:
        """Integrate from state `y` at `start_s` through `instants_s`, with output at each.

        Raises
        ------
        EngineError
            If Drake reports a failure.
        """
        from pydrake.systems.analysis import SimulatorStatus

        end = SimulatorStatus.ReturnReason
        simulator = self.simulator(problem, start_s, float(instants_s[-1]), y)
        context, rows = simulator.get_context(), []
        try:
            for instant in instants_s.tolist():
                reason = simulator.AdvanceTo(instant).reason()
                landed = reason == end.kReachedTerminationCondition
                if landed:
                    break
                if reason != end.kReachedBoundaryTime:
                    raise EngineError(f"Drake: t = {context.get_time():.6g} s: stopped by {reason.name}")
                rows.append(self.units * context.get_continuous_state_vector().CopyToVector())
        except RuntimeError as error:
            raise EngineError(f"Drake: t = {context.get_time():.6g} s: {error}") from error
        steps = simulator.get_integrator().get_num_steps_taken()
        stopped = float(context.get_time()) if landed else None
        return SolvedSegment(np.array(rows).reshape(len(rows), len(y)), stopped, steps, 0)

    def simulator(self, problem: Problem, start_s: float, end_s: float, y: Array) -> Any:
        """Simulator at the state `y` at `start_s`."""
        from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator

        simulator = Simulator(chain_system(problem, self.units))
        context = simulator.get_mutable_context()
        context.DisableCaching()
        context.SetAccuracy(self.accuracy)  # of the instant at the surface; Drake fails there without it
        context.SetTime(start_s)
        context.SetContinuousState(y / self.units)
        ResetIntegratorFromFlags(simulator, self.scheme, end_s - start_s)
        integrator = simulator.get_mutable_integrator()
        integrator.set_target_accuracy(self.accuracy)
        integrator.request_initial_step_size_target(FIRST_STEP * (end_s - start_s))
        simulator.Initialize()
        return simulator


def chain_system(problem: Problem, units: Array) -> Any:
    """Drake's system of a problem, its state in `units`; the simulation terminates at the surface."""
    from pydrake.systems.framework import EventStatus, LeafSystem, PublishEvent, WitnessFunctionDirection

    class ChainSystem(LeafSystem):  # type: ignore[misc]
        """The chain and the frame's origin."""

        def __init__(self) -> None:
            super().__init__()
            self.DeclareContinuousState(len(units))
            self.witness = self.MakeWitnessFunction(
                "height of the chain",
                WitnessFunctionDirection.kPositiveThenNonPositive,
                self.height,
                PublishEvent(callback=lambda *_: EventStatus.ReachedTermination(self, "a bar reached the surface")),
            )

        def state(self, context: Any) -> Array:
            found: Array = units * context.get_continuous_state_vector().CopyToVector()
            return found

        def height(self, context: Any) -> float:
            return problem.height_at_event(context.get_time(), self.state(context))

        def DoGetWitnessFunctions(self, context: Any) -> list[Any]:
            del context
            return [self.witness]

        def DoCalcTimeDerivatives(self, context: Any, derivatives: Any) -> None:
            slope = problem.rate(context.get_time(), self.state(context)) / units
            derivatives.get_mutable_vector().SetFromVector(slope)

    return ChainSystem()
