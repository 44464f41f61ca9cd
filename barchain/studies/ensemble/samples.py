"""Samples of an ensemble's runs: held until the end for exact quantiles, or counted in bins as they come."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.studies.ensemble.bins import PILOT_RUNS
from barchain.studies.ensemble.counts import BinCounts, Quantiles

if TYPE_CHECKING:
    from collections.abc import Mapping

    from adapters.trajectory import Array
    from reference_impl.kernel.batch import BatchResult
    from scenarios import Scene

COLUMNS_AT_ONCE = 64
"""Columns that are sorted together, so that no second copy of all values is made"""
COUNTED = tuple(f.name for f in dataclasses.fields(BinCounts))


class HeldSamples:
    """All samples of all runs."""

    def __init__(self, scene: Scene, runs: int) -> None:
        """Reserve memory; the system gives it as it is filled."""
        n, bars = scene.run.samples, scene.bars
        self.angle_rad: Array = np.empty((runs, n, bars))
        self.reaction_N: Array = np.empty((runs, n, bars - 1))

    def add(self, first: int, seen: BatchResult) -> None:
        """Take the samples of some runs, from run `first` on, counted from 0."""
        last = first + len(seen.angle_rad)
        self.angle_rad[first:last], self.reaction_N[first:last] = seen.angle_rad, seen.reaction_N

    def quantiles(self, wanted: tuple[float, ...]) -> Quantiles:
        """Exact quantiles of angles and reactions, by NumPy's linear definition."""
        runs = len(self.angle_rad)
        parts = [exact_quantiles(x.reshape(runs, -1), wanted) for x in (self.angle_rad, self.reaction_N) if x.size]
        value, reached = np.concatenate([p[0] for p in parts], axis=1), np.concatenate([p[1] for p in parts])
        return Quantiles(value, np.where(np.isnan(value), np.nan, 0.0), reached)

    def part(self, first: int, last: int) -> dict[str, Array]:
        """Samples of runs `first` to `last`, the last left out, for a checkpoint."""
        return {"angle_rad": self.angle_rad[first:last], "reaction_N": self.reaction_N[first:last]}

    def restore_part(self, first: int, last: int, stored: Mapping[str, Any]) -> None:
        """Take samples of a checkpoint."""
        self.angle_rad[first:last], self.reaction_N[first:last] = stored["angle_rad"], stored["reaction_N"]

    def whole(self) -> dict[str, Array]:
        """Nothing: a checkpoint has all samples in its parts."""
        return {}

    def restore_whole(self, stored: Mapping[str, Any]) -> None:
        """Take nothing."""


class CountedSamples:
    """Counts of all samples so far, and the samples of the last runs, which wait to be counted together.

    The first runs that wait are the pilot of the bins.
    """

    def __init__(self, scene: Scene) -> None:
        """Begin without bins."""
        n = scene.run.samples
        self.angles = n * scene.bars
        self.waiting: Array = np.empty((n * (2 * scene.bars - 1), PILOT_RUNS))
        self.held = 0
        """Runs that wait"""
        self.counts: BinCounts | None = None

    def add(self, first: int, seen: BatchResult) -> None:
        """Take the samples of the next runs."""
        del first
        runs = len(seen.angle_rad)
        if self.held + runs > PILOT_RUNS:
            self.count()
        here = slice(self.held, self.held + runs)
        self.waiting[: self.angles, here] = seen.angle_rad.reshape(runs, -1).T
        self.waiting[self.angles :, here] = seen.reaction_N.reshape(runs, -1).T
        self.held += runs

    def count(self) -> None:
        """Count the samples that wait."""
        self.waiting[:, self.held :] = np.nan
        if self.counts is None:
            self.counts = BinCounts.around(self.waiting)
        self.counts.add(self.waiting)
        self.held = 0

    def quantiles(self, wanted: tuple[float, ...]) -> Quantiles:
        """Estimated quantiles of angles and reactions."""
        self.count()
        assert self.counts is not None
        return self.counts.quantiles(wanted)

    def part(self, first: int, last: int) -> dict[str, Array]:
        """Nothing: a checkpoint has the counts of all runs."""
        del first, last
        return {}

    def restore_part(self, first: int, last: int, stored: Mapping[str, Any]) -> None:
        """Take nothing."""

    def whole(self) -> dict[str, Array]:
        """Counts and samples that wait, for a checkpoint."""
        known = {} if self.counts is None else {name: getattr(self.counts, name) for name in COUNTED}
        return {"waiting": self.waiting, "held": np.array(self.held)} | known

    def restore_whole(self, stored: Mapping[str, Any]) -> None:
        """Take counts and samples of a checkpoint."""
        self.waiting[:], self.held = stored["waiting"], int(stored["held"])
        if all(name in stored for name in COUNTED):
            self.counts = BinCounts(**{name: stored[name] for name in COUNTED})


Samples = HeldSamples | CountedSamples


def exact_quantiles(columns: Array, wanted: tuple[float, ...]) -> tuple[Array, np.ndarray]:
    """Quantiles over the runs of columns (runs, columns), NaN left out, and the number of runs of each."""
    runs, count = columns.shape
    found, reached = np.full((len(wanted), count), np.nan), np.empty(count, np.int64)
    for first in range(0, count, COLUMNS_AT_ONCE):
        block = np.ascontiguousarray(columns[:, first : first + COLUMNS_AT_ONCE].T)
        here = runs - np.isnan(block).sum(axis=1)
        whole = here == runs
        reached[first : first + COLUMNS_AT_ONCE] = here
        found[:, first + np.nonzero(whole)[0]] = np.quantile(block[whole], wanted, axis=1)
        for k in np.nonzero(~whole & (here > 0))[0]:
            found[:, first + k] = np.nanquantile(block[k], wanted)
    return found, reached
