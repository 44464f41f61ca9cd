"""Integration by SciPy's solvers step by step: samples by dense output, time and state events, projection, contact."""

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

TIME_EVENT_TOLERANCE = 1e-12  # of the duration: breaks nearer than this to each other or to the ends coincide
PARABOLA_MARGIN = 0.5  # of the lower end's height: a parabola below this starts a search


@dataclass(frozen=True)
class Integration:
    """Samples and statistics of an integration."""

    t_s: Array
    """(n,) sample instants reached"""
    y: Array
    """(n, size)"""
    steps: int
    evaluations: int
    stopped_s: float | None
    """Instant of the terminal event; None if the integration reached its end"""


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
    """Integrate ``y' = rhs(t, y)`` from ``t_s[0]`` and sample the solution.

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
        Projection of the state after every step.
    surface : BodySurface, optional
        Surface of the body; the integration stops at contact.
    events : EventHandler, optional
        Handler of the discrete modes, which keep `rhs` smooth between events.
    method : type
        SciPy's solver class.
    state_roundoff_floor : callable, optional
        Round-off error of the last components of a state, by the last evaluation of `rhs`. No explicit step requests
        less.

    Returns
    -------
    Integration

    Raises
    ------
    ArithmeticError
        If the step size collapses, or the state or its rate is not finite.
    """
    if not np.all(np.isfinite([y0, rhs(t_s[0], y0)])):
        raise ArithmeticError(
            "the initial state or its rate is not finite"
        )  # SciPy's search for a first step would not end
    log, y = (
        StepLog(t_s, [np.array(y0)], StepErrorFloor(atol, state_roundoff_floor if method is DOP853 else None)),
        np.array(y0),
    )
    for start, end in smooth_segments(t_s, breaks_s):
        here = start
        if events:
            y = events.begin_segment(start, end, y)
        while here < end and log.stopped_s is None:
            solver = method(rhs, here, y, end, rtol=RTOL_FLOOR, atol=atol)  # type: ignore[arg-type]  # stubs accept scalars only
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
    """Step to the end of the segment, to contact, or to a state event; return instant and state."""
    log.floor.apply(solver)
    while solver.status == "running" and log.stopped_s is None:
        event_s = log.step(solver, surface, events)
        if event_s is not None and events:
            return events.apply_event(lambda t: partial_step(solver, t), event_s, (solver.t_old, solver.t))
        if project:
            solver.y = project(solver.y)
            solver.f = solver.fun(solver.t, solver.y)
    return float(solver.t), np.asarray(solver.y)


def partial_step(solver: Solver, until_s: float) -> Array:
    """State at an instant inside the last step, by a shorter step.

    The error is about a hundredth of the interpolant's.
    """
    step: Any = solver  # stubs lack its tolerances and its earlier state
    span = until_s - step.t_old
    if span == 0.0:
        return np.asarray(step.y_old)
    again = type(step)(step.fun, step.t_old, step.y_old, until_s, first_step=span, rtol=RTOL_FLOOR, atol=step.atol)
    while again.status == "running":
        message = again.step()
        if message:
            raise ArithmeticError(f"{type(again).__name__} failed at t = {again.t:.6g} s: {message}")
    return np.asarray(again.y)


def smooth_segments(t_s: Array, breaks_s: tuple[float, ...]) -> list[tuple[float, float]]:
    """Segments of the integration between known instants.

    A sample that rounding puts just after a known instant ends the segment.
    """
    slack = TIME_EVENT_TOLERANCE * (t_s[-1] - t_s[0])
    snapped = (t_s[np.searchsorted(t_s, t + slack, side="right") - 1] for t in breaks_s)
    marks = [max(t, at) if at - t <= slack else t for t, at in zip(breaks_s, snapped, strict=True)]
    marks = [t_s[0], *(t for t in sorted(marks) if t_s[0] + slack < t < t_s[-1] - slack), t_s[-1]]
    return [(float(a), float(b)) for a, b in itertools.pairwise(marks) if b - a > slack]


class BodySurface(Protocol):
    """Surface that a chain may touch."""

    def height(self, y: Array) -> float:
        """Smallest distance of the chain from the surface, m."""

    def clears_surface(self, before: Array, after: Array, step_s: float) -> bool:
        """Whether contact is impossible in the step between these two states."""


