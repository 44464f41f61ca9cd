"""`scipy.integrate.solve_ivp` with a typical user's options."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.integrate import solve_ivp

from adapters.common.solver_driver import SolvedSegment
from adapters.engine import EngineError

if TYPE_CHECKING:
    from adapters.common.solver_driver import Problem
    from adapters.trajectory import Array

Method = Literal["RK45", "DOP853", "Radau", "LSODA"]
RTOL_FLOOR = 100.0 * np.finfo(float).eps  # SciPy replaces smaller values by this one, with a warning


@dataclass(frozen=True)
class ScipySolver:
    """One method of `solve_ivp` at one pair of tolerances."""

    method: Method
    rtol: float
    atol: float | Array

    def solve(self, problem: Problem, start_s: float, instants_s: Array, y: Array) -> SolvedSegment:
        """Integrate from state `y` at `start_s` through `instants_s`, with output at each.

        Raises
        ------
        EngineError
            If SciPy reports a failure; the message includes SciPy's warnings.
        """
        event_calls = problem.event_calls
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            found = solve_ivp(
                problem.rate,
                (start_s, instants_s[-1]),
                y,
                method=self.method,
                t_eval=instants_s,
                events=ScipySurfaceEvent(problem),
                rtol=max(self.rtol, RTOL_FLOOR),
                atol=self.atol,
            )
        if not found.success:
            words = dict.fromkeys([str(w.message) for w in said] + [str(found.message)])
            raise EngineError(f"{self.method}: {' '.join(words)}")
        stopped = float(found.t_events[0][0]) if found.t_events and found.status == 1 else None
        steps = (
            problem.event_calls - event_calls - 1
        )  # SciPy calls the event once at the start and once after each step
        return SolvedSegment(found.y.T, stopped, steps, int(found.njev))


@dataclass
class ScipySurfaceEvent:
    """Event that ends a run at the surface."""

    problem: Problem
    terminal: bool = True
    direction: float = -1.0

    def __call__(self, t_s: float, y: Array) -> float:
        """Height of the chain."""
        return self.problem.height_at_event(t_s, y)
