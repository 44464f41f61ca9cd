"""Stored tables of an ensemble: everything that its page is rendered from.

A folder ``ensemble`` inside a result folder holds

``quantiles.csv``
    tidy: a row for each instant, quantity, item (bar or joint, from 1) and quantile, columns :data:`QUANTILE_COLUMNS`;
    ``runs`` is the number of runs that reached the instant, ``error_bound`` the largest error of an estimated quantile,
    0 of an exact one;
``runs.csv``
    a row for each run: the drawn values, the outcome (finished, ended or failed), its reason, steps, evaluations;
``record.json``
    the scene, the distributions, counts of outcomes, wall time of each phase, and the provenance.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.tables.files import StudyFiles
from reports.tables.schema import Record

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

QUANTILE_COLUMNS = ("t_s", "quantity", "item", "quantile", "value", "unit", "runs", "error_bound")


class EnsembleRecord(Record):
    """Entries of the record."""

    scene: dict[str, Any] | None = None
    vary: list[str] | None = None
    runs: int | None = None
    rtol: float | None = None
    seed: int | None = None
    key: str | None = None
    estimated: dict[str, float] | None = None
    """Of quantiles estimated from counts in bins: largest error relative to the distance from the median of the first
    runs, and their number; None of exact quantiles"""
    outcomes: dict[str, int] | None = None
    phases_s: dict[str, float] | None = None
    evaluations: int | None = None


WORDS = ("quantity", "unit", "outcome", "reason")
FILES = StudyFiles(
    "ensemble",
    {"quantiles": QUANTILE_COLUMNS, "runs": ()},
    WORDS,
    model=EnsembleRecord,
    resumes=True,
    pages=("ensemble.html",),
)


@dataclass(frozen=True)
class EnsembleTables:
    """Contents of an ensemble's folder."""

    quantiles: pd.DataFrame
    record: dict[str, Any]


def read_ensemble(folder: Path) -> EnsembleTables:
    """Read the ensemble in a result folder.

    Raises
    ------
    FileNotFoundError
        If a file is missing.
    SchemaVersionError
        If the record has another schema version.
    """
    return EnsembleTables(FILES.read(folder, "quantiles"), FILES.sound_record(folder))
