"""Integrals between samples of a function that is known at the samples and smooth between given instants."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from scipy.interpolate import make_interp_spline

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray
    from scipy.interpolate import BSpline

    from adapters.trajectory import Array
    from reference_impl.model.arrays import ComplexArray

Values = TypeVar("Values", "Array", "ComplexArray")

DEGREE = 9
"""Degree of the splines: with ten samples a radian, the error of their integrals is below that of most engines"""
LOWER = 5
"""Degree of the splines that show the error: where a chain folds fast, one nearer to the other would hide it"""
FEWEST = 4
"""Samples between two breaks without which nothing is said of the intervals there"""
SAME_INSTANT = 1e-9
"""Share of an interval by which a break may miss a sample"""


@dataclass(frozen=True)
class Quadrature:
    """Integrals of values at k evaluations over the n - 1 intervals of n samples.

    A sample at a break holds the state before it, and belongs to the piece before the break alone.
    """

    t_s: Array
    """(n,) samples"""
    rows: NDArray[np.intp]
    """(k,) sample of each evaluation"""
    piece: NDArray[np.intp]
    """(k,) smooth piece of each evaluation"""
    pieces: tuple[tuple[float, float], ...]
    """Start and end of each smooth piece, s"""
    known: NDArray[np.bool_]
    """(n - 1,) intervals with enough samples"""
    often: bool = True
    """Whether so much is integrated that the weights are worth their time"""

    def alike(self, other: Quadrature) -> bool:
        """Whether integrals at the same samples have the same weights."""
        return self.pieces == other.pieces and np.array_equal(self.known, other.known)

    def curve(self, values: Array | ComplexArray, number: int, degree: int = DEGREE) -> BSpline:
        """Spline through values (k, c) in a smooth piece, which goes on to the ends of the piece."""
        at = self.piece == number
        most = int(np.count_nonzero(at)) - (1 if degree == DEGREE else 3)  # of few samples too, the error shows
        return make_interp_spline(self.t_s[self.rows[at]], values[at], min(degree, most))

    @cached_property
    def weights(self) -> Array:
        """(n - 1, k) weight of each evaluation in the integral over each interval: integrals are linear in values."""
        return self.by_splines(np.eye(len(self.rows)))

    def by_splines(self, values: Values, degree: int = DEGREE) -> Values:
        """Integral of values (k, c) over each interval by splines of a degree, (n - 1, c)."""
        found: Values = np.zeros((len(self.t_s) - 1, values.shape[1]), values.dtype)
        for number, (start, end) in enumerate(self.pieces):
            summed = self.curve(values, number, degree).antiderivative()
            found += np.diff(summed(np.clip(self.t_s, start, end)), axis=0)
        found[~self.known] = 0.0
        return found

    def integral(self, values: Values) -> Values:
        """Integral of values (k, c) over each interval, (n - 1, c); zero in unknown intervals."""
        if not self.often:
            return self.by_splines(values)
        found: Values = self.weights @ values
        return found

    def error(self, values: Array) -> Array:
        """Estimate of the error of :meth:`integral`, at least zero."""
        found: Array = np.abs(self.integral(values) - self.by_splines(values, LOWER))
        return found


def quadrature(
    t_s: Array, breaks_s: Sequence[float] = (), hidden: Sequence[int] = (), *, often: bool = True
) -> Quadrature:
    """Quadrature at n samples.

    Parameters
    ----------
    t_s : ndarray, shape (n,)
    breaks_s : sequence of float
        Instants at which the function or a derivative jumps, s.
    hidden : sequence of int
        Intervals with a break at an unknown instant: nothing is known there.
    often : bool
        Whether so much is integrated that the weights are worth their time.
    """
    near = SAME_INSTANT * float(t_s[1] - t_s[0])
    inside = [b for b in breaks_s if t_s[0] + near < b < t_s[-1] - near]
    instants = np.sort([t_s[0], *inside, t_s[-1], *(t for k in hidden for t in t_s[k : k + 2])])
    edges = instants[np.diff(instants, prepend=-np.inf) > near].tolist()
    known = np.ones(len(t_s) - 1, bool)
    known[list(hidden)] = False
    rows: list[NDArray[np.intp]] = []
    pieces: list[tuple[float, float]] = []
    for start, end in itertools.pairwise(edges):
        overlapping = (t_s[1:] > start + near) & (t_s[:-1] < end - near)
        first = start + near if pieces or start > t_s[0] else start - near
        samples = np.nonzero((t_s > first) & (t_s <= end + near))[0]
        if len(samples) < FEWEST or not known[overlapping].any():
            known[overlapping] = False
            continue
        rows.append(samples)
        pieces.append((start, end))
    piece = np.repeat(np.arange(len(pieces)), [len(r) for r in rows])
    return Quadrature(t_s, np.concatenate([*rows, np.empty(0, int)]), piece, tuple(pieces), known, often)
