"""Stored tables of a scaling study: everything that its chapter is rendered from.

A folder ``scaling`` inside a result folder holds

``points.csv``
    one row for each engine and number of bars, columns :data:`POINT_COLUMNS`; times in s, memory in bytes, counts and
    times of an orbit scaled up from the part that was run; a cell is empty without a measurement;
``fits.csv``
    exponents against the number of bars, columns :data:`FIT_COLUMNS`;
``record.json``
    environment, engines, and targets of the compiled reference.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.tables.files import StudyFiles
from reports.tables.schema import Record

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

POINT_COLUMNS = (
    "engine", "bars", "outcome", "reason",
    "evaluation_s", "evaluation_low", "evaluation_high", "per",
    "orbit_s", "orbit_low", "orbit_high", "share", "simulate_s", "turns",
    "evaluations", "steps", "build_s", "memory_B",
)  # fmt: skip
FIT_COLUMNS = ("engine", "quantity", "per", "exponent", "low", "high", "points", "bars_from", "bars_to")
WORDS = ("engine", "outcome", "reason", "per", "quantity")


class ScalingRecord(Record):
    """Entries of the record."""

    engines: dict[str, dict[str, Any]] | None = None
    bars: list[int] | None = None
    scene: dict[str, Any] | None = None
    targets: list[dict[str, Any]] | None = None
    other_processors: float | None = None
    """Mean number of processors that other processes used while times were measured"""


FILES = StudyFiles(
    "scaling",
    {"points": POINT_COLUMNS, "fits": FIT_COLUMNS},
    WORDS,
    model=ScalingRecord,
    resumes=True,
    pages=("scaling.html",),
)


@dataclass(frozen=True)
class ScalingTables:
    """Contents of a scaling study's folder."""

    points: pd.DataFrame
    fits: pd.DataFrame
    record: dict[str, Any]


def read_scaling(folder: Path) -> ScalingTables:
    """Read the scaling study in a result folder.

    Raises
    ------
    FileNotFoundError
        If a table is missing.
    SchemaVersionError
        If the record has another schema version.
    """
    return ScalingTables(**FILES.read_all(folder), record=FILES.sound_record(folder))
