"""SciPy's solvers, walked step by step: samples by dense output, breaks, projection and a stopping event."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq, minimize_scalar

from reference_impl.integrate.stiffness import RTOL_FLOOR

if TYPE_CHECKING:
    from collections.abc import Callable

    from reference_impl.integrate.stiffness import Method, Solver
    from reference_impl.model.arrays import Array

TIME_EVENT_TOLERANCE = 1e-12  # of the duration: breaks nearer than this to each other or to the ends are one
PARABOLA_MARGIN = 0.5  # of the lower end's height: a parabola's dip below this is looked at closely


@dataclass(frozen=True)
class Integration:
    """What an integration saw."""

    t_s: Array
    """(n,) sample instants reached"""
    y: Array
    """(n, size)"""
    steps: int
    evaluations: int
    stopped_s: float | None
    """Instant at which the event stopped it; None if it went to the end"""


def integrate(
    rhs: Callable[[float, Array], Array],
    y0: Array,
    t_s: Array,
    atol: Array,
    *,
    breaks_s: tuple[float, ...] = (),
    project: Callable[[Array], Array] | None = None,
    surface: BodySurface | None = None,
    events: EventHandler | None = None,
    method: Method = DOP853,
    state_roundoff_floor: Callable[[Array], Array] | None = None,
) -> Integration:
    """Integrate ``y' = rhs(t, y)`` from ``t_s[0]`` and sample it.

    Parameters
    ----------
    rhs : callable
    y0 : ndarray, shape (size,)
    t_s : ndarray, shape (n,)
        Increasing sample instants.
    atol : ndarray, shape (size,)
        Error allowed in one step, per component.
    breaks_s : tuple of float
        Instants at which `rhs` is not smooth; no step straddles one.
    project : callable, optional
        Applied to the state after every step.
    surface : Surface, optional
        The walk stops where its height falls to zero.
    switches : Switches, optional
        What makes `rhs` smooth between breaks, by holding what would jump, and says where it must let go.
    method : type
        Which of SciPy's solvers takes the steps.
    shaken : callable, optional
        Error of the last components of a state that rounding makes in a step anyway, by the last evaluation of `rhs`:
        no explicit step from there is asked for less.

    Returns
    -------
    Walk

    Raises
    ------
    ArithmeticError
        If the step size collapses, or the state or its rate is not finite.
    """
    if not np.all(np.isfinite([y0, rhs(t_s[0], y0)])):
        raise ArithmeticError("the initial state or its rate is not finite")  # SciPy would look for a step for ever
    log, y = (
        StepLog(t_s, [np.array(y0)], StepErrorFloor(atol, state_roundoff_floor if method is DOP853 else None)),
        np.array(y0),
    )
    for start, end in smooth_segments(t_s, breaks_s):
        here = start
        if events:
            y = events.begin_segment(start, end, y)
        while here < end and log.stopped_s is None:
            solver = method(rhs, here, y, end, rtol=RTOL_FLOOR, atol=atol)  # type: ignore[arg-type]  # stubs know scalars only
            here, y = integrate_segment(solver, log, project, surface, events)
            log.evaluations += solver.nfev
        if log.stopped_s is not None:
            break
    return Integration(t_s[: len(log.rows)], np.array(log.rows), log.steps, log.evaluations, log.stopped_s)


def integrate_segment(
    solver: Solver,
    log: StepLog,
    project: Callable[[Array], Array] | None,
    surface: BodySurface | None,
    events: EventHandler | None,
) -> tuple[float, Array]:
    """Step to the end of the stretch, to the surface, or to where a switch falls; returns where that is."""
    log.floor.apply(solver)
    while solver.status == "running" and log.stopped_s is None:
        fallen_s = log.step(solver, surface, events)
        if fallen_s is not None and events:
            return events.apply_event(lambda t: partial_step(solver, t), fallen_s, (solver.t_old, solver.t))
        if project:
            solver.y = project(solver.y)
            solver.f = solver.fun(solver.t, solver.y)
    return float(solver.t), np.asarray(solver.y)


def partial_step(solver: Solver, until_s: float) -> Array:
    """State at an instant inside the last step, by a step to there: an interpolant is some hundred times less exact."""
    step: Any = solver  # stubs know neither its tolerances nor that its earlier state is there
    span = until_s - step.t_old
    if span == 0.0:
        return np.asarray(step.y_old)
    again = type(step)(step.fun, step.t_old, step.y_old, until_s, first_step=span, rtol=RTOL_FLOOR, atol=step.atol)
    while again.status == "running":
        message = again.step()
        if message:
            raise ArithmeticError(f"{type(again).__name__} gave up at t = {again.t:.6g} s: {message}")
    return np.asarray(again.y)


def smooth_segments(t_s: Array, breaks_s: tuple[float, ...]) -> list[tuple[float, float]]:
    """Parts of the walk from break to break; a sample that rounding puts just after a break is where the part ends."""
    slack = TIME_EVENT_TOLERANCE * (t_s[-1] - t_s[0])
    snapped = (t_s[np.searchsorted(t_s, t + slack, side="right") - 1] for t in breaks_s)
    marks = [max(t, at) if at - t <= slack else t for t, at in zip(breaks_s, snapped, strict=True)]
    marks = [t_s[0], *(t for t in sorted(marks) if t_s[0] + slack < t < t_s[-1] - slack), t_s[-1]]
    return [(float(a), float(b)) for a, b in itertools.pairwise(marks) if b - a > slack]


class BodySurface(Protocol):
    """What a walk may run into."""

    def height(self, y: Array) -> float:
        """Least distance of the chain from it, m."""

    def clears_surface(self, before: Array, after: Array, step_s: float) -> bool:
        """Whether nothing between these two states, a step apart, can have touched it."""


class EventHandler(Protocol):
    """What a right-hand side holds fixed while a walk goes on smoothly."""

    detects_events: bool
    """Whether anything may fall"""

    def begin_segment(self, start_s: float, end_s: float, y: Array) -> Array:
        """Settle what holds from a break to the next one; returns the state just after what happens at the break."""

    def find_event(self, dense: Callable[[float], Array], start_s: float, end_s: float) -> float | None:
        """First instant inside a step at which something held must let go, or None."""

    def apply_event(
        self, exact: Callable[[float], Array], t_s: float, step: tuple[float, float]
    ) -> tuple[float, Array]:
        """Hold what is right from about this instant on; returns the instant and the state there, by `exact`."""


@dataclass(frozen=True)
class StepErrorFloor:
    """Least error that a step may be asked for."""

    atol: Array
    """(size,) error asked for"""
    state_roundoff_floor: Callable[[Array], Array] | None
    """As in :func:`integrate`"""

    def apply(self, solver: Solver) -> None:
        """Ask the solver's next step for no less; to be called right after it has evaluated where it stands."""
        if self.state_roundoff_floor is None:
            return
        rough = self.state_roundoff_floor(solver.y)
        kept, floored = self.atol[: -len(rough)], np.maximum(self.atol[-len(rough) :], rough)
        solver.atol = np.concatenate([kept, floored])  # type: ignore[union-attr]  # stubs do not know of it


