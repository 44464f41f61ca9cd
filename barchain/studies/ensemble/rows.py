"""Rows of an ensemble's runs: values drawn, outcomes, counts; as columns and as text of a CSV table."""

from __future__ import annotations

import csv
import io
from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from adapters.trajectory import Array
    from barchain.studies.ensemble.population import Population
    from barchain.studies.ensemble.task_results import EnsembleTaskResult
    from barchain.studies.ensemble.tasks import EnsembleTask
    from barchain.studies.ensemble.variation import Variation

FAILED, ENDED, FINISHED = "failed", "ended", "finished"
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


def run_columns(task: EnsembleTask, result: EnsembleTaskResult, variations: Iterable[Variation]) -> RunColumns:
    """Rows of the runs of a part."""
    columns: RunColumns = {"run": np.arange(task.first + 1, task.first + task.part.runs + 1)}
    for v in variations:
        columns |= drawn_columns(task.part, v)
    pairs = list(zip(result.ended, result.failed, strict=True))
    columns["outcome"] = [FAILED if failed else ENDED if ended else FINISHED for ended, failed in pairs]
    columns["reason"] = [failed or ended for ended, failed in pairs]
    columns["steps"], columns["evaluations"] = result.seen.steps.astype(int), result.seen.evaluations.astype(int)
    return columns


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


def table(parts: list[RunColumns]) -> pd.DataFrame:
    """Rows of several parts as one table."""
    return pd.DataFrame({name: np.concatenate([np.asarray(part[name]) for part in parts]) for name in parts[0]})


def header_text(rows: RunColumns) -> bytes:
    """First line of the CSV table."""
    return csv_text([tuple(rows)])


def rows_text(rows: RunColumns) -> bytes:
    """Lines of the CSV table, as pandas would write them at five times the cost."""
    words = {name: list(rows[name]) for name in ("outcome", "reason")}
    return csv_text(
        zip(*(words.get(name) or np.asarray(column).tolist() for name, column in rows.items()), strict=True)
    )


def csv_text(lines: Iterable[Sequence[Any]]) -> bytes:
    """Lines of a CSV table."""
    sink = io.StringIO()
    csv.writer(sink, lineterminator="\n").writerows(lines)
    return sink.getvalue().encode("utf-8")
