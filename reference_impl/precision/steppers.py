"""Integrators for vectors (rows, B) in any arithmetic: fixed steps, adaptive steps, and extrapolation.

Each column is one run. Adaptive runs have a step size per column. Extrapolation serves the certified solutions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import DOP853

from reference_impl.precision.arithmetic import Arithmetic, Values

Rates = Callable[[Values], Values]
Step = Callable[[Rates, Values, Values], Values]
SAFETY, LEAST_FACTOR, LARGEST_FACTOR, EXPONENT = 0.9, 0.2, 10.0, -1.0 / 8.0  # SciPy's step control
LARGEST_STEP_COUNT = 2000  # between two samples, after which a run is abandoned
SUBSTEPS = tuple(range(2, 16, 2))  # of the extrapolated midpoint rule: order 14


def rk4(rates: Rates, y: Values, h: Values) -> Values:
    """One step of the classical Runge-Kutta method, order 4."""
    k1 = rates(y)
    k2 = rates(y + (0.5 * h) * k1)
    k3 = rates(y + (0.5 * h) * k2)
    k4 = rates(y + h * k3)
    return y + (h / 6.0) * ((k1 + k4) + 2.0 * (k2 + k3))


def extrapolated(rates: Rates, y: Values, h: Values, sequence: tuple[int, ...] = SUBSTEPS) -> Values:
    """One step of the modified midpoint rule, extrapolated (Gragg, Bulirsch and Stoer).

    The order is twice the length of the `sequence` of substeps. The coefficients are ratios of integers, as exact as
    the arithmetic. The increment is extrapolated instead of the vector, as extrapolation magnifies round-off.
    """
    first = rates(y)
    above: list[Values] = []
    for k, fine in enumerate(sequence):
        row = [midpoint_increment(rates, y, first, h / fine, fine)]
        for coarse, left in zip(sequence[k - 1 :: -1] if k else (), above, strict=True):
            row.append(row[-1] + (row[-1] - left) * (coarse * coarse) / (fine * fine - coarse * coarse))
        above = row
    return y + above[-1]


def midpoint_increment(rates: Rates, y: Values, first: Values, h: Values, times: int) -> Values:
    """Increment of a vector by the modified midpoint rule with Gragg's final average."""
    before, now = 0.0 * y, h * first
    for _ in range(times - 1):
        before, now = now, before + (2.0 * h) * rates(y + now)
    return 0.5 * (before + now + h * rates(y + now))


class DormandPrince:
    """DOP853's formula, with coefficients rounded to an arithmetic."""

    def __init__(self, a: Arithmetic) -> None:
        """Round SciPy's coefficients."""
        self.stages = [a.cast(DOP853.A[s, :s]) for s in range(1, 12)]
        self.end, self.fifth, self.third = a.cast(DOP853.B), a.cast(DOP853.E5), a.cast(DOP853.E3)

    def __call__(self, rates: Rates, y: Values, h: Values) -> Values:
        """One step of order 8."""
        slopes = np.empty((13, *y.shape), y.dtype)
        slopes[0] = rates(y)
        return self.stepped(rates, y, h, slopes)

    def stepped(self, rates: Rates, y: Values, h: Values, slopes: Values) -> Values:
        """State at the end of a step; fills `slopes` beyond the given first slope."""
        for s, row in enumerate(self.stages, start=1):
            slopes[s] = rates(y + h * np.tensordot(row, slopes[:s], axes=1))
        return y + h * np.tensordot(self.end, slopes[:12], axes=1)

    def error(self, h: Values, slopes: Values, allowed: Values) -> Values:
        """Error estimate of each column relative to the allowed error, (B,) float64."""
        fifth, third = ((np.tensordot(e, slopes, axes=1) / allowed).astype(float) for e in (self.fifth, self.third))
        high, low = (fifth**2).sum(axis=0), (third**2).sum(axis=0)
        with np.errstate(invalid="ignore"):  # both zero: no error
            found = np.abs(h.astype(float)) * high / np.sqrt((high + 0.01 * low) * len(fifth))
        return np.where((high == 0.0) & (low == 0.0), 0.0, found)


@dataclass
class AdaptiveRuns:
    """Runs with adaptive steps, at a sample."""

    y: Values
    """(rows, B)"""
    h_s: Values
    """(B,) float64, size of the next step"""
    evaluations: Values
    """(B,) integers"""
    abandoned: Values
    """(B,) bool"""


def advance_adaptively(
    a: Arithmetic, rates: Rates, at: AdaptiveRuns, stretch_s: Values, allowed: Values
) -> AdaptiveRuns:
    """Advance each column by `stretch_s`, (B,), with errors in a step of at most `allowed`, (rows, B).

    A column with more than :data:`LARGEST_STEP_COUNT` steps, or a non-finite state, is abandoned: NaN.
    """
    method, slopes = DormandPrince(a), np.empty((13, *at.y.shape), at.y.dtype)
    y, h, left, count = at.y, at.h_s, np.where(at.abandoned, 0.0, stretch_s), at.evaluations
    slopes[0] = rates(y)
    for _ in range(LARGEST_STEP_COUNT):
        going = left > 0.0
        if not going.any():
            break
        step = np.where(going, np.minimum(h, left), 0.0)
        held = a.cast(step)
        end = method.stepped(rates, y, held, slopes)
        slopes[12] = rates(end)
        error = method.error(held, slopes, allowed)
        good = going & (error <= 1.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            factor = np.clip(np.nan_to_num(SAFETY * error**EXPONENT, nan=LEAST_FACTOR, posinf=LARGEST_FACTOR),
                             LEAST_FACTOR, LARGEST_FACTOR)  # fmt: skip
        wanted = step * np.where(good, factor, np.minimum(factor, 1.0))
        h = np.where(going, np.where(good & (step < h), np.maximum(h, wanted), wanted), h)
        y = np.where(good, end, y)
        slopes[0] = np.where(good, slopes[12], slopes[0])
        left = np.where(good, np.where(step == left, 0.0, left - step), left)
        count = count + 12 * going
    lost = at.abandoned | (left > 0.0)
    return AdaptiveRuns(np.where(lost, a.cast(np.nan), y), h, count, lost)