@dataclass
class StepLog:
    """What has been seen so far."""

    t_s: Array
    """(n,) instants wanted"""
    rows: list[Array]
    """States at the instants reached"""
    floor: StepErrorFloor
    """Of what steps are asked for"""
    steps: int = 0
    evaluations: int = 1
    stopped_s: float | None = None

    def step(self, solver: Solver, surface: BodySurface | None, events: EventHandler | None = None) -> float | None:
        """Take one step, its samples, and the stop if it holds one; returns when a switch falls in it."""
        before = solver.y
        message = solver.step()  # a word only where it failed
        if message or not np.all(np.isfinite(solver.y)):
            name = type(solver).__name__
            raise ArithmeticError(f"{name} gave up at t = {solver.t:.6g} s: {message or 'state not finite'}")
        self.steps += 1
        self.floor.apply(solver)
        dense = cache(solver.dense_output)  # three evaluations, where they are wanted
        detects_events = events is not None and events.detects_events
        fallen_s = events.find_event(dense(), solver.t_old, solver.t) if events and detects_events else None
        if surface and not surface.clears_surface(before, solver.y, solver.t - solver.t_old):
            self.stopped_s = contact_instant(dense(), surface.height, solver.t_old, solver.t, surface.height(before))
            if fallen_s is not None and self.stopped_s is not None and self.stopped_s > fallen_s:
                self.stopped_s = None
        until = next(t for t in (self.stopped_s, fallen_s, solver.t) if t is not None)
        while len(self.rows) < len(self.t_s) and self.t_s[len(self.rows)] <= until:
            t = self.t_s[len(self.rows)]
            self.rows.append(solver.y.copy() if t == solver.t else dense()(t))
        return fallen_s if self.stopped_s is None else None


def contact_instant(
    dense: Callable[[float], Array], height: Callable[[Array], float], start: float, end: float, before: float
) -> float | None:
    """Instant inside a step at which `height` first reaches zero, or None."""
    if before <= 0.0:
        return start

    def at(t: float) -> float:
        return height(dense(t))

    below = end if at(end) <= 0.0 else lowest_instant(at, start, end, before)
    if below is None:
        return None
    found: float = brentq(at, start, below, xtol=1e-9 * max(end - start, 1e-3))
    return found


def lowest_instant(at: Callable[[float], float], start: float, end: float, before: float) -> float | None:
    """Instant inside a step at which `at` is below zero though both ends are above, or None.

    A perigee just under the surface is passed within one step: the parabola through the ends and the
    middle tells whether the lowest point is worth searching for.
    """
    middle, after = at(0.5 * (start + end)), at(end)
    slope, bend = 4.0 * middle - 3.0 * before - after, 2.0 * (before + after - 2.0 * middle)
    if bend <= 0.0 or not 0.0 < -slope < 2.0 * bend:
        return None  # no lowest point between the ends
    if before - slope * slope / (4.0 * bend) > PARABOLA_MARGIN * min(before, after):
        return None
    lowest = minimize_scalar(at, bounds=(start, end), method="bounded", options={"xatol": 1e-9 * (end - start)})
    return float(lowest.x) if lowest.fun <= 0.0 else None
