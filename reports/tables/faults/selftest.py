"""Stored tables of a self-test: everything that its page is rendered from.

A folder ``selftest`` inside a result folder holds

``selftest.csv``
    a row for each fault, scene and quantity, columns :data:`COLUMNS`;
``record.json``
    faults and scenes in words, and environment.
"""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, Any

from reports.tables.files import StudyFiles
from reports.tables.rows import Followed, Rows, known, records
from reports.tables.schema import Record

if TYPE_CHECKING:
    from pathlib import Path

COLUMNS = ("fault", "scene", "fate", "why", "quantity", "check", "ratio", "killed", "reason")
"""`fate`: outcome of the fault in the scene; `why`: reason of an undetected fault; `ratio`: value found relative to the
allowed value; `reason`: the check's own words"""
CAUGHT, MISSED = "size_caught", "size_missed"
"""Metrics of the rows of a continuous fault, on request: smallest size known to be detected, whose text is the quantity
that detects it, and largest size known to be undetected"""
WORDS = ("fault", "scene", "fate", "why", "quantity", "check", "reason")


class SelftestRecord(Record):
    """Entries of the record."""

    host: str | None = None
    roles: list[str] | None = None
    scenes: dict[str, dict[str, Any]] | None = None
    faults: dict[str, dict[str, Any]] | None = None
    passed: bool | None = None
    unkilled: list[str] | None = None


FILES = StudyFiles(
    "selftest",
    {"selftest": COLUMNS},
    WORDS,
    flags=("killed",),
    model=SelftestRecord,
    pages=("selftest.html",),
)


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


read_selftest = FILES.contents


FOLLOWED = {"fate": Followed("verdict", setting="{fault}")}


def selftest_rows(folder: Path) -> Rows:
    """Rows of a self-test: the outcome of each fault in each scene, and the worst of each check."""
    tables, found = read_selftest(folder), Rows(FILES.name)
    host = str(tables.record.get("host") or "")
    worst: dict[tuple[str, ...], dict[str, Any]] = {}
    for row in records(tables.selftest):
        worst.setdefault((row["scene"], row["fault"]), row)
        key: tuple[str, ...] = (row["scene"], row["fault"], row["quantity"], row["check"])
        if known(row["ratio"]) or row["killed"] is True:
            worst[key] = max(worst.get(key, row), row, key=lambda r: (r["killed"] is True, r["ratio"]))
    for place, row in worst.items():
        where = {"scene": row["scene"], "engine": host, "fault": row["fault"]}
        if len(place) == len(("scene", "fault")):
            found.add("fate", outcome=row["fate"], reason=row["why"], **where)
        else:
            said = {"outcome": "killed" if row["killed"] is True else "", "reason": row["reason"]}
            found.add("ratio", row["ratio"], quantity=row["quantity"], check=row["check"], **said, **where)
    return found
