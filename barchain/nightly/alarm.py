"""Test of a night's alarm by planted faults: a night that misses one is void."""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.faults.catalogue import CONTROLS
from reports.tables.faults.selftest import FILES, FaultOutcome, read_selftest
from reports.tables.nights.facts import AlarmTest

if TYPE_CHECKING:
    from pathlib import Path


NOT_PLANTED = {str(FaultOutcome.NOTHING), str(FaultOutcome.INVISIBLE)}
"""Outcomes of faults that change nothing"""
REJECTED = {str(FaultOutcome.FALSE_ALARM), str(FaultOutcome.BROKEN)}
"""Outcomes of an unmodified engine that must not be"""


def alarm_test(folder: Path) -> AlarmTest | None:
    """Result of the planted faults in a result folder; None if none was tried to its end.

    A fault is missed if no check detects it in any scene in which it changes anything. So is a fault that does not
    run as it should: nobody knows whether it would be detected. Of a self-test that was interrupted, those faults count
    that have their result in all of their scenes.
    """
    if not FILES.has_record(folder):
        return None
    tables = read_selftest(folder)
    unmodified = tables.fates["fault"].isin(list(CONTROLS))
    faults, controls = tables.fates[~unmodified], tables.fates[unmodified]
    if not tables.record.get("complete"):
        scenes = set(tables.record.get("scenes") or ())
        tried = {name for name, rows in faults.groupby("fault") if scenes and scenes <= set(rows["scene"])}
        faults = faults[faults["fault"].isin(tried)]
    planted = set(faults.loc[~faults["fate"].isin(NOT_PLANTED), "fault"])
    broken = set(faults.loc[faults["fate"] == str(FaultOutcome.BROKEN), "fault"])
    killed = set(faults.loc[faults["fate"] == str(FaultOutcome.KILLED), "fault"])
    rejected = set(controls.loc[controls["fate"].isin(REJECTED), "scene"])
    if not planted and not rejected:
        return None
    return AlarmTest(len(planted), tuple(sorted(planted - killed | broken)), false_alarms=tuple(sorted(rejected)))
