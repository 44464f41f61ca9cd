"""Engines that step the reference's right-hand side with a library's solver: SciPy's, and CVODE by its C interface."""

from __future__ import annotations

import dataclasses
import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, final

from adapters.common.solver_driver import Method, Problem, ScipySolver, SolvedSegment, Solver, drive
from adapters.engine import AccuracyParameter, AccuracySweep, Coordinates, EngineError
from adapters.reference.numpy_engines import EVERYTHING, ReferenceEngine
from reference_impl.integrate.discrete_modes import DiscreteModes
from reference_impl.integrate.simulate import Simulation

if TYPE_CHECKING:
    from adapters.common.initial_state import InitialState
    from adapters.ode_solvers.compiled import CompiledFunctions, RatesFunction
    from adapters.trajectory import Trajectory
    from reference_impl.integrate.simulate import History
    from reference_impl.integrate.stepper import Integration
    from reference_impl.model.arrays import Array
    from reference_impl.model.chain import ChainModel

MOST_STEPS = 10_000_000  # between two samples; CVODE's default of 500 is too small for long intervals
ATOL_SHARE = 1e-3
"""Absolute tolerance relative to `rtol`. A typical user gives one number for metres, radians and their rates.
SciPy's defaults are 1e-3 and 1e-6, and that ratio suits the smallest of these, rates of 1e-3 rad/s in orbit."""


class SolverRun:
    """One simulation by a library's solver, on compiled rates and in their order of components."""

    most_events: float = math.inf
    """State events after which the run gives up"""

    jacobians = 0

    def __init__(self, simulation: Simulation, solver: Solver) -> None:
        """Load the compiled rates."""
        from adapters.ode_solvers.compiled import CompiledFunctions, RatesFunction

        self.simulation, self.solver = simulation, solver
        self.function = RatesFunction(simulation.model)
        self.c_functions = CompiledFunctions(self.function)
        y0 = compiled_order(self.function, simulation.y0)
        self.problem = Problem(self.function.rates_at, y0, self.c_functions.height_m)

    def integrate(self, t_s: Array) -> Integration:
        """Integrate over the samples, `t_s` (n,)."""
        own = self.simulation
        if own.model.effects or own.model.impulses:
            own.events = DiscreteModes(
                own.coordinates,
                float(t_s[-1]),
                detects_events=self.solver.locates_events,
                most_events=self.most_events,
            )
        try:
            return self.driven(t_s)
        finally:
            own.coordinates.modes = None

    def driven(self, t_s: Array) -> Integration:
        """Integrate in the compiled order of components."""
        own = self.simulation
        restart = CompiledRestart(own.events, self.function, self.problem, self.c_functions)
        restart.hold()
        self.problem.mode_events = restart if own.events and own.events.detects_events else None
        result = drive(self.solver, self.problem, t_s, own.model.breaks_s, restart if own.events else None)
        self.jacobians = result.jacobians
        return dataclasses.replace(result.walk, y=result.walk.y[:, self.function.order])

    def history(self, result: Integration, *, condition: bool = False) -> History:
        """Observables at the samples."""
        return self.simulation.history(result, condition=condition)


@dataclass(frozen=True)
class CompiledRestart:
    """Change of a compiled state, and of the modes of its rates, at an event of time or of the state."""

    events: DiscreteModes | None
    function: RatesFunction
    problem: Problem
    c_functions: CompiledFunctions

    def begin_segment(self, start_s: float, end_s: float, y: Array) -> Array:
        """Apply the impulses at this instant, and set the modes until `end_s`."""
        assert self.events is not None
        begun = self.events.begin_segment(start_s, end_s, y[self.function.order])
        self.hold()
        return compiled_order(self.function, begun)

    def margin(self, t_s: float, y: Array) -> float:
        """Least of the event functions, positive while the modes are valid."""
        assert self.events is not None
        return self.events.margin(t_s, y[self.function.order])

    def change(self, t_s: float, y: Array) -> None:
        """Set the modes that are valid after the event at this instant."""
        assert self.events is not None
        self.events.change(t_s, y[self.function.order])
        self.hold()

    def hold(self) -> None:
        """Set the modes; where some follow from each evaluated state, the solver calls Python for each evaluation."""
        self.function.hold(self.events.modes if self.events else None)
        self.problem.compiled = None if self.function.following else self.c_functions


