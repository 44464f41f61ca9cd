"""Measured order of convergence, and cost of one more digit.

The asymptotic range does not depend on the theoretical order. It is the longest run of neighbouring points whose local
slopes agree with their median, with small errors above the error bar of the certified solution and above round-off.
Only that range is fitted.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import linregress
from scipy.stats import t as student

from barchain.studies.timing.statistics import CONFIDENCE, Interval

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.trajectory import Array

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
