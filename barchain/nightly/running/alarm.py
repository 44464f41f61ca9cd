"""Test of the alarm: the planted faults of a night, as the tables of the self-test tell."""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.nightly.run_facts import AlarmTest
from barchain.studies.selftest.faults.catalogue import CONTROLS
from reports.tables.faults.selftest import FILES, FaultOutcome, read_selftest

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

NOT_PLANTED = {str(FaultOutcome.NOTHING), str(FaultOutcome.INVISIBLE)}
"""Outcomes of faults that change nothing"""
REJECTED = {str(FaultOutcome.FALSE_ALARM), str(FaultOutcome.BROKEN)}
"""Outcomes of an unmodified engine that must not be"""


def alarm_test(folder: Path, seed: int = 0) -> AlarmTest | None:
    """Result of the planted faults in a result folder; None if the self-test did not come to its end.

    A fault is missed if no check detects it in any scene in which it changes anything. So is a fault that does not
    run as it should: nobody knows whether it would be detected.
    """
    if not FILES.has_record(folder) or not FILES.sound_record(folder).get("complete"):
        return None
    tables = read_selftest(folder)
    unmodified = tables.cells["fault"].isin(list(CONTROLS))
    faults, controls = tables.cells[~unmodified], tables.cells[unmodified]
    planted = set(faults.loc[~faults["fate"].isin(NOT_PLANTED), "fault"])
    broken = set(faults.loc[faults["fate"] == str(FaultOutcome.BROKEN), "fault"])
    killed = set(faults.loc[faults["fate"] == str(FaultOutcome.KILLED), "fault"])
    rejected = set(controls.loc[controls["fate"].isin(REJECTED), "scene"])
    return AlarmTest(len(planted), tuple(sorted(planted - killed | broken)), seed, tuple(sorted(rejected)))


def together(tests: Iterable[AlarmTest]) -> AlarmTest | None:
    """Several tests of one night as one; None without any."""
    found = list(tests)
    if not found:
        return None
    missed = tuple(fault for test in found for fault in test.missed)
    wrong = tuple(scene for test in found for scene in test.false_alarms)
    return AlarmTest(sum(test.planted for test in found), missed, found[0].seed, wrong)
