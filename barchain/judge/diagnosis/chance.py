"""Chance that a wrong explanation fits a result: few rows of few digits hold few numbers, and many things are tried.

A difference in units of its tolerance holds as many independent numbers as rows that are larger than 1, or coefficients
of orthogonal polynomials along the samples, whichever are fewer: one wrong row holds one, a smooth curve of a hundred
rows few, and rows without a pattern one each. A
number of size s is met by chance with a probability of 1/s. An explanation with k fitted numbers meets k of them by
itself, the largest ones; of c explanations that are tried, one meets the rest with c times that probability.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial.legendre import legvander

if TYPE_CHECKING:
    from adapters.trajectory import Array

LEAST_DIGITS = 3.0
"""Decimal digits of a result that an explanation must foretell: by chance one in a thousand does"""
DEGREES = 40
"""Most polynomials"""


def independent_digits(over: Array) -> Array:
    """Decimal digits of each independent number in differences over their tolerances (n, c), largest first."""
    n = len(over)
    if not over.size:
        return np.zeros(0)
    basis = np.linalg.qr(legvander(np.linspace(-1.0, 1.0, n), min(n - 1, DEGREES)))[0]
    sizes = basis.T @ over
    rest = over - basis @ sizes
    free = n - basis.shape[1]
    if free:  # what no polynomial follows is taken as rows without a pattern
        spread = np.linalg.norm(rest, axis=0) / math.sqrt(free)
        sizes = np.concatenate([sizes, np.broadcast_to(spread, (free, over.shape[1]))])
    found = [np.sort(np.log10(np.maximum(np.abs(each), 1.0)), axis=None)[::-1] for each in (over, sizes)]
    return min(found, key=np.sum)


def foretells(digits: Array, fitted: int, tried: int) -> bool:
    """Whether an explanation with some fitted numbers, one of those tried, foretells more than chance does."""
    return bool(float(digits[fitted:].sum()) - math.log10(max(tried, 1)) >= LEAST_DIGITS)
