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

from reports.results.files import StudyFiles
from reports.results.rows import BITS, RELATIVE_TO
from reports.results.schema import StudyRecord
from reports.results.table import Table


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
        {
            "state": ".outcome", "reason": ".reason", "released": ".text",
            "wheel_B": "size:wheel B", "installed_B": "size:installation B",
            "import_s": "seconds:import s", "import_low": "seconds:import.low", "import_high": "seconds:import.high",
            "moved": "moved.text",
        },
    ),
    "errors": Table(
        (*RELEASE, "scene", "quantity"),
        "error",
        {"value": ".value", "unit": ".unit", "verdict": ".outcome", "reason": ".reason", "rounding": "rounding"},
    ),
    "runs": Table((*RELEASE, "scene", "setting"), BITS, {"trajectory": ".text", "steps": "count:steps"}),
    "times": Table(
        (*RELEASE, "scene", "setting", RELATIVE_TO),
        "time_ratio",
        {"ratio": ".value", "low": ".low", "high": ".high"},
    ),
}  # fmt: skip


FILES = StudyFiles("releases", TABLES, model=StudyRecord, title="Releases of an engine", view="releases:view_releases")
