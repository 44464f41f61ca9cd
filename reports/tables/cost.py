"""The stored tables of a cost study, from which alone its chapter is rendered.

A folder ``cost`` inside a result folder holds

``points.csv``
    one row for each run asked for, columns :data:`POINT_COLUMNS`; errors are the largest over the samples, an
    empty cell is what the engine has not got or what was not measured;
``times.csv``
    every measured time of `simulate`, s, by the point's key;
``orders.csv``, ``reach.csv``, ``price.csv``
    measured orders of convergence; what it costs to reach an error; the price of one more digit;
``run.json``
    what ran where, the engines, the certified solutions, and what was left out with its reason.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.tables.files import StudyFiles

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

BASELINE = "reference-fast"  # times are also given over this engine's
TIME_COLUMNS = ("key", "turn", "seconds")
POINT_COLUMNS = (
    "scene", "engine", "setting", "parameter", "value", "step_s", "outcome", "reason",
    "attitude_error_rad", "attitude_floor_rad",
    "reaction_error_N", "reaction_floor_N", "reaction_relative", "reaction_floor_relative",
    "com_error_m", "com_floor_m", "gap_m", "energy_error", "under_floor",
    "seconds", "seconds_low", "seconds_high", "turns", "build_s", "compile_s", "read_s",
    "evaluations", "steps", "on_front", "key",
)  # fmt: skip
WORDS = ("scene", "engine", "setting", "outcome", "reason", "under_floor", "status", "fastest", "quantity", "against")
FILES = StudyFiles(
    "cost",
    {"points": POINT_COLUMNS, "times": TIME_COLUMNS, "orders": (), "reach": (), "price": ()},
    WORDS,
    record="run.json",
)


@dataclass(frozen=True)
class CostTables:
    """A cost study's folder, read."""

    points: pd.DataFrame
    orders: pd.DataFrame
    reach: pd.DataFrame
    price: pd.DataFrame
    record: dict[str, Any]


def read_cost(folder: Path) -> CostTables:
    """Read the cost study in a result folder.

    Raises
    ------
    FileNotFoundError
        If a table is missing.
    """
    tables = FILES.read_all(folder, "points", "orders", "reach", "price")
    return CostTables(**tables, record=FILES.read_record(folder))