def compiled_order(function: RatesFunction, y: Array) -> Array:
    """Components of a vector of the NumPy reference in the compiled order, (size,)."""
    found = y.copy()
    found[function.order] = y
    return found


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


class ScipyEngine(SolverEngine):
    """Common part of all methods of `solve_ivp`."""

    method: ClassVar[Method]

    def solver(self, rtol: float, atol: float) -> ScipySolver:
        """`solve_ivp` with this method."""
        return ScipySolver(self.method, rtol, atol)


@final
class ScipyDop853(ScipyEngine):
    """The method of highest order in `solve_ivp`."""

    title = "SciPy's DOP853 on the compiled reference's equations"
    method = "DOP853"


@final
class ScipyRadau(ScipyEngine):
    """Implicit, for stiff problems; the free chain is not stiff."""

    title = "SciPy's Radau on the compiled reference's equations"
    method = "Radau"
    sweep = AccuracySweep(AccuracyParameter.RTOL, (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10), default=1e-7)


@dataclass(frozen=True)
class CvodeSolver:
    """One linear multistep method of CVODE at one pair of tolerances."""

    stiff: bool
    """Backward differences with Newton's method, else Adams with fixed-point iteration, as SUNDIALS advises"""
    rtol: float
    atol: float
    locates_events: ClassVar[bool] = False

    def solve(self, problem: Problem, start_s: float, instants_s: Array, y: Array) -> SolvedSegment:
        """Integrate from state `y` at `start_s` through `instants_s`, with output at each.

        Raises
        ------
        EngineError
            If CVODE reports a failure.
        """
        from adapters.ode_solvers.sundials import ADAMS, BDF, Cvode, PythonFunctions

        functions = problem.compiled or PythonFunctions(problem)
        run = Cvode(BDF if self.stiff else ADAMS, functions, y, start_s)
        try:
            run.set_tolerances(self.rtol, self.atol, MOST_STEPS)
            if self.stiff:
                run.solve_by_newton()
            else:
                run.solve_by_iteration()
            run.stop_at_surface(functions.height)
            found = run.run(instants_s)
        except EngineError as error:
            raise EngineError(f"CVODE, {'BDF' if self.stiff else 'Adams'}: {error}") from error
        finally:
            run.close()
            evaluations, event_calls = functions.counts()
            problem.evaluations += evaluations
            problem.event_calls += event_calls
        return SolvedSegment(found.y, found.stopped_s, found.steps, found.jacobians)


class CvodeMethod(SolverEngine):
    """Common part of both methods."""

    stiff: ClassVar[bool] = False
    step_constant = 5.0  # multistep estimates are differences of earlier steps; up to 2.3 was measured
    sweep = AccuracySweep(
        AccuracyParameter.RTOL, (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12), default=1e-10
    )

    def solver(self, rtol: float, atol: float) -> CvodeSolver:
        """CVODE with this method."""
        return CvodeSolver(self.stiff, rtol, atol)


@final
class CvodeAdams(CvodeMethod):
    """Adams-Moulton, orders 1 to 12: for problems that are not stiff."""

    title = "CVODE (SUNDIALS), Adams, on the compiled reference's equations"


@final
class CvodeBdf(CvodeMethod):
    """Backward differences, orders 1 to 5: for stiff problems."""

    title = "CVODE (SUNDIALS), BDF, on the compiled reference's equations"
    stiff = True
    sweep = AccuracySweep(AccuracyParameter.RTOL, (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11), default=1e-9)
