"""The stored tables of a scaling study: what its chapter is rendered from, and nothing else is needed.

A folder ``scaling`` inside a result folder holds

``points.csv``
    one row for each engine and number of bars, columns :data:`POINT_COLUMNS`; times in s, memory in bytes, counts and
    times of an orbit scaled up from the share that was run; an empty cell is what was not measured;
``fits.csv``
    exponents against the number of bars, columns :data:`FIT_COLUMNS`;
``record.json``
    what ran where, the engines, and what is asked of the compiled reference.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import pandas as pd

if TYPE_CHECKING:
    from pathlib import Path

FOLDER = "scaling"
POINT_COLUMNS = (
    "engine", "bars", "outcome", "reason",
    "evaluation_s", "evaluation_low", "evaluation_high", "per",
    "orbit_s", "orbit_low", "orbit_high", "share", "simulate_s", "turns",
    "evaluations", "steps", "build_s", "memory_B",
)  # fmt: skip
FIT_COLUMNS = ("engine", "quantity", "per", "exponent", "low", "high", "points", "bars_from", "bars_to")
WORDS = ("engine", "outcome", "reason", "per", "quantity")


@dataclass(frozen=True)
class ScalingTables:
    """A scaling study's folder, read."""

    points: pd.DataFrame
    fits: pd.DataFrame
    record: dict[str, Any]


def read_scaling(folder: Path) -> ScalingTables:
    """Read the scaling study in a result folder.

    Raises
    ------
    FileNotFoundError
        If a table is missing.
    """
    inside = folder / FOLDER
    points, fits = (read_table(inside / f"{name}.csv") for name in ("points", "fits"))
    return ScalingTables(points, fits, json.loads((inside / "record.json").read_text(encoding="utf-8")))


def read_table(path: Path) -> pd.DataFrame:
    """Read a table; words are words even where they are empty, other empty cells are NaN."""
    table = pd.read_csv(path, keep_default_na=False, na_values=[""])
    for name in WORDS:
        if name in table:
            table[name] = table[name].astype(object).fillna("").astype(str)
    return table
