"""Stored tables of a comparison: everything that a report is rendered from.

A result folder holds

``metrics.csv``
    tidy, one value a row, columns :data:`METRIC_COLUMNS`. An engine in parentheses stands for several engines
    together, or for a missing reference solution; the scene :data:`ALL_SCENES` for all scenes together;
``run.json``
    provenance, scenes, engines, and the outcome of every run;
``trajectories/<scene>/<engine>.parquet``
    one row per sample; ``solution.parquet`` is the reference solution;
``differences/<scene>/<engine>.parquet``
    ``t_s`` and, for each compared quantity q: ``q_difference``, ``q_tolerance`` (the explained part) and
    ``q_bound`` (the expected-error bound), each the largest over the quantity's components;
    for each drift d: ``d_drift``, ``d_bound``;
``differences/<scene>/amplification.parquet``
    ``t_s, amplification``: factor by which a small perturbation of the attitude has grown.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import pandas as pd

from reports.tables.cells import from_cells
from reports.tables.schema import SchemaVersionError, read_record

if TYPE_CHECKING:
    from pathlib import Path

METRIC_COLUMNS = (
    "scene",
    "engine",
    "setting",
    "quantity",
    "metric",
    "value",
    "unit",
    "tolerance",
    "outcome",
    "reason",
    "limit_s",
)
QUANTITY_UNITS = {
    "com": "m",
    "com_velocity": "m/s",
    "attitude": "rad",
    "rate": "rad/s",
    "reaction": "N",
    "torque": "N m",
    "impulse": "N s",
    "gap": "m",
    "com_residual": "m",
    "energy": "1",
    "angular_momentum": "1",
    "relative_energy": "1",
    "run": "",
}
SOLUTION, AMPLIFICATION = "solution", "amplification"
REFERENCE_SOLUTION = "(reference solution)"
"""Stands in the engine column for a scene's reference solution that could not be run"""
ALL_SCENES = "(all scenes)"
"""Stands in the scene column of a row about an engine in all scenes together"""


@dataclass(frozen=True)
class Results:
    """Contents of a result folder."""

    folder: Path
    metrics: pd.DataFrame
    record: dict[str, Any]
    """Contents of run.json"""

    def trajectory(self, scene: str, engine: str) -> pd.DataFrame | None:
        """Samples of one run, or None if it left none."""
        return read_parquet(self.folder / "trajectories" / scene / f"{engine}.parquet")

    def differences(self, scene: str, engine: str) -> pd.DataFrame | None:
        """Differences from the reference solution over time, or None without any."""
        return read_parquet(self.folder / "differences" / scene / f"{engine}.parquet")


def is_engine(name: str) -> bool:
    """Whether a name in the engine column is that of one engine."""
    return bool(name) and not name.startswith("(")


def read_parquet(path: Path) -> pd.DataFrame | None:
    """Table at `path`, or None without a file."""
    return pd.read_parquet(path) if path.is_file() else None


class DamagedResultsError(ValueError):
    """Raised for a result folder with damaged files."""


def read_results(folder: Path) -> Results:
    """Read a result folder.

    Raises
    ------
    FileNotFoundError
        If it holds no ``metrics.csv`` or no ``run.json``.
    DamagedResultsError
        If one of them can't be read, or ``metrics.csv`` lacks a column.
    SchemaVersionError
        If the record has another schema version.
    """
    for name in ("metrics.csv", "run.json"):
        if not (folder / name).is_file():
            raise FileNotFoundError(f"{folder}: no {name} there; give a folder that compare or crossval wrote")
    empty = {"value": [""], "tolerance": [""], "limit_s": [""]}
    try:
        record = read_record(folder / "run.json")
        metrics = from_cells(pd.read_csv(folder / "metrics.csv", keep_default_na=False, na_values=empty))
    except SchemaVersionError:
        raise
    except ValueError as error:  # pandas' and json's own are ValueErrors
        raise DamagedResultsError(f"{folder}: metrics.csv or run.json is damaged: {error}") from None
    lacking = [name for name in METRIC_COLUMNS if name not in metrics]
    if lacking:
        there = ", ".join(map(str, metrics.columns))
        raise DamagedResultsError(f"{folder}/metrics.csv lacks {', '.join(lacking)}; it has: {there}")
    return Results(folder, metrics, record)
