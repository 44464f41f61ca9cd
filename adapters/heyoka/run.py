"""One run of heyoka: from event to event of the loads, sampled by dense output."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.common.landing import landing_text
from adapters.engine import EngineError
from adapters.heyoka.compiled import Precision, function, observe, value
from adapters.heyoka.events import Modes, integrator
from adapters.heyoka.structure import (
    Numbers,
    impulse_size,
    parameters_of,
    segments_of,
    start_of,
    structure_of,
    turns_of,
    units_of,
)
from adapters.trajectory import ENDED, Trajectory

MOST_MODE_CHANGES = 100_000  # in one segment

if TYPE_CHECKING:
    from adapters.trajectory import Array
    from scenarios import Scene


@dataclass(frozen=True)
class TimeSegment:
    """A part of a run in which laws and thrusts are smooth in time."""

    marks: Numbers
    """(k,) its start, the samples inside, its end"""
    seen: slice
    """Marks that are samples of this segment, not of the previous one"""
    parameters: Numbers
    """Parameters of the equations"""


@dataclass(frozen=True)
class SegmentStates:
    """Samples of a segment."""

    states: Numbers
    """(k, size)"""
    given: Numbers
    """(k, m) parameters at each sample"""
    impulse_sum: Numbers
    """(k, 2 (N - 1)) sum of the impulsive reactions so far"""


class HeyokaRun:
    """A scene in one precision at one tolerance: build, :meth:`walk`, then :meth:`trajectory`."""

    def __init__(self, scene: Scene, times_s: Array, precision: Precision, rtol: float) -> None:
        """Compile, or reuse compiled code of an earlier run, and set the parameters.

        Parameters
        ----------
        scene : Scene
        times_s : ndarray, shape (n,)
            Increasing instants of the samples, from 0.
        precision : Precision
        rtol : float
            Truncation error of a step relative to the largest unknown.
        """
        self.scene, self.times_s, self.precision = scene, times_s, precision
        self.structure, self.units, self.number = structure_of(scene), units_of(scene), precision.number
        self.parameters = parameters_of(scene, self.units, self.number)
        self.start = start_of(scene, self.units, self.number)
        self.solver = integrator(self.structure, precision, rtol)
        self.events = self.solver.t_events if self.structure.lands or self.structure.modes else []
        self.modes = Modes(self.structure, precision)
        function(self.structure, precision, "observables")
        if self.structure.impulses:
            function(self.structure, precision, "jumps")
        self.times = np.array([self.scaled_time(float(t)) for t in times_s])
        self.segments = [self.segment(*marks) for marks in event_free_intervals(self.times, self.breaks)]
        self.rows: list[SegmentStates] = []
        self.mode_changes_s: list[float] = []  # instants at which a mode changed
        self.impulse_sum = np.array([self.number(0.0)] * (2 * (self.structure.bars - 1)))
        self.steps = 0
        self.landed: Any = None

    def perturb_start(self, size: str) -> None:
        """Perturb angles, and rates relative to the fastest initial one, by a decimal number; signs differ by bar."""
        scene, bars, moved = self.scene, self.structure.bars, self.number(size)
        fastest = scene.orbital_rate_rad_s * max(1.0, *(abs(a) for a in scene.chain.rate_factor)) * self.units.time_s
        for j in range(bars):
            self.start[4 + j] += moved * (-1) ** j
            self.start[4 + bars + j] += moved * fastest * (-1) ** (j // 2)

    def scaled_time(self, t_s: float) -> Any:
        """Time in the working precision and units."""
        return self.number(t_s / self.units.time_s)

    @property
    def breaks(self) -> list[Any]:
        """Instants of events known beforehand: ends of laws, corners of tables in time, impulses; in order."""
        return [self.scaled_time(t) for t in self.scene.effects.breaks_s]

    def segment(self, begin: Any, end: Any) -> TimeSegment:
        """Samples and parameters between two events."""
        inner = self.times[(self.times > begin) & (self.times < end)]
        marks = np.array([begin, *inner, end])
        first = 0 if begin == self.times[0] else 1
        last = len(marks) if np.any(self.times == end) else len(marks) - 1
        return TimeSegment(marks, slice(first, last), self.parameters_on(begin, end))

    def parameters_on(self, begin: Any, end: Any) -> Numbers:
        """Parameters of a segment: amplitudes of the laws that act in it, and straight segments of tables in time."""
        found, middle = self.parameters.copy(), 0.5 * (begin + end)
        middle_s = float(middle) * self.units.time_s
        for parts in (turns_of, segments_of):
            for name, number in parts(self.scene, middle_s, self.units, self.number):
                found[self.structure.slots[name]] = number
        return found

    def walk(self) -> None:
        """Integrate segment by segment; no step straddles an event known beforehand.

        Raises
        ------
        EngineError
            If heyoka stops before the end, other than at the surface.
        """
        self.solver.state[:] = self.start
        self.solver.time = self.number(0.0)
        current = self.fresh_modes(self.segments[0].parameters)
        for segment in self.segments:
            current = self.apply_impulses(segment.marks[0], self.with_modes_of(segment.parameters, current))
            current = self.integrate_segment(segment, current)
            if self.landed is not None:
                break

    def fresh_modes(self, parameters: Numbers) -> Numbers:
        """Parameters with the modes of the solver's state; cooldowns of events are reset."""
        found = parameters.copy()
        self.modes.set(self.solver.state, self.solver.time, found)
        if len(self.events):
            self.solver.reset_cooldowns()
        return found

    def with_modes_of(self, parameters: Numbers, before: Numbers) -> Numbers:
        """Parameters of a segment with the modes at the end of the previous one."""
        found = parameters.copy()
        found[self.modes.slots] = before[self.modes.slots]
        return found

    def apply_impulses(self, at: Any, parameters: Numbers) -> Numbers:
        """Apply the impulses at an instant; return the parameters of the next segment."""
        impulses = {k: p for k, p in enumerate(self.scene.effects.impulse) if self.scaled_time(p.at_s) == at}
        if not impulses:
            return parameters
        given = parameters.copy()
        for k, impulse in impulses.items():
            given[self.structure.slots[f"impulse_{k}_size"]] = impulse_size(impulse, self.units, self.number)
        bars, jumps = self.structure.bars, function(self.structure, self.precision, "jumps")
        jump = value(jumps, self.solver.state, at, given)
        self.solver.state[2:4] += jump[:2]
        self.solver.state[4 + bars :] += jump[2 : 2 + bars]
        self.impulse_sum = self.impulse_sum + jump[2 + bars :]
        return self.fresh_modes(parameters)

    def integrate_segment(self, segment: TimeSegment, parameters: Numbers) -> Numbers:
        """Integrate a segment from mode change to mode change; return the parameters at its end."""
        marks = segment.marks
        states: list[Numbers] = []
        given: list[Numbers] = []
        for _ in range(MOST_MODE_CHANGES):
            self.solver.pars[:] = parameters[: len(self.solver.pars)]
            found = self.solver.propagate_grid(marks)
            self.steps += int(found[3])
            new = found[-1][1:] if states else found[-1]  # after a mode change the first row is the event itself
            states.append(new)
            given.append(np.tile(parameters, (len(new), 1)))
            self.check_outcome(found[0], new)
            left = marks[len(found[-1]) :]
            parameters = self.with_modes_after_event(parameters)
            if found[0] == heyoka_outcomes().time_limit or self.landed is not None or not len(left):
                self.store(np.concatenate(states)[segment.seen], np.concatenate(given)[segment.seen])
                return parameters
            self.mode_changes_s.append(float(self.solver.time) * self.units.time_s)
            marks = np.array([self.solver.time, *left])
        raise EngineError(f"heyoka: more than {MOST_MODE_CHANGES} mode changes in one segment: a bar stays edge-on")

    def store(self, states: Numbers, given: Numbers) -> None:
        """Store the samples of a segment."""
        self.rows.append(SegmentStates(states, given, np.tile(self.impulse_sum, (len(states), 1))))

    def with_modes_after_event(self, parameters: Numbers) -> Numbers:
        """Parameters with the modes that events set."""
        found, slots = parameters.copy(), [s for s in self.modes.slots if s < len(self.solver.pars)]
        found[slots] = self.solver.pars[slots]
        return found

    def check_outcome(self, outcome: Any, states: Numbers) -> None:
        """Accept a run to its end or to a mode change, record one at the surface, and reject a failure."""
        event = -1 - int(outcome)
        well = outcome == heyoka_outcomes().time_limit or self.structure.surfaces <= event < len(self.events)
        if well and np.all(np.isfinite(states.astype(float))):
            return
        if 0 <= event < self.structure.surfaces:
            self.landed = self.solver.time
            return
        at_s = float(self.solver.time) * self.units.time_s
        raise EngineError(f"heyoka stopped at t = {at_s:.6g} s: {str(outcome).rpartition('.')[2]}")

    def trajectory(self, *, beyond: bool = False) -> Trajectory:
        """Samples, rounded to double at the very end; or what that rounding takes from them, for `beyond`."""

        def rounded(values: Numbers) -> Array:
            near: Array = values.astype(float)
            return (values - near).astype(float) if beyond else near

        states, given, impulse_sum = (
            np.concatenate([getattr(r, x) for r in self.rows]) for x in ("states", "given", "impulse_sum")
        )
        n, bars, units = len(states), self.structure.bars, self.units
        seen = rounded(observe(self.structure, self.precision, states, self.times[:n], given))
        y = rounded(states)
        joints = 2 * (bars - 1)
        landed_s = None if self.landed is None else float(self.landed) * units.time_s
        info: dict[str, float | str] = {"steps": self.steps, "evaluations": self.steps * int(self.solver.order)}
        if landed_s is not None:
            info[ENDED] = landed_s
        impulse = (rounded(impulse_sum) * (units.force * units.time_s)).reshape(n, bars - 1, 2)
        return Trajectory(
            self.times_s[:n],
            y[:, 0:2] * units.length_m,
            y[:, 2:4] * (units.length_m / units.time_s),
            y[:, 4 : 4 + bars],
            y[:, 4 + bars :] / units.time_s,
            (seen[:, :joints] * units.force).reshape(n, bars - 1, 2),
            torque_N_m=seen[:, joints:] * (units.force * units.length_m),
            impulse_N_s=impulse if self.structure.impulses else None,
            ended=landing_text(landed_s),
            info=info,
        )


def heyoka_outcomes() -> Any:
    """Outcomes of heyoka's runs."""
    import heyoka as hy

    return hy.taylor_outcome


def event_free_intervals(times: Numbers, breaks: list[Any]) -> list[tuple[Any, Any]]:
    """Start and end of each interval between events."""
    marks = [times[0], *(t for t in breaks if times[0] < t < times[-1]), times[-1]]
    return list(itertools.pairwise(marks))
