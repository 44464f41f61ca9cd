"""Curves from columns of a table: thinning that keeps extrema, ranges of log axes."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenarios.channels import numbered_part

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]
MOST_POINTS = 300  # least and largest value of every two pixels or so
MOST_DECADES = 18  # of a log axis: more than double precision resolves


def numbered(frame: pd.DataFrame, pattern: str) -> Array | None:
    """Columns of a pattern of :mod:`scenarios.channels`, in order of their number; None if there are none.

    Returns
    -------
    ndarray, shape (samples, columns), or None
    """
    parts = ((numbered_part(str(column)), str(column)) for column in frame.columns)
    found = {part[1]: column for part, column in parts if part and part[0] == pattern}
    return frame[[found[j] for j in sorted(found)]].to_numpy(float) if found else None


def column(frame: pd.DataFrame, name: str) -> Array | None:
    """One column as floats; None without a number."""
    if name not in frame:
        return None
    values = frame[name].to_numpy(float)
    return values if np.isfinite(values).any() else None


def thin(x: Array, y: Array, most: int = MOST_POINTS) -> tuple[Array, Array]:
    """Thin a curve to at most `most` points that keep the minimum and maximum of every interval.

    An interval without a number becomes one NaN, which breaks the line.
    """
    if len(x) <= most:
        return x, y
    width = -(-len(y) // ((most - 2) // 2))
    blocks = np.append(y, np.full(-len(y) % width, np.nan)).reshape(-1, width)
    lowest = np.where(np.isnan(blocks), np.inf, blocks).argmin(axis=1)
    highest = np.where(np.isnan(blocks), -np.inf, blocks).argmax(axis=1)
    starts = np.arange(len(blocks)) * width
    kept = np.unique([0, *(starts + lowest), *(starts + highest), len(x) - 1])
    return x[kept], y[kept]


class DecadeRange(NamedTuple):
    """Lower and upper edge of a log axis."""

    low: float
    high: float

    def lift(self, y: Array) -> tuple[Array, int]:
        """Values with positive ones below the edge moved onto it, and the number of these; NaN stays NaN."""
        below = (y > 0.0) & (y < self.low * (1.0 - 1e-6))
        return np.where(below, self.low, y), int(below.sum())


def decade_range(curves: list[Array]) -> DecadeRange | None:
    """Whole decades around all positive values of `curves`; None if there are none."""
    positive = [c[np.isfinite(c) & (c > 0.0)] for c in curves]
    values = np.concatenate(positive) if positive else np.empty(0)
    if not values.size:
        return None
    high = int(np.ceil(np.log10(values.max()) - 1e-9))
    low = max(int(np.floor(np.log10(values.min()) + 1e-9)), high - MOST_DECADES)
    if high - low < 2:
        low -= 1
    return DecadeRange(10.0**low, 10.0**high)
