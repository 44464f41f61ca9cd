"""The orbit's numbers inside Exudyn's symbolic loads, renewed before every step.

Kepler's equation has no closed solution, and Exudyn evaluates a symbolic expression once for each place
it stands in, so an unrolled Newton iteration would grow threefold with every sweep. Instead the exact
orbit is tabulated when the model is built. An implicit method evaluates its loads at the end of the
step only, so there the table is exact; an explicit one also evaluates them inside, where each number is
a polynomial in the step's own time.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.exudyn_loads import OrbitNumbers

if TYPE_CHECKING:
    from adapters.engine import Array
    from adapters.exudyn_orbit import KeplerOrbit

INSIDE_DEGREE = 7  # (h n/4)^8/8! of a number's own size: below 1e-13 at 50 steps per orbit, round-off at 400
NAMES = tuple(f.name for f in fields(OrbitNumbers))


@dataclass(frozen=True)
class Steps:
    """Equal steps from 0."""

    size_s: float
    count: int

    @property
    def ends_s(self) -> Array:
        """Instants 0, h, 2h, ..., shape (count + 1,)."""
        ends: Array = self.size_s * np.arange(self.count + 1, dtype=np.float64)
        return ends

    def index(self, t_s: float) -> int:
        """Step that ends at `t_s`, which Exudyn sums up with round-off."""
        return round(t_s / self.size_s)


class Clock:
    """Symbolic numbers of the orbit, and the function that keeps them up to date."""

    def __init__(self, orbit: KeplerOrbit, steps: Steps, *, degree: int) -> None:
        """Tabulate `orbit` as polynomials of `degree` over each of `steps`; constants if it is circular."""
        self.steps = steps
        self.constant = orbit.circular
        self.degree = 0 if self.constant else degree
        self.table = [] if self.constant else coefficients(orbit, steps, self.degree).tolist()
        self.first = coefficients(orbit, Steps(steps.size_s, 0), 0)[0].tolist()

    def numbers(self, t_s: Any) -> OrbitNumbers:
        """Orbit's numbers as functions of the symbolic time `t_s`, also inside a step."""
        if self.constant:
            return OrbitNumbers(*self.first)
        return OrbitNumbers(*(self._polynomial(i, t_s) for i in range(len(NAMES))))

    def start(self, symbolic: Any) -> None:
        """Make the symbolic numbers, with their values at t = 0."""
        width = len(NAMES) * (self.degree + 1)
        self.values = [symbolic.Real(f"orbit{i}", 0.0) for i in range(width)]
        self.end = symbolic.Real("stepEnd", 0.0)
        self._set(0, 0.0)

    def tick(self, _mbs: object, t_s: float) -> bool:
        """Before each step: Exudyn's preStepUserFunction, which gets the step's end."""
        self._set(self.steps.index(t_s), t_s)
        return True

    def _set(self, index: int, end_s: float) -> None:
        if self.constant:
            return
        self.end.SetValue(end_s)
        for value, number in zip(self.values, self.table[index], strict=True):
            value.SetValue(number)

    def _polynomial(self, which: int, t_s: Any) -> Any:
        """Horner's rule in s = 2 (t - end)/h + 1."""
        own = self.values[which * (self.degree + 1) : (which + 1) * (self.degree + 1)]
        total = own[-1]
        for value in reversed(own[:-1]):
            total = value + ((t_s - self.end) * (2.0 / self.steps.size_s) + 1.0) * total
        return total


def coefficients(orbit: KeplerOrbit, steps: Steps, degree: int) -> Array:
    """Fit each number in s = 2 (t - end)/h + 1 over -1 <= s <= 1: (count + 1, 5 (degree + 1)), ascending powers.

    Row i belongs to the step that ends at i h; row 0 to the instant 0. What is fitted is the departure
    from the step's mean value, so that rounding in the fit is relative to how little changes in a step.
    """
    if degree == 0:
        track = orbit.at(steps.ends_s)
        return np.stack([getattr(track, name) for name in NAMES], axis=1)
    s = np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1))
    track = orbit.at((steps.ends_s[:, None] + 0.5 * steps.size_s * (s - 1.0)).ravel())
    inverse = np.linalg.inv(np.vander(s, increasing=True))
    columns = [fitted(getattr(track, name).reshape(-1, degree + 1), inverse) for name in NAMES]
    return np.concatenate(columns, axis=1)


def fitted(values: Array, inverse: Array) -> Array:
    """Coefficients (steps, degree + 1) of the polynomials through `values` at the nodes."""
    mean = values.mean(axis=1, keepdims=True)
    found: Array = (values - mean) @ inverse.T
    found[:, :1] += mean
    return found
