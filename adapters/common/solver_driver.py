"""Driver of a library's ODE solver, with restarts at events and a stop at the surface; and SciPy's solvers."""

from __future__ import annotations

import warnings
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Protocol

import numpy as np
from scipy.integrate import DOP853, Radau
from scipy.optimize import brentq

from adapters.engine import EngineError
from reference_impl.integrate.stepper import TIME_EVENT_TOLERANCE, Integration, smooth_segments

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from adapters.trajectory import Array

Method = Literal["DOP853", "Radau"]
METHODS: dict[Method, Any] = {"DOP853": DOP853, "Radau": Radau}
RTOL_FLOOR = 100.0 * np.finfo(float).eps  # SciPy replaces smaller values by this one, with a warning
EVENT_SHARES = (0.0, 0.25, 0.5, 0.75)
"""Parts of a step, beside its end, at which modes are watched: `solve_ivp` looks at ends alone, and misses a bar that
shows its other face for half a step"""
EVENT_TOLERANCE = 1e-12  # of a step


@dataclass(frozen=True)
class SolvedSegment:
    """States that a solver returned between two events."""

    y: Array
    """(k, size) states at the requested instants, as far as the solver got"""
    stopped_s: float | None
    """Instant at which the chain reached the surface"""
    steps: int
    jacobians: int
    """Number of Jacobians; their evaluations are part of the problem's count"""


class CFunctions(ABC):
    """C functions of a problem, for a solver with a C interface."""

    rates: int
    """Address of ``int f(double t, N_Vector y, N_Vector rates, void *user_data)``"""
    height: int
    """Address of ``int f(double t, N_Vector y, double *height, void *user_data)``"""
    user_data: int
    """Address of the last argument"""

    @abstractmethod
    def read_vectors(self, data_of: int) -> None:
        """Take the address of the library's function from a vector to its numbers."""

    @abstractmethod
    def counts(self) -> tuple[int, int]:
        """Evaluations of the rates and of the height since the last call."""

    @abstractmethod
    def failure(self) -> BaseException | None:
        """Exception in the equations since the last call."""


class ModeEvents(Protocol):
    """Modes of effects that are held between events of the state, such as the face of a bar towards the wind."""

    def margin(self, t_s: float, y: Array) -> float:
        """Least of the event functions, positive while the modes are valid."""

    def change(self, t_s: float, y: Array) -> None:
        """Set the modes that are valid after the event at this instant."""


@dataclass
class Problem:
    """An initial value problem that counts evaluations.

    With requested output instants, libraries report neither their steps nor the evaluations of differenced Jacobians.
    The number of event evaluations gives the number of steps.
    """

    rhs: Callable[[float, Array], Array]
    y0: Array
    """(size,)"""
    height: Callable[[Array], float]
    """Least distance of the chain from the surface, m"""
    compiled: CFunctions | None = None
    """The same two functions in machine code, which a solver with a C interface calls instead"""
    mode_events: ModeEvents | None = None
    """Events at which the solver stops and modes change; None: the rates take the modes of each evaluated state"""
    evaluations: int = field(default=0, init=False)
    event_calls: int = field(default=0, init=False)

    def rate(self, t_s: float, y: Array) -> Array:
        """Time derivative of the state, counted."""
        self.evaluations += 1
        return self.rhs(t_s, y)

    def height_at_event(self, t_s: float, y: Array) -> float:
        """Height of the chain, counted."""
        del t_s
        self.event_calls += 1
        return self.height(y)


class Solver(Protocol):
    """One library's solver at one setting."""

    locates_events: ClassVar[bool]
    """Whether it stops at events of the state, and lets the modes change there"""

    def solve(self, problem: Problem, start_s: float, instants_s: Array, y: Array) -> SolvedSegment:
        """Integrate from state `y` at `start_s` through `instants_s`, with output at each.

        Raises
        ------
        EngineError
            If the solver reports a failure.
        """


@dataclass(frozen=True)
class SolverResult:
    """States of a run and the work of the solver."""

    walk: Integration
    jacobians: int


class RestartRule(Protocol):
    """Change of the state at an event."""

    def begin_segment(self, start_s: float, end_s: float, y: Array) -> Array:
        """State just after the event at `start_s`; the solver continues from there to `end_s`."""


def drive(
    solver: Solver,
    problem: Problem,
    t_s: Array,
    breaks_s: tuple[float, ...] = (),
    breaks: RestartRule | None = None,
) -> SolverResult:
    """Integrate over the samples `t_s`, (n,), with a restart at every event, where the law of motion changes.

    Raises
    ------
    EngineError
        If the solver fails, or its state is not finite.
    """
    if not np.isfinite([problem.y0, problem.rhs(t_s[0], problem.y0)]).all():
        raise EngineError("the initial state or its rate is not finite")  # solvers would search a step without end
    rows, y, stopped, steps, jacobians = [problem.y0], problem.y0, None, 0, 0
    slack = TIME_EVENT_TOLERANCE * (t_s[-1] - t_s[0])
    for start, end in smooth_segments(t_s, breaks_s):
        if breaks:
            y = breaks.begin_segment(start, end, y)
        wanted = t_s[(t_s > start + slack) & (t_s <= end + slack)]
        instants = np.minimum(wanted, end)
        if not len(wanted) or instants[-1] < end:
            instants = np.append(instants, end)
        found = solver.solve(problem, start, instants, y)
        if not np.isfinite(found.y).all():
            raise EngineError(f"the state is not finite between t = {start:.6g} and {end:.6g} s")
        rows += list(found.y[: len(wanted)])
        steps, jacobians, stopped = steps + found.steps, jacobians + found.jacobians, found.stopped_s
        if stopped is not None:
            break
        y = found.y[-1]
    return SolverResult(Integration(t_s[: len(rows)], np.array(rows), steps, problem.evaluations, stopped), jacobians)


@dataclass(frozen=True)
class ScipySolver:
    """One method of `solve_ivp` at one pair of tolerances, step by step as `solve_ivp` takes them."""

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
