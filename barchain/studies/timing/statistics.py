"""Statistics of times and errors: intervals of medians, work-precision curves, orders of convergence, cost of a digit.

A work-precision curve is the lower envelope of an engine's points, cost over error. The asymptotic range of an order
does not depend on the theoretical order: it is the longest run of neighbouring points whose local slopes agree with
their median, with small errors above the error bar of the certified solution and above round-off. Only that range is
fitted.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import bootstrap, linregress
from scipy.stats import t as student

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from adapters.trajectory import Array

CONFIDENCE = 0.95
RESAMPLES = 999  # the ends of the interval are the 25th and the 975th of them
SEED = 20020812  # fixed, so that equal times give equal intervals
FEWEST_RESAMPLED = 6  # times for an interval by resampling; fewer times give their range, which holds the
# median with probability 1 - 2^(1-n): 75 % for three times, 97 % for six


@dataclass(frozen=True)
class Interval:
    """A number and its interval at :data:`CONFIDENCE`; NaN for an unknown end."""

    value: float
    low: float = float("nan")
    high: float = float("nan")

    def columns(self, name: str, value: str = "") -> dict[str, float]:
        """Columns of a table: the number under its own name or another one, and the ends of its interval."""
        return {value or name: self.value, f"{name}_low": self.low, f"{name}_high": self.high}


@dataclass(frozen=True)
class WorkPrecisionCurve:
    """Points on the lower envelope, from the largest error to the least; the cost rises along it."""

    error: Array
    """(k,)"""
    cost: Array
    """(k,)"""
    samples: tuple[Array, ...]
    """Measured times of each point, s; empty if the cost is a count"""


@dataclass(frozen=True)
class CurvePosition:
    """Position of a target on a curve: between points `i` and `i + 1`, or at `i` if `weight` is 0."""

    i: int
    weight: float
    """Weight of point i + 1 in the logarithm, 0 to 1"""
    at_most: bool = False
    """Whether the error of the coarsest point is already below the target"""


def lower_envelope(error: Sequence[float], cost: Sequence[float], samples: Sequence[Array] = ()) -> WorkPrecisionCurve:
    """Keep each point unless another point is both cheaper and more accurate.

    Points whose error or cost is not a positive number are dropped.
    """
    order = [int(k) for k in np.lexsort((error, cost)) if positive(error[k]) and positive(cost[k])]
    kept: list[int] = []
    for k in order:
        if not kept or error[k] < error[kept[-1]]:
            kept.append(k)
    taken = tuple(np.asarray(samples[k], float) for k in kept) if len(samples) else ()
    return WorkPrecisionCurve(np.array([error[k] for k in kept]), np.array([cost[k] for k in kept]), taken)


def positive(value: float) -> bool:
    """Whether a value has a logarithm."""
    return bool(np.isfinite(value) and value > 0.0)


def on_front(error: Array, cost: Array) -> Array:
    """Whether each point is on the lower envelope, (n,) bool; False for NaN."""
    front = lower_envelope(list(error), list(cost))
    pairs = set(zip(front.error.tolist(), front.cost.tolist(), strict=True))
    return np.array([pair in pairs for pair in zip(error.tolist(), cost.tolist(), strict=True)], bool)


def locate(curve: WorkPrecisionCurve, target: float) -> CurvePosition | None:
    """Position at which a curve reaches an error of `target`; None if it does not. Nothing is extrapolated."""
    if not len(curve.error) or curve.error[-1] > target:
        return None
    i = int(np.argmax(curve.error <= target))  # first point that is good enough
    if i == 0:
        return CurvePosition(0, 0.0, at_most=bool(curve.error[0] < target))
    high, low = np.log(curve.error[i - 1]), np.log(curve.error[i])
    weight = float((high - np.log(target)) / (high - low))
    return CurvePosition(i, 0.0) if weight >= 1.0 else CurvePosition(i - 1, weight)


def cost_at(curve: WorkPrecisionCurve, position: CurvePosition) -> float:
    """Cost, interpolated in logarithms of both axes."""
    log_cost = np.log(curve.cost[position.i])
    if position.weight:
        log_cost += position.weight * (np.log(curve.cost[position.i + 1]) - log_cost)
    return float(np.exp(log_cost))


def parts(curve: WorkPrecisionCurve, position: CurvePosition, sign: float = 1.0) -> list[tuple[float, Array]]:
    """Measured times behind an interpolated cost, each with its exponent."""
    if not curve.samples:
        return []
    found = [(sign * (1.0 - position.weight), curve.samples[position.i])]
    return [*found, (sign * position.weight, curve.samples[position.i + 1])] if position.weight else found


def interval(value: float, made_of: list[tuple[float, Array]]) -> Interval:
    """Bootstrap interval of a product of powers of medians.

    Rounds are independent measurements, so the times of each point are resampled separately. A point with fewer than
    :data:`FEWEST_RESAMPLED` times contributes the ends of its range. A point with a single time leaves the interval
    open.
    """
    if not made_of or min(len(t) for _, t in made_of) < 2:
        return Interval(value)
    few = [(p, t) for p, t in made_of if len(t) < FEWEST_RESAMPLED]
    many = [(p, t) for p, t in made_of if len(t) >= FEWEST_RESAMPLED]
    low, high = resampled(many)
    for power, times in few:
        middle = float(np.median(times))
        ends = sorted(((times.min() / middle) ** power, (times.max() / middle) ** power))
        low, high = low * ends[0], high * ends[1]
    return Interval(value, value * float(low), value * float(high))


def resampled(made_of: list[tuple[float, Array]]) -> tuple[float, float]:
    """Interval of a product of powers of medians, relative to the product."""
    varied = [(p, t / np.median(t)) for p, t in made_of if np.ptp(t) > 0.0]
    if not varied:
        return 1.0, 1.0
    powers = [p for p, _ in varied]

    def product(*times: Array, axis: int = -1) -> Array:
        logs = [p * np.log(np.median(t, axis=axis)) for p, t in zip(powers, times, strict=True)]
        found: Array = np.exp(np.sum(logs, axis=0))
        return found

    drawn = bootstrap(
        tuple(t for _, t in varied), product, vectorized=True, n_resamples=RESAMPLES, method="percentile",
        confidence_level=CONFIDENCE, random_state=np.random.default_rng(SEED),
    )  # fmt: skip
    return float(drawn.confidence_interval.low), float(drawn.confidence_interval.high)


def median_time(times: Array) -> Interval:
    """Median of some times with its interval."""
    return interval(float(np.median(times)), [(1.0, times)])


SMALL = 0.1  # of a radian, or of the largest reaction: larger errors are outside the asymptotic range
STRAIGHT = 0.1, 0.08  # local slopes agree within the first number plus the second times their median
SCATTERED = 0.1, 0.3  # alike with step control, which rounds the number of steps: one step in twenty
LEAST_SLOPE = 0.5  # below it an error is at a floor
FEWEST = 3  # points of a fit: two points always lie on a line


@dataclass(frozen=True)
class OrderFit:
    """Straight line through a range of points in logarithms of both axes."""

    order: Interval
    points: int
    error_range: tuple[float, float]


def straight_run(
    log_x: Array,
    log_y: Array,
    agree: tuple[float, float] = STRAIGHT,
    wanted: Callable[[float], bool] = lambda slope: slope >= LEAST_SLOPE,
) -> slice:
    """Longest run of points on one line whose slope is wanted; of equally long runs the last, empty if all are short.

    Local slopes agree with their median to the first number of `agree`, plus the second times the median.
    """
    slopes = np.diff(log_y) / np.diff(log_x)
    best = slice(0, 0)
    for first, last in itertools.combinations(range(len(log_x)), 2):
        run = slopes[first:last]
        middle = float(np.median(run))
        straight = bool(np.all(np.abs(run - middle) <= agree[0] + agree[1] * abs(middle)))
        long_enough = last + 1 - first >= max(FEWEST, best.stop - best.start)
        if straight and long_enough and wanted(middle):
            best = slice(first, last + 1)
    return best


def fit_order(x: Array, error: Array, agree: tuple[float, float] = STRAIGHT) -> OrderFit | None:
    """Order p of ``error = C x^p`` in the asymptotic range, with its interval; None if there is no such range.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Step, or the reciprocal of a count of evaluations; distinct.
    error : ndarray, shape (n,)
    agree : tuple of float
        Largest distance of a local slope from the median of its range: the first number, plus the second times the
        median.
    """
    usable = np.isfinite(error) & (error > 0.0) & (error < SMALL) & np.isfinite(x) & (x > 0.0)
    falling = np.argsort(-x[usable], kind="stable")
    log_x, log_error = np.log(x[usable][falling]), np.log(error[usable][falling])
    if len(np.unique(log_x)) < len(log_x):
        log_x, first = np.unique(log_x, return_index=True)
        log_x, log_error = log_x[::-1], log_error[first][::-1]
    chosen = straight_run(log_x, log_error, agree) if len(log_x) >= FEWEST else slice(0, 0)
    n = chosen.stop - chosen.start
    if n < FEWEST:
        return None
    spread = (float(np.exp(log_error[chosen].max())), float(np.exp(log_error[chosen].min())))
    return OrderFit(slope(log_x[chosen], log_error[chosen]), n, spread)


def slope(x: Array, y: Array) -> Interval:
    """Least-squares slope with Student's interval."""
    line = linregress(x, y)
    if len(x) < FEWEST:
        return Interval(float(line.slope))
    wide = float(student.ppf(0.5 + 0.5 * CONFIDENCE, len(x) - 2) * line.stderr)
    return Interval(float(line.slope), float(line.slope) - wide, float(line.slope) + wide)


def price_of_a_digit(error: Array, cost: Array) -> Interval | None:
    """Factor of the cost for each tenfold smaller error, fitted along a lower envelope.

    The envelope ends at an engine's floor, which is therefore not in the fit.
    """
    small = error < SMALL
    if small.sum() < FEWEST or np.ptp(np.log(error[small])) == 0.0:
        return None
    line = slope(-np.log10(error[small]), np.log10(cost[small]))
    return Interval(10.0**line.value, 10.0**line.low, 10.0**line.high)
