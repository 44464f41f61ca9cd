"""The stored tables of a comparison, from which alone a report is rendered.

A result folder holds

``metrics.csv``
    tidy, one value a row, columns :data:`METRIC_COLUMNS`; an engine in parentheses stands for what was asked of
    several together, which the report works out itself, or for the reference solution where a scene has none; the scene
    :data:`ALL_SCENES` for what is said of an engine in all scenes together;
``run.json``
    what ran where, see :class:`RunRecord`;
``trajectories/<scene>/<engine>.parquet``
    one row per sample; ``solution.parquet`` is the reference at its tightest;
``differences/<scene>/<engine>.parquet``
    ``t_s`` and, for each compared quantity q: ``q_difference``, ``q_tolerance`` (what both errors explain) and
    ``q_band`` (what the engine's setting should reach), each the largest over the quantity's components;
    for each drift d: ``d_drift``, ``d_band``;
``differences/<scene>/amplification.parquet``
    ``t_s, growth``: how many times a small perturbation of the attitude has grown.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import pandas as pd

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
    "identity": "m",
    "energy": "1",
    "angular_momentum": "1",
    "relative_energy": "1",
    "run": "",
}
SOLUTION, AMPLIFICATION = "solution", "amplification"
REFERENCE_SOLUTION = "(reference solution)"
"""Stands in the engine column for a scene's reference solution, where that could not be run"""
ALL_SCENES = "(all scenes)"
"""Stands in the scene column of what is said of an engine in all scenes together"""


@dataclass(frozen=True)
class Results:
    """A result folder, read."""

    folder: Path
    metrics: pd.DataFrame
    record: dict[str, Any]
    """Contents of run.json"""

    def trajectory(self, scene: str, engine: str) -> pd.DataFrame | None:
        """Samples of one run, or None if it left none."""
        return read_parquet(self.folder / "trajectories" / scene / f"{engine}.parquet")

    def differences(self, scene: str, engine: str) -> pd.DataFrame | None:
        """Differences from the reference solution over time, or None if there are none."""
        return read_parquet(self.folder / "differences" / scene / f"{engine}.parquet")


def is_engine(name: str) -> bool:
    """Whether a name in the engine column is that of one engine."""
    return bool(name) and not name.startswith("(")


def read_parquet(path: Path) -> pd.DataFrame | None:
    """Table at `path`, or None if there is none."""
    return pd.read_parquet(path) if path.is_file() else None


class DamagedResultsError(ValueError):
    """A result folder with damaged files."""


def read_results(folder: Path) -> Results:
    """Read a result folder.

    Raises
    ------
    FileNotFoundError
        If it holds no ``metrics.csv`` or no ``run.json``.
    DamagedResultsError
        If one of them can't be read, or ``metrics.csv`` lacks a column.
    """
    for name in ("metrics.csv", "run.json"):
        if not (folder / name).is_file():
            raise FileNotFoundError(f"{folder}: no {name} there; give a folder that compare or crossval wrote")
    empty = {"value": [""], "tolerance": [""], "limit_s": [""]}
    try:
        metrics = pd.read_csv(folder / "metrics.csv", keep_default_na=False, na_values=empty)
        record = json.loads((folder / "run.json").read_text(encoding="utf-8"))
    except ValueError as error:  # pandas' and json's own are ValueErrors
        raise DamagedResultsError(f"{folder}: metrics.csv or run.json is damaged: {error}") from None
    lacking = [name for name in METRIC_COLUMNS if name not in metrics]
    if lacking:
        there = ", ".join(map(str, metrics.columns))
        raise DamagedResultsError(f"{folder}/metrics.csv lacks {', '.join(lacking)}; it has: {there}")
    return Results(folder, metrics, record)
