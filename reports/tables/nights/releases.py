"""Rows of a study of releases, as the tables that its chapter is rendered from.

``releases``
    a row for each release; sizes in bytes, times in s;
``errors``
    largest errors of each release against the judging solution;
``runs``
    digest of the trajectory and number of steps of each release in each scene;
``times``
    times at equal error relative to the anchor.
"""

from __future__ import annotations

from enum import StrEnum

from reports.tables.files import StudyFiles
from reports.tables.rows import BITS, COUNT, RELATIVE_TO
from reports.tables.schema import StudyRecord
from reports.tables.table import Number, Table


class ReleaseState(StrEnum):
    """State of a release."""

    RUNS = "runs"
    FAILS = "does not run"
    NOT_INSTALLED = "can't be installed"


RELEASE = ("engine", "version")
TABLES = {
    "releases": Table(
        RELEASE,
        "state",
        {"outcome": "state", "reason": "reason", "text": "released"},
        numbers={
            "wheel_B": Number("wheel", "size", "B"),
            "installed_B": Number("installation", "size", "B"),
            "import_s": Number("import", "seconds", "s", "import_low", "import_high"),
        },
        words=("moved",),
    ),
    "errors": Table(
        (*RELEASE, "scene", "quantity"),
        "error",
        {"value": "value", "unit": "unit", "outcome": "verdict", "reason": "reason"},
        numbers={"rounding": Number("", "rounding")},
    ),
    "runs": Table(
        (*RELEASE, "scene", "setting"), BITS, {"text": "trajectory"}, numbers={"steps": Number("steps", COUNT)}
    ),
    "times": Table(
        (*RELEASE, "scene", "target", "anchor"),
        "time_ratio",
        {"value": "ratio", "low": "low", "high": "high"},
        named={"target": "setting", "anchor": RELATIVE_TO},
    ),
}


FILES = StudyFiles("releases", TABLES, model=StudyRecord, title="Releases of an engine", view="releases:view_releases")
read_releases = FILES.contents
