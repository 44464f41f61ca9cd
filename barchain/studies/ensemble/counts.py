"""Counts of values in bins, and quantiles estimated from counts: the same bits for any order of the values.

Own code, as no library fits: `ddsketch` takes values one by one in Python (2 µs each), the sketches KLL and t-digest
depend on the order of values, and `boost-histogram` takes three times as long (27 ns a value) and has one set of bins
for all columns. A run of `paper/fig05` with 101 samples has 909 values and takes 50 µs.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from barchain.studies.ensemble.bins import BINS, EDGES, LEAST, SHIFT, SIDE
from reference_impl.kernel.library import count_in_bins

if TYPE_CHECKING:
    from typing import Self

    from numpy.typing import NDArray

    from adapters.trajectory import Array


@dataclass(frozen=True)
class Quantiles:
    """Quantiles of several columns."""

    value: Array
    """(quantiles, columns)"""
    error_bound: Array
    """(quantiles, columns) largest difference from the exact quantile; 0 of exact ones"""
    runs: NDArray[np.int64]
    """(columns,) values counted"""

    def of(self, columns: slice) -> Quantiles:
        """Quantiles of some columns."""
        return Quantiles(self.value[:, columns], self.error_bound[:, columns], self.runs[columns])


@dataclass(frozen=True)
class BinCounts:
    """Counts of several columns of values, each with a centre and a scale of its own."""

    centre: Array
    """(columns,)"""
    scale: Array
    """(columns,)"""
    count: NDArray[np.int64]
    """(columns, BINS)"""
    least: Array
    """(columns,) least value, infinite before the first"""
    most: Array
    """(columns,)"""

    @classmethod
    def around(cls, pilot: Array) -> Self:
        """Empty counts in bins about the median of a pilot (columns, runs), NaN where a run did not reach an instant.

        The scale is the largest deviation in the pilot, or the centre's magnitude if all values are equal.
        """
        missing = np.isnan(pilot).all(axis=1, keepdims=True)
        known = np.where(missing, 0.0, pilot)
        centre: Array = np.nanmedian(known, axis=1)
        largest = np.nanmax(np.abs(known - centre[:, None]), axis=1)
        scale = np.where(largest > 0.0, largest, np.maximum(np.abs(centre), 1.0))
        columns = len(pilot)
        return cls(
            centre,
            np.maximum(scale, np.finfo(float).tiny),  # whose inverse is finite
            np.zeros((columns, BINS), np.int64),
            np.full(columns, np.inf),
            np.full(columns, -np.inf),
        )

    def add(self, values: Array) -> None:
        """Count values (columns, runs), NaN left out; the array is overwritten."""
        bins = SHIFT, LEAST, SIDE
        count_in_bins(values, self.centre, self.scale, self.least, self.most, bins, self.count)

    @property
    def runs(self) -> NDArray[np.int64]:
        """(columns,) values counted."""
        return np.asarray(self.count.sum(axis=1), dtype=np.int64)

    def quantiles(self, wanted: tuple[float, ...]) -> Quantiles:
        """Estimates by NumPy's linear definition; NaN in a column without values."""
        found = np.full((2, len(wanted), len(self.count)), np.nan)
        for column in np.nonzero(self.runs)[0]:
            found[:, :, column] = self.column_quantiles(int(column), np.asarray(wanted))
        return Quantiles(found[0], found[1], self.runs)

    def column_quantiles(self, column: int, wanted: Array) -> tuple[Array, Array]:
        """Estimates and their error bounds in one column.

        A quantile lies between two neighbours in the order of all values. The bin of each is known, and with it the
        neighbour to within the bin's width; a mean of both is no farther off than the farther of them.
        """
        before = np.concatenate([[0], np.cumsum(self.count[column])])
        rank = wanted * (before[-1] - 1)
        lower = np.floor(rank).astype(np.int64)
        low, low_width = self.ordered(column, before, lower)
        high, high_width = self.ordered(column, before, np.minimum(lower + 1, before[-1] - 1))
        return low + (rank - lower) * (high - low), np.maximum(low_width, high_width)

    def ordered(self, column: int, before: NDArray[np.int64], rank: NDArray[np.int64]) -> tuple[Array, Array]:
        """Estimates of the values at ranks from 0, and the widths of their bins.

        The values of a bin are taken as equally spaced between its edges, or the least and the most value. `before` has
        the number of values below each bin.
        """
        k = np.searchsorted(before, rank, side="right") - 1
        edges = self.centre[column] + self.scale[column] * EDGES
        low = np.maximum(edges[k], self.least[column])
        high = np.maximum(np.minimum(edges[k + 1], self.most[column]), low)
        share = (rank - before[k] + 0.5) / self.count[column, k]
        return low + (high - low) * share, high - low
