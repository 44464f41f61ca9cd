"""One run of the oracle: from break to break of the laws, sampled by dense output."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.engine import EngineError, Trajectory
from adapters.heyoka_compiled import Precision, integrator, observe, observer
from adapters.heyoka_structure import (
    LAW_PARAMETERS,
    Numbers,
    parameters_of,
    start_of,
    structure_of,
    units_of,
)

if TYPE_CHECKING:
    from adapters.engine import Array
    from scenarios import Scene


@dataclass(frozen=True)
class Stretch:
    """A piece of a run in which every law is smooth."""

    marks: Numbers
    """(k,) its begin, the instants wanted inside, its end"""
    seen: slice
    """Which of them are wanted, and not the stretch's before"""
    parameters: Numbers
    """Of the equations"""


class Run:
    """A scene in one precision at one tolerance: made, walked, then looked at."""

    def __init__(self, scene: Scene, times_s: Array, precision: Precision, rtol: float) -> None:
        """Compile, or take compiled code from an earlier run, and fill it.

        Parameters
        ----------
        scene : Scene
        times_s : ndarray, shape (n,)
            Increasing instants to be seen, from 0.
        precision : Precision
        rtol : float
            Truncation error allowed in a step, relative to the largest unknown.
        """
        self.scene, self.times_s, self.precision = scene, times_s, precision
        self.structure, self.units, self.number = structure_of(scene), units_of(scene), precision.number
        self.parameters = parameters_of(scene, self.units, self.number)
        self.start = start_of(scene, self.units, self.number)
        self.solver = integrator(self.structure, precision, rtol)
        observer(self.structure, precision)
        self.times = np.array([self.working(float(t)) for t in times_s])
        self.stretches = [self.stretch(*marks) for marks in between(self.times, self.breaks)]
        self.steps = 0
        self.landed: Any = None

    def working(self, t_s: float) -> Any:
        """Time in the working precision and units."""
        return self.number(t_s / self.units.time_s)

    @property
    def breaks(self) -> list[Any]:
        """Instants at which a law starts or ends, in order."""
        laws = self.scene.effects.prescribed_rotation
        return [self.working(t) for t in sorted({t for p in laws for t in p.breaks_s})]

    def stretch(self, begin: Any, end: Any) -> Stretch:
        """What is asked of the integrator between two breaks."""
        inner = self.times[(self.times > begin) & (self.times < end)]
        marks = np.array([begin, *inner, end])
        first = 0 if begin == self.times[0] else 1
        last = len(marks) if np.any(self.times == end) else len(marks) - 1
        return Stretch(marks, slice(first, last), self.law_on(begin, end))

    def law_on(self, begin: Any, end: Any) -> Numbers:
        """Parameters of a stretch: the laws that turn their bars in it have their amplitude."""
        found, middle = self.parameters.copy(), 0.5 * (begin + end)
        for k, p in enumerate(self.scene.effects.prescribed_rotation):
            if self.working(p.breaks_s[0]) < middle < self.working(p.breaks_s[1]):
                found[self.structure.law_offset + LAW_PARAMETERS * k] = self.number(p.amplitude_rad / 16.0)
        return found

    def walk(self) -> None:
        """Integrate from stretch to stretch; no step straddles a break of a law.

        Raises
        ------
        EngineError
            If heyoka stops before the end for any reason but the surface.
        """
        self.rows: list[Numbers] = []
        self.solver.state[:] = self.start
        self.solver.time = self.number(0.0)
        if self.structure.lands:
            self.solver.reset_cooldowns()
        for stretch in self.stretches:
            self.solver.pars[:] = stretch.parameters[: len(self.solver.pars)]
            found = self.solver.propagate_grid(stretch.marks)
            self.steps += int(found[3])
            self.rows.append(found[-1][stretch.seen])
            self.check(found[0], self.rows[-1])
            if self.landed is not None:
                break

    def check(self, outcome: Any, states: Numbers) -> None:
        """Tell a run that went well, one that met the surface, and one that failed."""
        import heyoka as hy

        if outcome == hy.taylor_outcome.time_limit and np.all(np.isfinite(states.astype(float))):
            return
        if self.structure.lands and int(outcome) < 0 and int(outcome) > -len(self.solver.t_events) - 1:
            self.landed = self.solver.time
            return
        at_s = float(self.solver.time) * self.units.time_s
        raise EngineError(f"heyoka gave up at t = {at_s:.6g} s: {str(outcome).rpartition('.')[2]}")

    def trajectory(self) -> Trajectory:
        """What was seen, rounded to double at the very end."""
        states, bars, units = np.concatenate(self.rows), self.structure.bars, self.units
        n, given = (
            len(states),
            [np.tile(s.parameters, (len(r), 1)) for s, r in zip(self.stretches, self.rows, strict=False)],
        )
        seen = observe(self.structure, self.precision, states, self.times[:n], np.concatenate(given)).astype(float)
        y = states.astype(float)
        joints = 2 * (bars - 1)
        landed_s = None if self.landed is None else float(self.landed) * units.time_s
        return Trajectory(
            self.times_s[:n],
            y[:, 0:2] * units.length_m,
            y[:, 2:4] * (units.length_m / units.time_s),
            y[:, 4 : 4 + bars],
            y[:, 4 + bars :] / units.time_s,
            (seen[:, :joints] * units.force).reshape(n, bars - 1, 2),
            torque_N_m=seen[:, joints:] * (units.force * units.length_m),
            ended="" if landed_s is None else f"a bar reached the surface at t = {landed_s:.6f} s",
            info={"steps": self.steps, "evaluations": self.steps * int(self.solver.order)},
        )


def between(times: Numbers, breaks: list[Any]) -> list[tuple[Any, Any]]:
    """Begin and end of each piece of the run between breaks."""
    marks = [times[0], *(t for t in breaks if times[0] < t < times[-1]), times[-1]]
    return list(itertools.pairwise(marks))
