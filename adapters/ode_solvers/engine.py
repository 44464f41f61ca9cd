"""Common part of the engines that step the reference's right-hand side with a library's solver.

They show the cost and the errors of a general solver. They are no check of the physics, which is the reference's own.
"""

from __future__ import annotations

import dataclasses
from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar

from adapters.engine import Coordinates
from adapters.ode_solvers.driver import Problem, Solver, drive
from adapters.reference.numpy_engines import EVERYTHING, ReferenceEngine
from reference_impl.integrate.discrete_modes import DiscreteModes
from reference_impl.integrate.simulate import Simulation

if TYPE_CHECKING:
    from adapters.common.initial_state import InitialState
    from adapters.trajectory import Trajectory
    from reference_impl.integrate.simulate import History
    from reference_impl.integrate.stepper import Integration
    from reference_impl.model.arrays import Array
    from reference_impl.model.chain import ChainModel

ATOL_SHARE = 1e-3
"""Absolute tolerance relative to `rtol`. A typical user gives one number for metres, radians and their rates.
SciPy's defaults are 1e-3 and 1e-6, and that ratio suits the smallest of these, rates of 1e-3 rad/s in orbit."""


class SolverRun:
    """One simulation by a library's solver."""

    jacobians = 0

    def __init__(self, simulation: Simulation, solver: Solver) -> None:
        self.simulation, self.solver = simulation, solver

    def integrate(self, t_s: Array) -> Integration:
        """Integrate over the samples, `t_s` (n,)."""
        own = self.simulation
        problem = Problem(own.coordinates.rhs, own.y0, own.height)
        if own.model.effects or own.model.impulses:
            own.events = DiscreteModes(own.coordinates, float(t_s[-1]), detects_events=False)
        try:
            result = drive(self.solver, problem, t_s, own.model.breaks_s, own.events)
        finally:
            own.coordinates.modes = None
        self.jacobians = result.jacobians
        return result.walk

    def history(self, result: Integration, *, condition: bool = False) -> History:
        """Observables at the samples."""
        return self.simulation.history(result, condition=condition)


class SolverEngine(ReferenceEngine):
    """The reference's equations in minimal coordinates, stepped by a library's solver."""

    coordinates = Coordinates.RELATIVE
    effects = EVERYTHING - {"solar_pressure.shadow"}
    unsupported_reasons: ClassVar[dict[str, str]] = {
        "solar_pressure.shadow": "solar_pressure.shadow is not supported: a general solver steps over the shadow's edge"
    }
    prepared: SolverRun

    @abstractmethod
    def solver(self, rtol: float, atol: float) -> Solver:
        """The library's solver at these tolerances."""

    def prepare(self, model: ChainModel, start: InitialState, rtol: float) -> SolverRun:
        """Right-hand side and solver."""
        state = (start.com_m, start.com_velocity_m_s, start.angle_rad, start.rate_rad_s)
        return SolverRun(Simulation(model, *state, rtol=rtol), self.solver(rtol, ATOL_SHARE * rtol))

    def read(self) -> Trajectory:
        """Observables at the samples, and the number of Jacobians."""
        seen = super().read()
        return dataclasses.replace(seen, info=seen.info | {"jacobians": self.prepared.jacobians})
