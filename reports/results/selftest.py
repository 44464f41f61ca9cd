"""Rows of a self-test, as the tables that its page is rendered from.

``fates``
    a row for each fault and scene: its outcome, and the reason of an undetected fault;
``readings``
    a row for each check that compared a quantity there: the value found relative to the allowed one, and the check's
    own words.
"""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, Any

from reports.results.files import StudyFiles
from reports.results.rows import Followed
from reports.results.schema import StudyRecord
from reports.results.table import Table

if TYPE_CHECKING:
    from collections.abc import Mapping

CAUGHT, MISSED = "size_caught", "size_missed"
"""Metrics of the rows of a continuous fault, on request: smallest size known to be detected, whose text is the quantity
that detects it, and largest size known to be undetected"""


class FaultOutcome(StrEnum):
    """Outcome of a fault in a scene."""

    KILLED = "killed"
    SURVIVES = "survives"
    INVISIBLE = "invisible"
    NOTHING = "not applicable"
    CLEAN = "clean"
    FALSE_ALARM = "false alarm"
    BROKEN = "broken"

    @property
    def advice(self) -> str:
        """Meaning of the outcome."""
        return ADVICE[self]


ADVICE = {
    FaultOutcome.KILLED: "A check rejects the faulty engine.",
    FaultOutcome.SURVIVES: "No check of this scene detects the fault: all its changes are within the tolerances.",
    FaultOutcome.INVISIBLE: "The fault changes no observable beyond rounding, as proven and measured.",
    FaultOutcome.NOTHING: "The fault does not apply to the scene.",
    FaultOutcome.CLEAN: "A control that every check accepts.",
    FaultOutcome.FALSE_ALARM: "A control that a check rejects: the check is wrong.",
    FaultOutcome.BROKEN: "The faulty engine fails where it should run: the fault is implemented wrongly.",
}


TABLES = {
    "fates": Table(("fault", "scene"), "fate", {"fate": ".outcome", "why": ".reason"}),
    "readings": Table(
        ("fault", "scene", "quantity", "check"),
        "ratio",
        {"ratio": ".value", "killed": ".outcome", "reason": ".reason"},
    ),
}
KILLED = "killed"
"""Outcome of a reading that rejects the faulty engine; any other one is empty"""
FOLLOWED = {"fate": Followed("verdict", setting="{fault}")}


def host_of(record: Mapping[str, Any]) -> dict[str, str]:
    """Engine of all rows."""
    return {"engine": str(record.get("host") or "")}


FILES = StudyFiles(
    "selftest",
    TABLES,
    followed=FOLLOWED,
    place=host_of,
    model=StudyRecord,
    title="Detection of inserted faults",
    view="selftest:view_selftest",
)
