"""Numbers in Exudyn's symbolic loads that depend on time alone, updated before every step.

A function of time needs no expression: a table holds its values from the build phase on. An implicit method evaluates
its loads at the end of a step only, where the table is exact. An explicit method also evaluates them inside the step,
where each number is a polynomial in the step's own time. A number that jumps at the end of a step has the value before
the jump in that step, and the value after it in the next.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from adapters.trajectory import Array

TimeInputs = Callable[["Array", "Array"], "Array"]
"""Values (k, count) at instants (k,), by the law that holds around other instants (k,), inside the same steps"""


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

    @property
    def inside_s(self) -> Array:
        """Middle of the step that ends at each of `ends_s`; of the first step for the instant 0."""
        middle: Array = self.size_s * (np.maximum(np.arange(self.count + 1), 1) - 0.5)
        return middle

    def index(self, t_s: float) -> int:
        """Step that ends at `t_s`, despite the round-off of Exudyn's summation."""
        return round(t_s / self.size_s)


class Timetable:
    """Symbolic functions of time, and their updates."""

    def __init__(self, time_inputs: TimeInputs, count: int, steps: Steps, *, degree: int) -> None:
        """Tabulate `count` inputs as polynomials of `degree` over each of `steps`."""
        self.time_inputs, self.count, self.steps, self.degree = time_inputs, count, steps, degree
        self.table = tabulated(time_inputs, steps, degree).tolist()

    def start(self, symbolic: Any) -> None:
        """Make the symbolic numbers, with their values at t = 0."""
        self.values = [symbolic.Real(f"number{i}", 0.0) for i in range(self.count * (self.degree + 1))]
        self.end = symbolic.Real("stepEnd", 0.0)
        self.tick(0.0)

    def tick(self, t_s: float) -> None:
        """Prepare the step that ends at `t_s`."""
        self._set(t_s, self.table[self.steps.index(t_s)])

    def resume(self, index: int) -> None:
        """Prepare the instant just after step `index`; for polynomials of degree 0."""
        at = self.steps.size_s * np.array([index])
        self._set(float(at[0]), self.time_inputs(at, at + 0.5 * self.steps.size_s)[0].tolist())

    def symbols(self, t_s: Any) -> list[Any]:
        """All numbers as functions of the symbolic time `t_s`, also inside a step."""
        return [self._polynomial(i, t_s) for i in range(self.count)]

    def _set(self, end_s: float, row: list[float]) -> None:
        self.end.SetValue(end_s)
        for value, number in zip(self.values, row, strict=True):
            value.SetValue(number)

    def _polynomial(self, which: int, t_s: Any) -> Any:
        """Horner's rule in s = 2 (t - end)/h + 1."""
        own = self.values[which * (self.degree + 1) : (which + 1) * (self.degree + 1)]
        total = own[-1]
        for value in reversed(own[:-1]):
            total = value + ((t_s - self.end) * (2.0 / self.steps.size_s) + 1.0) * total
        return total


def tabulated(time_inputs: TimeInputs, steps: Steps, degree: int) -> Array:
    """Fit each number in s = 2 (t - end)/h + 1 over -1 <= s <= 1: (steps + 1, count (degree + 1)), ascending powers.

    Row i belongs to the step that ends at i h; row 0 to the instant 0. The fit is of the deviation from the step's mean
    value, so that its rounding is relative to the change within a step.
    """
    if degree == 0:
        return time_inputs(steps.ends_s, steps.inside_s)
    s = np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1))
    nodes = (steps.ends_s[:, None] + 0.5 * steps.size_s * (s - 1.0)).ravel()
    values = time_inputs(nodes, np.repeat(steps.inside_s, degree + 1))
    inverse = np.linalg.inv(np.vander(s, increasing=True))
    return np.concatenate([fitted(column.reshape(-1, degree + 1), inverse) for column in values.T], axis=1)


def fitted(values: Array, inverse: Array) -> Array:
    """Coefficients (steps, degree + 1) of the polynomials through `values` at the nodes."""
    mean = values.mean(axis=1, keepdims=True)
    found: Array = (values - mean) @ inverse.T
    found[:, :1] += mean
    return found
