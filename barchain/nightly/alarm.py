"""Test of a night's alarm by planted faults: a night that misses one is void."""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.faults.catalogue import CONTROLS
from reports.tables.faults.selftest import FILES, FaultOutcome, read_selftest
from reports.tables.nights.facts import AlarmTest

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    import pandas as pd


NOT_PLANTED = {str(FaultOutcome.NOTHING), str(FaultOutcome.INVISIBLE)}
"""Outcomes of faults that change nothing"""
REJECTED = {str(FaultOutcome.FALSE_ALARM), str(FaultOutcome.BROKEN)}
"""Outcomes of an unmodified engine that must not be"""


def alarm_test(folder: Path, seed: int = 0) -> AlarmTest | None:
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
        faults = faults[faults["fault"].isin(tried_everywhere(faults, set(tables.record.get("scenes") or ())))]
    planted = set(faults.loc[~faults["fate"].isin(NOT_PLANTED), "fault"])
    broken = set(faults.loc[faults["fate"] == str(FaultOutcome.BROKEN), "fault"])
    killed = set(faults.loc[faults["fate"] == str(FaultOutcome.KILLED), "fault"])
    rejected = set(controls.loc[controls["fate"].isin(REJECTED), "scene"])
    if not planted and not rejected:
        return None
    return AlarmTest(len(planted), tuple(sorted(planted - killed | broken)), seed, tuple(sorted(rejected)))


def tried_everywhere(faults: pd.DataFrame, scenes: set[str]) -> set[str]:
    """Faults that have a result in all scenes."""
    return {str(name) for name, rows in faults.groupby("fault") if scenes and scenes <= set(rows["scene"])}


def together(tests: Iterable[AlarmTest]) -> AlarmTest | None:
    """Several tests of one night as one; None without any."""
    found = list(tests)
    if not found:
        return None
    missed = tuple(fault for test in found for fault in test.missed)
    wrong = tuple(scene for test in found for scene in test.false_alarms)
    return AlarmTest(sum(test.planted for test in found), missed, found[0].seed, wrong)
