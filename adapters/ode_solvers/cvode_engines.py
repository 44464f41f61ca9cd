"""Engines of SUNDIALS' CVODE, through its C interface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, final

from adapters.common.solver_driver import SolvedSegment
from adapters.engine import AccuracyParameter, AccuracySweep, EngineError
from adapters.ode_solvers.engine import SolverEngine
from adapters.ode_solvers.python_callbacks import PythonFunctions

if TYPE_CHECKING:
    from adapters.common.solver_driver import Problem
    from adapters.trajectory import Array

MOST_STEPS = 10_000_000  # between two samples; CVODE's default of 500 is too small for long intervals


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
        from adapters.ode_solvers.sundials import ADAMS, BDF, Cvode

        functions = problem.compiled or PythonFunctions(problem)
        run = Cvode(BDF if self.stiff else ADAMS, functions, y, start_s)
        try:
            run.set_tolerances(self.rtol, self.atol, MOST_STEPS)
            if self.stiff:
                run.solve_by_newton()
            else:
                run.solve_by_iteration()
            run.stop_at_surface()
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
