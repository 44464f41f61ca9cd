"""Stored tables of a cost study: everything that its chapter is rendered from.

A folder ``cost`` inside a result folder holds

``points.csv``
    one row for each planned run, columns :data:`POINT_COLUMNS`; errors are the largest over the samples; a cell is
    empty if the engine lacks the quantity or it was not measured; ``kind`` is one of :data:`KINDS` in all tables;
``times.csv``
    every measured time of `simulate`, s, by the point's key;
``orders.csv``, ``reach.csv``, ``price.csv``
    measured orders of convergence; costs to reach an error; cost factors of one more digit;
``loads.csv``
    share of barchain's loads in an engine's time, columns :data:`LOAD_COLUMNS`;
``record.json``
    environment, engines, certified solutions, and skipped pairs with their reasons.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.tables.files import StudyFiles
from reports.tables.schema import Record

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

BASELINE = "reference-fast"  # times are also given relative to this engine's
INDEPENDENT, OWN_EQUATIONS = "independent physics", "barchain's equations"
"""Kinds of engines: those with equations of motion of their own, and integrators of barchain's"""
KINDS = {
    INDEPENDENT: "Engines with independent physics",
    OWN_EQUATIONS: "The reference, and integrators on barchain's equations",
}
"""Headings of both kinds, in the order in which they are shown"""
NOT_RUN = "not run"  # first words of the reason of a skipped point
BUSY = 0.5
"""Processors used by other processes from which on times are not compared with those of other runs: ratios of two
engines then differ by up to a tenth from those on an idle machine"""
TIME_COLUMNS = ("key", "turn", "seconds")
LOAD_COLUMNS = ("scene", "engine", "setting", "kind", "seconds", "seconds_twice", "share", "share_low", "share_high")
POINT_COLUMNS = (
    "scene", "engine", "kind", "setting", "parameter", "value", "step_s", "outcome", "reason",
    "attitude_error_rad", "attitude_floor_rad",
    "reaction_error_N", "reaction_floor_N", "reaction_relative", "reaction_floor_relative",
    "com_error_m", "com_floor_m", "gap_m", "energy_error", "under_floor",
    "seconds", "seconds_low", "seconds_high", "turns", "build_s", "compile_s", "read_s",
    "evaluations", "steps", "on_front", "key",
)  # fmt: skip
WORDS = (
    "scene", "engine", "kind", "setting", "parameter", "outcome", "reason", "under_floor", "status", "fastest",
    "quantity", "against", "measure", "key",
)  # fmt: skip


class CostRecord(Record):
    """Entries of the record."""

    engines: dict[str, dict[str, Any]] | None = None
    scenes: dict[str, dict[str, Any]] | None = None
    certified_solutions: dict[str, dict[str, Any]] | None = None
    left_out: list[dict[str, Any]] | None = None
    shortened_limits_s: dict[str, float] | None = None
    """Limit of a run in the scenes where half of the time was used before all was run"""
    other_processors: float | None = None
    """Mean number of processors that other processes used while times were measured"""


FILES = StudyFiles(
    "cost",
    {"points": POINT_COLUMNS, "times": TIME_COLUMNS, "orders": (), "reach": (), "price": (), "loads": LOAD_COLUMNS},
    WORDS,
    optional=frozenset({"loads"}),
    flags=("on_front",),
    model=CostRecord,
    resumes=True,
    pages=("cost.html",),
)


@dataclass(frozen=True)
class CostTables:
    """Contents of a cost study's folder."""

    points: pd.DataFrame
    orders: pd.DataFrame
    reach: pd.DataFrame
    price: pd.DataFrame
    loads: pd.DataFrame
    record: dict[str, Any]


def read_cost(folder: Path) -> CostTables:
    """Read the cost study in a result folder.

    Raises
    ------
    FileNotFoundError
        If a table is missing.
    SchemaVersionError
        If the record has another schema version.
    """
    tables = FILES.read_all(folder, "points", "orders", "reach", "price", "loads")
    return CostTables(**tables, record=FILES.sound_record(folder))
