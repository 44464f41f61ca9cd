"""Discrete modes of a run: constant between the events of a model's effects; impulses at their instants."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from reference_impl.model.complex_vectors import unit_along
from reference_impl.model.effect import EffectState

if TYPE_CHECKING:
    from collections.abc import Callable

    from reference_impl.integrate.coordinate_sets import StateCoordinates
    from reference_impl.model.arrays import Array
    from reference_impl.model.effect import ChainEffect, Indices, Modes

EVENT_SAMPLES = (0.25, 0.5, 0.75, 1.0)  # of a step: sampling of event functions with two zeros in one step
EVENT_TOLERANCE = 1e-12  # of a step, of an event time; the state is as accurate as its interpolant
SECANT_SPAN = 1e-4  # of a step, for the slope of an event function
SECANT_ITERATIONS = 5  # two suffice: the interpolant's error is 1e-7 of a step or less
SHORT_MODE_TOLERANCE = 1e-6  # of the time between two samples; any instant within a short mode suffices
SAME_INSTANT = 1e-12  # of the run: an impulse nearer than this to an event occurs at that event


class DiscreteModes:
    """Modes of a model's effects along one run, in one set of coordinates."""

    def __init__(
        self,
        coordinates: StateCoordinates,
        end_s: float,
        *,
        detects_events: bool = True,
        most_events: float = math.inf,
    ) -> None:
        """Prepare a run.

        Parameters
        ----------
        coordinates : StateCoordinates
        end_s : float
            End of the run.
        detects_events : bool
            Whether the stepper locates state events; otherwise modes with such events follow from the state at all
            times.
        most_events : float
            Number of state events after which a run gives up.
        """
        self.coordinates, self.model = coordinates, coordinates.model
        self.events, self.most_events = 0, most_events
        self.detects_events = detects_events and any(effect.has_state_events for effect in self.model.effects)
        self.slack_s = SAME_INSTANT * end_s
        self.pending = sorted(self.model.impulses, key=lambda impulse: impulse.at_s)
        self.impulsive_reactions: list[tuple[float, Array]] = []
        """Instants, and impulsive reactions (N-1, 2) there, so far"""
        self.crossed: set[int] = set()
        """Indices of the event functions that crossed zero at the last event"""

    @property
    def modes(self) -> Modes | None:
        """Current modes of the right-hand side."""
        return self.coordinates.modes

    def begin_segment(self, start_s: float, end_s: float, y: Array) -> Array:
        """Apply the impulses at this instant, and set the modes until `end_s`."""
        due = [impulse for impulse in self.pending if impulse.at_s <= start_s + self.slack_s]
        self.pending = self.pending[len(due) :]
        if due:
            from reference_impl.effects.impulse import apply_impulses  # noqa: PLC0415  # only for impulses

            state, reaction = apply_impulses(self.model, self.coordinates.unpack(y), due)
            self.impulsive_reactions.append((due[0].at_s, reaction))
            y = self.coordinates.pack(state)
        self.set_modes(start_s, end_s, y)
        return y

    def set_modes(self, start_s: float, end_s: float, y: Array) -> None:
        """Set the modes: by time for modes that depend on time alone, otherwise by the state at the start."""
        at = self.effect_state(start_s, y)

        def held(effect: ChainEffect) -> Array | None:
            if effect.has_state_events:
                return effect.mode(at) if self.detects_events else None
            return effect.segment_mode(start_s, end_s)

        self.coordinates.modes = tuple(held(effect) for effect in self.model.effects)

    def effect_state(self, t_s: float, y: Array) -> EffectState:
        """State of a vector as input of the effects."""
        state = self.coordinates.unpack(y)
        return EffectState(self.model, t_s, state, unit_along(state.angle_rad))

    def event_functions(self, t_s: float, y: Array) -> Array:
        """All event functions at a vector, positive while the current modes are valid."""
        at, held = self.effect_state(t_s, y), self.modes or ()
        found = [
            e.event_functions(at, m)
            for e, m in zip(self.model.effects, held, strict=True)
            if m is not None and e.has_state_events
        ]
        return np.concatenate([*found, np.ones(1)])

    def margin(self, t_s: float, y: Array) -> float:
        """Least of the event functions."""
        return float(self.event_functions(t_s, y).min())

    def change(self, t_s: float, y: Array) -> None:
        """Change the modes whose event functions are least, or negative, at an event that a general solver located."""
        now = self.event_functions(t_s, y)
        self.crossed = {int(now.argmin()), *map(int, np.nonzero(now < 0.0)[0])}
        self.change_modes(t_s, y)

    def find_event(self, dense: Callable[[float], Array], start_s: float, end_s: float) -> float | None:
        """First instant in a step at which an event function is negative, sampled in quarters of the step."""
        before, low = start_s, self.event_functions(start_s, dense(start_s))
        for share in EVENT_SAMPLES:
            end = start_s + share * (end_s - start_s)
            for t in (*self.short_mode_instants(dense, before, end), end):
                now = self.event_functions(t, dense(t))
                if np.any(now < 0.0):
                    return self.first_crossing(dense, before, t, low, np.nonzero(now < 0.0)[0])
                before, low = t, now
        return None

    def first_crossing(
        self, dense: Callable[[float], Array], start_s: float, end_s: float, low: Array, below: Indices
    ) -> float:
        """Instant of the first zero among the event functions `below`; `low` are all event functions at the start."""
        instants = {int(k): self.crossing_instant(dense, int(k), start_s, end_s, float(low[k])) for k in below}
        earliest = min(instants.values())
        self.crossed = {k for k, t in instants.items() if t == earliest}
        return earliest

    def short_mode_instants(self, dense: Callable[[float], Array], start_s: float, end_s: float) -> list[float]:
        """Instants between two samples inside modes that may have begun and ended there, increasing."""
        found = []
        for effect in self.model.effects:
            if effect.has_short_modes and self.detects_events:

                def side(t: float, effect: ChainEffect = effect) -> float:
                    return effect.short_mode_indicator(self.effect_state(t, dense(t)))

                if side(start_s) * side(end_s) < 0.0:
                    found.append(float(brentq(side, start_s, end_s, xtol=SHORT_MODE_TOLERANCE * (end_s - start_s))))
        return sorted(found)

    def crossing_instant(
        self, dense: Callable[[float], Array], k: int, start_s: float, end_s: float, before: float
    ) -> float:
        """Instant at which event function `k` is zero or just below."""
        if before <= 0.0:
            return start_s

        def margin(t: float) -> float:
            return float(self.event_functions(t, dense(t))[k])

        slack = EVENT_TOLERANCE * (end_s - start_s)
        found: float = brentq(margin, start_s, end_s, xtol=slack)
        return min(found + 2.0 * slack, end_s)

    def apply_event(
        self, state_at: Callable[[float], Array], t_s: float, step: tuple[float, float]
    ) -> tuple[float, Array]:
        """Change the modes whose event functions crossed zero in :meth:`find_event`; return event time and state.

        The signs at the event do not decide which modes change: an angle of a few radians is known to 1e-16, and the
        root may lie on either side. An unchanged mode would end again at the same instant, and the run would never
        proceed.

        Parameters
        ----------
        state_at : callable
            State at an instant of the step, by the method itself.
        t_s : float
            Event time by the step's interpolant.
        step : tuple of float
            Start and end of the step.

        Raises
        ------
        ArithmeticError
            If the run has met more events than it may.
        """
        self.events += 1
        if self.events > self.most_events:
            raise ArithmeticError(f"more than {self.most_events:g} events at t = {t_s:.6g} s")
        t_s, y = self.refine_event(state_at, t_s, step)
        self.change_modes(t_s, y)
        return t_s, y

    def change_modes(self, t_s: float, y: Array) -> None:
        """Change the modes whose event functions are in `crossed`."""
        at, modes, offset = self.effect_state(t_s, y), list(self.modes or ()), 0
        for i, (effect, mode) in enumerate(zip(self.model.effects, modes, strict=True)):
            if mode is not None and effect.has_state_events:
                count = len(effect.event_functions(at, mode))
                crossed = np.array([k - offset for k in sorted(self.crossed) if 0 <= k - offset < count], np.intp)
                modes[i] = effect.mode_after(mode, crossed) if len(crossed) else mode
                offset += count
        self.coordinates.modes = tuple(modes)

    def refine_event(
        self, state_at: Callable[[float], Array], t_s: float, step: tuple[float, float]
    ) -> tuple[float, Array]:
        """Event time near `t_s` by the method's own states, by the secant method; the state there.

        At the returned time, the crossing event functions are zero or just below. Where an event function only touches
        zero, its slope is round-off, and the secant method may diverge. An iterate outside the step, or an event
        function without a descent, gives the interpolant's instant, which is as accurate as any neighbouring instant.
        """
        fallen, (start_s, end_s) = sorted(self.crossed), step
        slack_s = EVENT_TOLERANCE * (end_s - start_s)

        def margin(t: float) -> tuple[float, Array]:
            y = state_at(t)
            return float(self.event_functions(t, y)[fallen].max()), y

        aside_s = max(t_s - SECANT_SPAN * (end_s - start_s), start_s)
        (before, _), (now, y) = margin(aside_s), margin(t_s)
        slope, found_s, found = (now - before) / (t_s - aside_s) if t_s > aside_s else 0.0, t_s, y
        for _ in range(SECANT_ITERATIONS):
            if not slope < 0.0 or -slack_s * slope >= -now >= 0.0:
                break
            found_s -= (now - 0.5 * slack_s * slope) / slope
            if not start_s <= found_s <= end_s:
                return t_s, y
            now, found = margin(found_s)
        return found_s, found

    def impulse_sums(self, t_s: Array) -> Array | None:
        """Sum of the impulsive reactions before each sample, (n, N-1, 2) N s; None for a model without impulses."""
        if not self.model.impulses:
            return None
        total = np.zeros((len(t_s), self.model.bars - 1, 2))
        for at_s, reaction in self.impulsive_reactions:
            total[t_s > at_s + self.slack_s] += reaction
        return total
