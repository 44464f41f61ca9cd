"""Tables of an ensemble: exact quantiles over all runs, and a row for each run."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from barchain.studies.ensemble.chunks import columns

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from adapters.trajectory import Array
    from barchain.studies.ensemble.chunks import Chunk, ChunkFiles, RunEnds
    from barchain.studies.ensemble.population import Ensemble, Population
    from barchain.studies.ensemble.variation import Variation

FAILED, ENDED, FINISHED = "failed", "ended", "finished"
MOST_SORTED = 2**22
"""Numbers that are sorted together, 32 MB; of more runs, one column at a time"""
RunColumns = dict[str, "Sequence[Any] | np.ndarray"]
"""Columns of the rows of some runs"""


@dataclass
class RunTally:
    """Counts over all runs so far."""

    outcomes: Counter[str] = field(default_factory=Counter)
    evaluations: int = 0
    first_failure: str = ""
    """Number of the first failed run and its reason; empty if none failed"""

    def add(self, rows: RunColumns) -> None:
        """Count rows."""
        self.outcomes.update(rows["outcome"])
        self.evaluations += int(np.sum(rows["evaluations"]))
        if not self.first_failure and FAILED in rows["outcome"]:
            k = list(rows["outcome"]).index(FAILED)
            self.first_failure = f"run {rows['run'][k]}: {rows['reason'][k]}"

    @property
    def failures(self) -> tuple[str, ...]:
        """Number of failed runs with the first reason, in one line; empty if none failed."""
        count, runs = self.outcomes[FAILED], self.outcomes.total()
        return (f"{count} of {runs} runs failed, the first of them {self.first_failure}",) if count else ()


def run_rows(made: ChunkFiles, tally: RunTally) -> Iterator[RunColumns]:
    """Rows of all runs, chunk by chunk; the tally counts them as they are given."""
    for chunk, ends in made.ends():
        rows = run_columns(chunk, ends, made.ensemble.variations)
        tally.add(rows)
        yield rows


def run_columns(chunk: Chunk, ends: RunEnds, variations: Iterable[Variation]) -> RunColumns:
    """Rows of the runs of a chunk."""
    found: RunColumns = {"run": np.arange(chunk.first + 1, chunk.first + chunk.part.runs + 1)}
    for v in variations:
        found |= drawn_columns(chunk.part, v)
    pairs = list(zip(ends.ended, ends.failed, strict=True))
    found["outcome"] = [FAILED if failed else ENDED if ended else FINISHED for ended, failed in pairs]
    found["reason"] = [failed or ended for ended, failed in pairs]
    found["steps"], found["evaluations"] = np.array(ends.steps), np.array(ends.evaluations)
    return found


def drawn_columns(population: Population, v: Variation) -> dict[str, Array]:
    """Columns of the values that one variation drew, in the units it was given in."""
    name = v.key.replace("_deg", "_rad")
    values = np.degrees(getattr(population, name)) if v.key.endswith("_deg") else getattr(population, name)
    if values.ndim == 1:
        return {v.key: values}
    if v.bar is None:
        return {v.key: values[:, 0]}
    bars = range(1, values.shape[1] + 1) if v.bar == 0 else [v.bar]
    return {f"{v.key}[{bar}]": values[:, bar - 1] for bar in bars}


def run_table(parts: Iterable[RunColumns]) -> pd.DataFrame:
    """Rows of several chunks as one table."""
    given = list(parts)
    return pd.DataFrame({name: np.concatenate([np.asarray(part[name]) for part in given]) for name in given[0]})


def quantile_table(made: ChunkFiles) -> pd.DataFrame:
    """Quantiles of the angles and of the sizes of the reactions, as a tidy table."""
    ensemble = made.ensemble
    value, reached = exact_quantiles(made)
    angles = ensemble.scene.run.samples * ensemble.scene.bars
    attitude = tidy(ensemble, "attitude", "rad", value[:, :angles], reached[:angles])
    if ensemble.scene.bars == 1:
        return attitude
    return pd.concat(
        [attitude, tidy(ensemble, "reaction", "N", value[:, angles:], reached[angles:])], ignore_index=True
    )


def exact_quantiles(made: ChunkFiles) -> tuple[Array, np.ndarray]:
    """Quantiles over the runs of each column, by NumPy's linear definition, and the number of runs that reached it.

    Returns
    -------
    ndarray, shape (quantiles, columns)
        NaN in a column that no run reached.
    ndarray, shape (columns,)
    """
    wanted, count, runs = made.ensemble.quantiles, columns(made.ensemble.scene), made.ensemble.runs
    found, reached = np.full((len(wanted), count), np.nan), np.empty(count, np.int64)
    together = max(1, MOST_SORTED // runs)
    for first in range(0, count, together):
        block = made.samples(first, first + together)
        here = runs - np.isnan(block).sum(axis=1)
        whole = here == runs
        reached[first : first + together] = here
        found[:, first + np.nonzero(whole)[0]] = np.quantile(block[whole], wanted, axis=1)
        for k in np.nonzero(~whole & (here > 0))[0]:
            found[:, first + k] = np.nanquantile(block[k], wanted)
    return found, reached


def tidy(ensemble: Ensemble, quantity: str, unit: str, value: Array, reached: np.ndarray) -> pd.DataFrame:
    """Quantiles of one quantity as a tidy table; columns go item by item of each instant."""
    n = ensemble.scene.run.samples
    shape = (len(ensemble.quantiles), n, value.shape[1] // n)
    return pd.DataFrame(
        {
            "t_s": np.broadcast_to(ensemble.scene.times_s[:, None], shape).ravel(),
            "quantity": quantity,
            "item": np.broadcast_to(np.arange(1, shape[2] + 1), shape).ravel(),
            "quantile": np.broadcast_to(np.asarray(ensemble.quantiles)[:, None, None], shape).ravel(),
            "value": value.ravel(),
            "unit": unit,
            "runs": np.broadcast_to(reached, value.shape).ravel(),
        }
    )
