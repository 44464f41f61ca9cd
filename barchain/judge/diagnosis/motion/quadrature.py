"""Integrals between samples of a function that is known at the samples and smooth between given instants."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from scipy.sparse import csr_array

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from adapters.trajectory import Array
    from reference_impl.model.arrays import ComplexArray

Values = TypeVar("Values", "Array", "ComplexArray")

DEGREE = 9
"""Degree of the polynomials: with ten samples a radian, the error of their integrals is below that of most engines"""
LOWER = 2
"""Degrees less of the polynomials that show the error"""
FEWEST = 4
"""Samples between two breaks without which nothing is said of the intervals there"""
SAME_INSTANT = 1e-9
"""Share of an interval by which a break may miss a sample"""


@dataclass(frozen=True)
class Quadrature:
    """Weights that integrate values at k evaluations over the n - 1 intervals of n samples.

    A sample at a break holds the state before it, and belongs to the piece before the break alone.
    """

    rows: NDArray[np.intp]
    """(k,) sample of each evaluation"""
    piece: NDArray[np.intp]
    """(k,) smooth piece of each evaluation"""
    pieces: tuple[tuple[float, float], ...]
    """Start and end of each smooth piece, s"""
    weights: csr_array
    """(n - 1, k) s; zero in intervals without enough samples"""
    coarse: csr_array
    """(n - 1, k) s, of polynomials of a lower degree"""
    known: NDArray[np.bool_]
    """(n - 1,) intervals with enough samples"""

    def integral(self, values: Values) -> Values:
        """Integral of values (k, c) over each interval, (n - 1, c)."""
        found: Values = np.asarray(self.weights @ values)
        return found

    def error(self, values: Array) -> Array:
        """Estimate of the error of :meth:`integral`, at least zero."""
        found: Array = np.abs(self.weights @ values - self.coarse @ values)
        return found


def quadrature(t_s: Array, breaks_s: Sequence[float] = (), hidden: Sequence[int] = ()) -> Quadrature:
    """Quadrature at n samples.

    Parameters
    ----------
    t_s : ndarray, shape (n,)
    breaks_s : sequence of float
        Instants at which the function or a derivative jumps, s.
    hidden : sequence of int
        Intervals with a break at an unknown instant: nothing is known there.
    """
    n, near = len(t_s), SAME_INSTANT * float(t_s[1] - t_s[0])
    inside = [b for b in breaks_s if t_s[0] + near < b < t_s[-1] - near]
    edges = merged_instants([t_s[0], *inside, t_s[-1], *(t for k in hidden for t in t_s[k : k + 2])], near)
    middles = [0.5 * float(t_s[k] + t_s[k + 1]) for k in hidden]
    rows: list[NDArray[np.intp]] = []
    pieces: list[tuple[float, float]] = []
    entries: list[tuple[int, int, Array, Array]] = []
    known, count = np.ones(n - 1, bool), 0
    for start, end in itertools.pairwise(edges):
        overlapping = np.nonzero((t_s[1:] > start + near) & (t_s[:-1] < end - near))[0]
        after = t_s > start + near if pieces or start > t_s[0] else t_s >= start - near
        samples = np.nonzero(after & (t_s <= end + near))[0]
        if len(samples) < FEWEST or any(start < m < end for m in middles):
            known[overlapping] = False
            continue
        for k in overlapping:
            a, b = max(start, float(t_s[k])), min(end, float(t_s[k + 1]))
            entries.append((int(k), *local_weights(t_s, samples, a, b, count)))
        rows.append(samples)
        pieces.append((start, end))
        count += len(samples)
    weights, coarse = (matrix(entries, known, kind, (n - 1, count)) for kind in (2, 3))
    piece = np.repeat(np.arange(len(pieces)), [len(r) for r in rows])
    return Quadrature(np.concatenate([*rows, np.empty(0, int)]), piece, tuple(pieces), weights, coarse, known)


def matrix(entries: list[tuple[int, int, Array, Array]], known: Array, kind: int, shape: tuple[int, int]) -> csr_array:
    """Sparse matrix of the weights of stencils; zero in unknown intervals."""
    kept = [e for e in entries if known[e[0]]]
    values = np.concatenate([*(e[kind] for e in kept), np.empty(0)])
    at = np.concatenate([*(np.full(len(e[2]), e[0]) for e in kept), np.empty(0, int)])
    columns = np.concatenate([*(e[1] + np.arange(len(e[2])) for e in kept), np.empty(0, int)])
    return csr_array((values, (at, columns)), shape=shape)


def merged_instants(instants: Sequence[float], near: float) -> list[float]:
    """Increasing instants, those that are as good as equal once."""
    found: list[float] = []
    for t in sorted(map(float, instants)):
        if not found or t - found[-1] > near:
            found.append(t)
    return found


def local_weights(t_s: Array, samples: NDArray[np.intp], a: float, b: float, offset: int) -> tuple[int, Array, Array]:
    """First evaluation, and weights of both degrees, of the integral from a to b through the nearest samples."""
    count = min(DEGREE + 1, len(samples))
    nearest = int(np.searchsorted(t_s[samples], 0.5 * (a + b)))
    first = min(max(0, nearest - (count + 1) // 2), len(samples) - count)
    start, step = float(t_s[samples[first]]), float(t_s[samples[first] + 1] - t_s[samples[first]])
    nodes = tuple(np.round((t_s[samples[first : first + count]] - start) / step, 9).tolist())
    lo, hi = round((a - start) / step, 9), round((b - start) / step, 9)
    fine, coarse = weights_of(nodes, lo, hi)
    return offset + first, step * fine, step * coarse


@lru_cache(4096)
def weights_of(nodes: tuple[float, ...], lo: float, hi: float) -> tuple[Array, Array]:
    """Weights of the integral from `lo` to `hi` of the polynomials through the nodes, of full and of lower degree."""
    x = np.array(nodes)
    middle, half = 0.5 * (x[0] + x[-1]), 0.5 * (x[-1] - x[0])
    ends = (hi - middle) / half, (lo - middle) / half
    count = len(x)
    powers = np.arange(1, count + 1)
    moments = half * (ends[0] ** powers - ends[1] ** powers) / powers
    basis = np.vander((x - middle) / half, count, increasing=True)
    fine = np.linalg.solve(basis.T, moments)
    fewer = max(2, count - LOWER)
    coarse = np.linalg.pinv(basis[:, :fewer]).T @ moments[:fewer]  # the best polynomial of the lower degree
    return fine, coarse
