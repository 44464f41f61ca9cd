"""`scipy.integrate.solve_ivp` with a typical user's options."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np
from scipy.integrate import solve_ivp

from adapters.common.solver_driver import SolvedSegment
from adapters.engine import EngineError

if TYPE_CHECKING:
    from collections.abc import Callable

    from scipy.integrate._ivp.ivp import OdeResult

    from adapters.common.solver_driver import Problem
    from adapters.trajectory import Array

Method = Literal["DOP853", "Radau"]
RTOL_FLOOR = 100.0 * np.finfo(float).eps  # SciPy replaces smaller values by this one, with a warning
STOPPED = 1  # SciPy's status after a terminal event


@dataclass(frozen=True)
class ScipySolver:
    """One method of `solve_ivp` at one pair of tolerances."""

    method: Method
    rtol: float
    atol: float | Array

    locates_events: ClassVar[bool] = True

    def solve(self, problem: Problem, start_s: float, instants_s: Array, y: Array) -> SolvedSegment:
        """Integrate from state `y` at `start_s` through `instants_s`, with output at each.

        Raises
        ------
        EngineError
            If SciPy reports a failure; the message includes SciPy's warnings.
        """
        rows: list[Array] = []
        event_calls, jacobians, pieces, stopped = problem.event_calls, 0, 0, None
        while len(rows) < len(instants_s):
            found = self.integrated(problem, start_s, instants_s[len(rows) :], y)
            if len(found.t):  # SciPy's states are an empty list, and no array, where an event comes before them
                rows += list(found.y.T)
            jacobians, pieces = jacobians + int(found.njev), pieces + 1
            if found.status != STOPPED:
                break
            assert found.t_events is not None
            assert found.y_events is not None
            surface, *modes = found.t_events
            if len(surface):
                stopped = float(surface[0])
                break
            assert problem.mode_events is not None
            start_s, y = float(modes[0][0]), found.y_events[1][0]
            problem.mode_events.change(start_s, y)
        # SciPy calls the surface's event once at each start and once after each step
        return SolvedSegment(np.array(rows), stopped, problem.event_calls - event_calls - pieces, jacobians)

    def integrated(self, problem: Problem, start_s: float, instants_s: Array, y: Array) -> OdeResult:
        """Result of `solve_ivp` as far as the first event."""
        surface = TerminalEvent(problem.height_at_event)
        modes = [TerminalEvent(problem.mode_events.margin)] if problem.mode_events else []
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            found = solve_ivp(
                problem.rate,
                (start_s, instants_s[-1]),
                y,
                method=self.method,
                t_eval=instants_s,
                events=[surface, *modes],
                rtol=max(self.rtol, RTOL_FLOOR),
                atol=self.atol,
            )
        if not found.success:
            words = dict.fromkeys([str(w.message) for w in said] + [str(found.message)])
            raise EngineError(f"{self.method}: {' '.join(words)}")
        return found


@dataclass
class TerminalEvent:
    """Event that ends an integration where a function falls through zero."""

    function: Callable[[float, Array], float]
    terminal: bool = True
    direction: float = -1.0

    def __call__(self, t_s: float, y: Array) -> float:
        """Value of the function."""
        return self.function(t_s, y)
