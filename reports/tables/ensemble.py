"""Stored tables of an ensemble: everything that its page is rendered from.

A folder ``ensemble`` inside a result folder holds

``quantiles.csv``
    one row for each quantity, bar or joint, instant and quantile: ``quantity, item, unit, runs, t_s, quantile, value``;
``record.json``
    the scene, the variations, the outcomes of the runs, and the environment.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.tables.files import read_csv
from reports.tables.schema import read_record

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

FOLDER = "ensemble"
WORDS = ("quantity", "unit")


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
    inside = folder / FOLDER
    return EnsembleTables(read_csv(inside / "quantiles.csv", WORDS), read_record(inside / "record.json"))
