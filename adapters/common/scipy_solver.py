"""SciPy's solvers with a typical user's options, step by step as `solve_ivp` takes them."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from scipy.integrate import DOP853, Radau
from scipy.optimize import brentq

from adapters.common.solver_driver import SolvedSegment
from adapters.engine import EngineError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from adapters.common.solver_driver import Problem
    from adapters.trajectory import Array

Method = Literal["DOP853", "Radau"]
METHODS: dict[Method, Any] = {"DOP853": DOP853, "Radau": Radau}
RTOL_FLOOR = 100.0 * np.finfo(float).eps  # SciPy replaces smaller values by this one, with a warning
EVENT_SHARES = (0.0, 0.25, 0.5, 0.75)
"""Parts of a step, beside its end, at which modes are watched: `solve_ivp` looks at ends alone, and misses a bar that
shows its other face for half a step"""
EVENT_TOLERANCE = 1e-12  # of a step


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
        steps, jacobians, t = 0, 0, start_s
        while t < instants_s[-1]:
            solver, event_s = self.begun(problem, t, y, instants_s[-1]), None
            while solver.status == "running" and event_s is None:
                take_step(solver)
                steps, dense, end = steps + 1, solver.dense_output(), float(solver.t)
                landed_s = fall(lambda _, state: problem.height(state), dense, (solver.t_old, end))
                if problem.mode_events:
                    parts = solver.t_old + np.array(EVENT_SHARES) * (end - solver.t_old)
                    event_s = fall(problem.mode_events.margin, dense, (*parts, end))
                until = min(x for x in (landed_s, event_s, end) if x is not None)
                rows += [dense(x) for x in instants_s[len(rows) :] if x <= until]
                if landed_s == until:
                    return SolvedSegment(np.array(rows), landed_s, steps, jacobians + int(solver.njev))
            jacobians += int(solver.njev)
            t, y = (float(solver.t), solver.y) if event_s is None else (event_s, dense(event_s))
            if event_s is not None and problem.mode_events:
                problem.mode_events.change(t, y)
        return SolvedSegment(np.array(rows), None, steps, jacobians)

    def begun(self, problem: Problem, start_s: float, y: Array, end_s: float) -> Any:
        """SciPy's solver at a start."""
        return METHODS[self.method](problem.rate, start_s, y, end_s, rtol=max(self.rtol, RTOL_FLOOR), atol=self.atol)


def take_step(solver: Any) -> None:
    """One step of a solver.

    Raises
    ------
    EngineError
        If it fails; the message includes SciPy's warnings.
    """
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        message = solver.step()
    if solver.status == "failed":
        words = dict.fromkeys([*(str(w.message) for w in said), str(message)])
        raise EngineError(f"{type(solver).__name__}: {' '.join(words)}")


def fall(
    function: Callable[[float, Array], float], dense: Callable[[float], Array], watched_s: Iterable[float]
) -> float | None:
    """First instant in a step at which a function falls through zero between two of the instants; None without one."""
    before_s = before = None
    for t in watched_s:
        now = function(t, dense(t))
        if before_s is not None and before is not None and before > 0.0 >= now:
            slack = EVENT_TOLERANCE * (t - before_s)
            return float(brentq(lambda x: function(x, dense(x)), before_s, t, xtol=slack))
        before_s, before = t, now
    return None
