"""Stored tables of a scaling study: everything that its chapter is rendered from.

A folder ``scaling`` inside a result folder holds

``points.csv``
    one row for each engine and number of bars, columns :data:`POINT_COLUMNS`; times in s, memory in bytes, counts and
    times of an orbit scaled up from the part that was run; a cell is empty without a measurement;
``record.json``
    environment, engines, and targets of the compiled reference.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from reports.tables.cost import BASELINE, busy_machine
from reports.tables.files import StudyFiles
from reports.tables.rows import COUNT, NOT_COMPARED, Followed, Rows, known, records, split_not_run
from reports.tables.schema import Record

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

POINT_COLUMNS = (
    "engine", "bars", "outcome", "reason",
    "evaluation_s", "evaluation_low", "evaluation_high", "per",
    "orbit_s", "orbit_low", "orbit_high", "share", "simulate_s", "turns",
    "evaluations", "steps", "build_s", "memory_B",
)  # fmt: skip
WORDS = ("engine", "outcome", "reason", "per")


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
    {"points": POINT_COLUMNS},
    WORDS,
    model=ScalingRecord,
    pages=("scaling.html",),
)


POINTS = {
    "evaluation_s": ("evaluation", "seconds", "s"), "orbit_s": ("orbit", "seconds", "s"),
    "simulate_s": ("simulate", "seconds", "s"), "build_s": ("build", "seconds", "s"),
    "share": ("orbit", "share", "1"), "turns": ("evaluation", "turns", "1"),
    "evaluations": ("evaluations", COUNT, "1"), "steps": ("steps", COUNT, "1"), "memory_B": ("", "memory", "B"),
}  # fmt: skip
"""Quantity, metric and unit of the columns of `points`"""
FITTED = ("points", "bars_from", "bars_to")
"""Metrics of the range of an exponent"""
FOLLOWED = {
    "outcome": Followed("verdict", setting="bars={bars:g}"),
    "memory": Followed("memory", setting="bars={bars:g}"),
    "evaluation_ratio": Followed("ratio", setting="bars={bars:g}"),
}


def scaling_rows(folder: Path) -> Rows:
    """Rows of a scaling study: its points, and times relative to the baseline's with as many bars."""
    record, points = FILES.sound_record(folder), FILES.read(folder, "points")
    found = Rows(FILES.name, str((record.get("scene") or {}).get("name") or ""))
    busy, rows = busy_machine(record), list(records(points))
    anchors = {row["bars"]: row for row in rows if row["engine"] == BASELINE}
    for row in rows:
        where = {name: row[name] for name in ("engine", "bars")}
        outcome, reason = split_not_run(row["outcome"], row["reason"])
        found.add("outcome", outcome=outcome, reason=reason, text=row["per"], **where)
        found.measured(row, POINTS, **where)
        if row["engine"] != BASELINE and row["bars"] in anchors:
            add_ratio(found, row, anchors[row["bars"]], busy, where)
    return found


def add_ratio(found: Rows, row: Mapping[str, Any], anchor: Mapping[str, Any], busy: str, where: dict[str, Any]) -> None:
    """Add the ratio of two times; its interval spans both. `busy` is the reason why it tells nothing."""
    mine, base = row["evaluation_s"], anchor["evaluation_s"]
    if not known(mine) or not known(base) or not base:
        return
    low, high = (
        over(row["evaluation_low"], anchor["evaluation_high"]),
        over(row["evaluation_high"], anchor["evaluation_low"]),
    )
    said: dict[str, Any] = {"outcome": NOT_COMPARED, "reason": busy} if busy else {}
    found.add("evaluation_ratio", mine / base, low=low, high=high, relative_to=BASELINE, **said, **where)


def over(a: float, b: float) -> float | None:
    """Ratio of two numbers; None if one is unknown."""
    return a / b if known(a) and known(b) and b else None