class EventHandler(Protocol):
    """Discrete modes of a right-hand side, and the events at which they change."""

    detects_events: bool
    """Whether any state event is possible"""

    def begin_segment(self, start_s: float, end_s: float, y: Array) -> Array:
        """Set the modes from a known instant to the next; return the state just after the events at the first."""

    def find_event(self, dense: Callable[[float], Array], start_s: float, end_s: float) -> float | None:
        """First instant inside a step at which a mode ends, or None."""

    def apply_event(
        self, exact: Callable[[float], Array], t_s: float, step: tuple[float, float]
    ) -> tuple[float, Array]:
        """Set the modes valid after about this instant; return the instant and the state there, by `exact`."""


@dataclass(frozen=True)
class StepErrorFloor:
    """Smallest error that a step may request."""

    atol: Array
    """(size,) requested error"""
    state_roundoff_floor: Callable[[Array], Array] | None
    """As in :func:`integrate`"""

    def apply(self, solver: Solver) -> None:
        """Raise the solver's tolerance for its next step to the floor.

        Call this method after an evaluation at the solver's state.
        """
        if self.state_roundoff_floor is None:
            return
        rough = self.state_roundoff_floor(solver.y)
        kept, floored = self.atol[: -len(rough)], np.maximum(self.atol[-len(rough) :], rough)
        solver.atol = np.concatenate([kept, floored])  # type: ignore[union-attr]  # missing in the stubs


@dataclass
class StepLog:
    """Progress of an integration."""

    t_s: Array
    """(n,) requested sample instants"""
    rows: list[Array]
    """States at the sample instants reached"""
    floor: StepErrorFloor
    """Smallest error that steps request"""
    steps: int = 0
    evaluations: int = 1
    stopped_s: float | None = None

    def step(self, solver: Solver, surface: BodySurface | None, events: EventHandler | None = None) -> float | None:
        """Take one step with its samples, and stop at contact.

        Returns the instant of a state event in the step, or None.
        """
        before = solver.y
        message = solver.step()  # None on success
        if message or not np.all(np.isfinite(solver.y)):
            name = type(solver).__name__
            raise ArithmeticError(f"{name} failed at t = {solver.t:.6g} s: {message or 'state not finite'}")
        self.steps += 1
        self.floor.apply(solver)
        dense = cache(solver.dense_output)  # three evaluations, on demand
        detects_events = events is not None and events.detects_events
        event_s = events.find_event(dense(), solver.t_old, solver.t) if events and detects_events else None
        if surface and not surface.clears_surface(before, solver.y, solver.t - solver.t_old):
            self.stopped_s = contact_instant(dense(), surface.height, solver.t_old, solver.t, surface.height(before))
            if event_s is not None and self.stopped_s is not None and self.stopped_s > event_s:
                self.stopped_s = None
        until = next(t for t in (self.stopped_s, event_s, solver.t) if t is not None)
        while len(self.rows) < len(self.t_s) and self.t_s[len(self.rows)] <= until:
            t = self.t_s[len(self.rows)]
            self.rows.append(solver.y.copy() if t == solver.t else dense()(t))
        return event_s if self.stopped_s is None else None


def contact_instant(
    dense: Callable[[float], Array], height: Callable[[Array], float], start: float, end: float, before: float
) -> float | None:
    """First instant inside a step at which `height` reaches zero, or None."""
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
    """Instant inside a step at which `at` is below zero though positive at both ends, or None.

    One step may pass a perigee just below the surface. The parabola through both ends and the middle decides whether to
    search for the lowest point.
    """
    middle, after = at(0.5 * (start + end)), at(end)
    slope, bend = 4.0 * middle - 3.0 * before - after, 2.0 * (before + after - 2.0 * middle)
    if bend <= 0.0 or not 0.0 < -slope < 2.0 * bend:
        return None  # no lowest point between the ends
    if before - slope * slope / (4.0 * bend) > PARABOLA_MARGIN * min(before, after):
        return None
    lowest = minimize_scalar(at, bounds=(start, end), method="bounded", options={"xatol": 1e-9 * (end - start)})
    return float(lowest.x) if lowest.fun <= 0.0 else None
