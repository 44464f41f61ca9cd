"""Work-precision curve of an engine: cost over error along its lower envelope."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import bootstrap

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.trajectory import Array

CONFIDENCE = 0.95
RESAMPLES = 999  # the ends of the interval are the 25th and the 975th of them
SEED = 20020812  # fixed, so that equal times give equal intervals
FEWEST = 6  # times for an interval by resampling; fewer times give their range, which holds the
# median with probability 1 - 2^(1-n): 75 % for three times, 97 % for six


@dataclass(frozen=True)
class Interval:
    """A number and its interval at :data:`CONFIDENCE`; NaN for an unknown end."""

    value: float
    low: float = float("nan")
    high: float = float("nan")


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
    :data:`FEWEST` times contributes the ends of its range. A point with a single time leaves the interval open.
    """
    if not made_of or min(len(t) for _, t in made_of) < 2:
        return Interval(value)
    few = [(p, t) for p, t in made_of if len(t) < FEWEST]
    many = [(p, t) for p, t in made_of if len(t) >= FEWEST]
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
