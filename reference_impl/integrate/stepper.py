"""Integration by SciPy's solvers step by step: samples by dense output, time and state events, projection, contact."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from scipy.integrate import DOP853

from reference_impl.integrate.stiffness import RTOL_FLOOR
from reference_impl.integrate.surface_contact import contact_instant

if TYPE_CHECKING:
    from collections.abc import Callable

    from reference_impl.integrate.stiffness import Method, Solver
    from reference_impl.integrate.surface_contact import BodySurface
    from reference_impl.model.arrays import Array

TIME_EVENT_TOLERANCE = 1e-12  # of the duration: breaks nearer than this to each other or to the ends coincide


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
    longest_step_s: float = np.inf,
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
    longest_step_s : float, optional
    state_roundoff_floor : callable, optional
        Maps a state to the round-off error of its trailing components (rates), using quantities cached by the latest
        `rhs`; the tolerance of those components is raised to it. Explicit methods only.

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
    run, y = (
        SampledRun(t_s, [np.array(y0)], StepErrorFloor(atol, state_roundoff_floor if method is DOP853 else None)),
        np.array(y0),
    )
    for start, end in smooth_segments(t_s, breaks_s):
        t = start
        if events:
            y = events.begin_segment(start, end, y)
        while t < end and run.stopped_s is None:
            limits = {"rtol": RTOL_FLOOR, "atol": atol, "max_step": longest_step_s}
            solver = method(rhs, t, y, end, **limits)  # type: ignore[arg-type]  # stubs accept scalars only
            t, y = integrate_segment(solver, run, project, surface, events)
            run.evaluations += solver.nfev
        if run.stopped_s is not None:
            break
    return Integration(t_s[: len(run.rows)], np.array(run.rows), run.steps, run.evaluations, run.stopped_s)


def integrate_segment(
    solver: Solver,
    run: SampledRun,
    project: Callable[[Array], Array] | None,
    surface: BodySurface | None,
    events: EventHandler | None,
) -> tuple[float, Array]:
    """Step to the end of the segment, to contact, or to a state event; return instant and state."""
    run.floor.apply(solver)
    while solver.status == "running" and run.stopped_s is None:
        event_s = run.step(solver, surface, events)
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


class EventHandler(Protocol):
    """Discrete modes of a right-hand side, and the events at which they change."""

    detects_events: bool
    """Whether any state event is possible"""

    def begin_segment(self, start_s: float, end_s: float, y: Array) -> Array:
        """Set the modes from a known instant to the next; return the state just after the events at the first."""

    def find_event(self, dense: Callable[[float], Array], start_s: float, end_s: float) -> float | None:
        """First instant inside a step at which a mode ends, or None."""

    def apply_event(
        self, state_at: Callable[[float], Array], t_s: float, step: tuple[float, float]
    ) -> tuple[float, Array]:
        """Set the modes valid after about this instant; return the instant and the state there, by `state_at`."""


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
        floor = self.state_roundoff_floor(solver.y)
        kept, floored = self.atol[: -len(floor)], np.maximum(self.atol[-len(floor) :], floor)
        solver.atol = np.concatenate([kept, floored])  # type: ignore[union-attr]  # missing in the stubs


@dataclass
class SampledRun:
    """Integration in progress: takes steps, and keeps the samples reached and the counts."""

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
        reached = len(self.rows)
        inside = self.t_s[reached : np.searchsorted(self.t_s, until, side="right")]
        ends = bool(len(inside)) and inside[-1] == solver.t
        between = inside[:-1] if ends else inside
        if len(between) == 1:
            self.rows.append(dense()(between[0]))
        elif len(between):
            self.rows.extend(dense()(between).T)  # together: a call takes as long as for one
        if ends:
            self.rows.append(solver.y.copy())
        return event_s if self.stopped_s is None else None
