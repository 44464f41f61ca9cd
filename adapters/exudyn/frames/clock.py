"""Orbital quantities inside Exudyn's symbolic loads.

Kepler's equation has no closed solution. Exudyn evaluates a symbolic expression once for each occurrence, so that the
cost of an unrolled Newton iteration would triple with every iteration. The exact orbit is therefore tabulated when the
model is built, see :mod:`adapters.exudyn.timetable`.
"""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.exudyn.frames.numbers import OrbitNumbers
from adapters.exudyn.timetable import Steps, Timetable, tabulated

if TYPE_CHECKING:
    from adapters.exudyn.frames.orbit import KeplerOrbit
    from adapters.exudyn.timetable import TimeInputs
    from adapters.trajectory import Array

INSIDE_DEGREE = 7  # (h n/4)^8/8! of a number's own size: below 1e-13 at 50 steps per orbit, round-off at 400
NAMES = tuple(f.name for f in fields(OrbitNumbers))


class Clock:
    """Symbolic orbital quantities; constants on a circular orbit."""

    def __init__(self, orbit: KeplerOrbit, steps: Steps, *, degree: int) -> None:
        """Tabulate `orbit` as polynomials of `degree` over each of `steps`."""
        time_inputs = orbit_inputs(orbit)
        self.first = time_inputs(np.zeros(1), np.zeros(1))[0].tolist()
        self.table = None if orbit.circular else Timetable(time_inputs, len(NAMES), steps, degree=degree)

    def numbers(self, t_s: Any) -> OrbitNumbers:
        """Orbital quantities as functions of the symbolic time `t_s`, also inside a step."""
        return OrbitNumbers(*(self.first if self.table is None else self.table.symbols(t_s)))


def orbit_inputs(orbit: KeplerOrbit) -> TimeInputs:
    """Orbital quantities as functions of time."""

    def time_inputs(at_s: Array, _inside_s: Array) -> Array:
        track = orbit.at(at_s)
        return np.stack([getattr(track, name) for name in NAMES], axis=1)

    return time_inputs


def coefficients(orbit: KeplerOrbit, steps: Steps, degree: int) -> Array:
    """Polynomials of the orbital quantities, (count + 1, 5 (degree + 1)), see :func:`tabulated`."""
    return tabulated(orbit_inputs(orbit), steps, degree)
