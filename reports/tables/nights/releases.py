"""Stored tables of a study of releases: everything that its chapter is rendered from.

A folder ``releases`` inside a result folder holds

``releases.csv``
    one row for each release, columns :data:`RELEASES`; sizes in bytes, times in s;
``errors.csv``
    largest errors of each release against the judging solution, columns :data:`ERRORS`;
``runs.csv``
    digest of the trajectory and number of steps of each release in each scene, columns :data:`RUNS`;
``times.csv``
    times at equal error relative to the anchor, columns :data:`TIMES`;
``record.json``
    engine, scenes, and environment.
"""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, Any

from reports.tables.files import StudyFiles
from reports.tables.rows import BITS, COUNT, Rows, known, records
from reports.tables.schema import Record

if TYPE_CHECKING:
    from pathlib import Path

RELEASES = (
    "engine", "version", "released", "state", "reason", "wheel_B", "installed_B",
    "import_s", "import_low", "import_high", "moved",
)  # fmt: skip
ERRORS = ("engine", "version", "scene", "quantity", "unit", "value", "rounding", "verdict", "reason")
RUNS = ("engine", "version", "scene", "setting", "trajectory", "steps")
TIMES = ("engine", "version", "scene", "target", "anchor", "ratio", "low", "high")
WORDS = (
    "engine", "version", "released", "state", "reason", "moved", "scene", "quantity", "unit", "verdict", "setting",
    "trajectory", "target", "anchor",
)  # fmt: skip


class ReleaseState(StrEnum):
    """State of a release."""

    RUNS = "runs"
    FAILS = "does not run"
    NOT_INSTALLED = "can't be installed"


class ReleasesRecord(Record):
    """Entries of the record."""

    engine: str | None = None
    distribution: str | None = None
    scenes: dict[str, dict[str, Any]] | None = None
    anchor: str | None = None
    versions: list[str] | None = None


FILES = StudyFiles(
    "releases",
    {"releases": RELEASES, "errors": ERRORS, "runs": RUNS, "times": TIMES},
    WORDS,
    frozenset({"errors", "runs", "times"}),
    model=ReleasesRecord,
    pages=("releases.html",),
)


read_releases = FILES.contents


MEASURED = {
    "wheel_B": ("wheel", "size", "B"), "installed_B": ("installation", "size", "B"),
    "import_s": ("import", "seconds", "s"),
}  # fmt: skip


def releases_rows(folder: Path) -> Rows:
    """Rows of a study of releases; the tag `version` is a release."""
    tables, found = read_releases(folder), Rows(FILES.name)
    for row in records(tables.releases):
        where = {name: row[name] for name in ("engine", "version")}
        found.add("state", outcome=row["state"], reason=row["reason"], text=row["released"], **where)
        found.measured(row, MEASURED, **where)
    for row in records(tables.errors):
        where = {name: row[name] for name in ("engine", "version", "scene", "quantity")}
        said = {"outcome": row["verdict"], "reason": row["reason"]}
        found.add("error", row["value"], row["unit"], **said, **where)
        if known(row["rounding"]):
            found.add("rounding", row["rounding"], row["unit"], **where)
    for row in records(tables.runs):
        where = {name: row[name] for name in ("engine", "version", "scene", "setting")}
        found.add(BITS, text=row["trajectory"], **where)
        found.measured(row, {"steps": ("steps", COUNT, "1")}, **where)
    for row in records(tables.times):
        where = {name: row[name] for name in ("engine", "version", "scene")}
        ends = {"low": row["low"], "high": row["high"]}
        found.add("time_ratio", row["ratio"], setting=row["target"], relative_to=row["anchor"], **ends, **where)
    return found
