"""Engines of SUNDIALS' CVODE, through scikit-sundae."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, final

import numpy as np

from adapters.engine import AccuracyParameter, AccuracySweep, EngineError
from adapters.ode_solvers.driver import SolvedSegment
from adapters.ode_solvers.engine import SolverEngine

if TYPE_CHECKING:
    from adapters.ode_solvers.driver import Problem
    from adapters.trajectory import Array

MOST_STEPS = 10_000_000  # between two samples; CVODE's default of 500 is too small for long intervals


class CvodeSurfaceEvent:
    """Event that ends a run at the surface."""

    terminal = (True,)
    direction = (-1,)

    def __init__(self, problem: Problem) -> None:
        self.problem = problem

    def __call__(self, t_s: float, y: Array, height: Array) -> None:
        """Set the height of the chain."""
        height[0] = self.problem.height_at_event(t_s, y)


@dataclass(frozen=True)
class CvodeSolver:
    """One linear multistep method of CVODE at one pair of tolerances."""

    method: str
    rtol: float
    atol: float

    def solve(self, problem: Problem, start_s: float, instants_s: Array, y: Array) -> SolvedSegment:
        """Integrate from state `y` at `start_s` through `instants_s`, with output at each.

        Raises
        ------
        EngineError
            If CVODE reports a failure.
        """
        from sksundae.cvode import CVODE

        def rate(t_s: float, state: Array, out: Array) -> None:
            out[:] = problem.rate(t_s, state)

        solver = CVODE(
            rate,
            method=self.method,
            rtol=self.rtol,
            atol=self.atol,
            eventsfn=CvodeSurfaceEvent(problem),
            num_events=1,
            max_num_steps=MOST_STEPS,
        )
        event_calls = problem.event_calls
        found: Any = solver.solve(np.concatenate([[start_s], instants_s]), y)
        if not found.success:
            raise EngineError(f"CVODE, {self.method}: {found.message}")
        steps = (
            problem.event_calls - event_calls - 1 - len(instants_s)
        )  # CVODE calls the event at the start, after each step and at each instant
        alone = len(instants_s) == 1  # CVODE then returns every step of its own, the last of them at the instant
        if found.t_events is None:
            return SolvedSegment(found.y[-1:] if alone else found.y[1:], None, steps, int(found.njev))
        reached = found.y[:0] if alone else found.y[1:-1]  # the last row is the event's
        return SolvedSegment(reached, float(found.t_events[0]), steps, int(found.njev))


class CvodeEngine(SolverEngine):
    """Common part of both methods."""

    method: ClassVar[str]
    step_constant = 5.0  # multistep estimates are differences of earlier steps; up to 2.3 was measured

    def solver(self, rtol: float, atol: float) -> CvodeSolver:
        """CVODE with this method."""
        return CvodeSolver(self.method, rtol, atol)


@final
class CvodeAdams(CvodeEngine):
    """Adams-Moulton, orders 1 to 12: for problems that are not stiff."""

    title = "CVODE (SUNDIALS), Adams, on the reference's equations"
    method = "Adams"
    sweep = AccuracySweep(
        AccuracyParameter.RTOL, (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12), default=1e-10
    )


@final
class CvodeBdf(CvodeEngine):
    """Backward differences, orders 1 to 5: for stiff problems."""

    title = "CVODE (SUNDIALS), BDF, on the reference's equations"
    method = "BDF"
    sweep = AccuracySweep(AccuracyParameter.RTOL, (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11), default=1e-9)
