"""The stored tables of a self-test, from which alone its page is rendered.

A folder ``selftest`` inside a result folder holds

``selftest.csv``
    a row for each fault, scene and quantity, columns :data:`COLUMNS`;
``smallest.csv``
    the smallest size of each continuous fault that is caught, columns :data:`SMALLEST`; only if it was asked for;
``selftest.json``
    the faults and scenes in words, and what ran where.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from reports.tables.files import StudyFiles

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

COLUMNS = ("fault", "scene", "fate", "why", "quantity", "check", "ratio", "killed", "reason")
"""`fate` is that of the fault in the scene, `why` its reason where nothing kills it; `ratio` what was found over what
is allowed, `reason` the check's own words"""
SMALLEST = ("fault", "scene", "caught", "missed", "quantity", "check")
"""Smallest size known to be caught, largest known to be missed; empty where there is none"""
WORDS = ("fault", "scene", "fate", "why", "quantity", "check", "reason")
FILES = StudyFiles(
    "selftest", {"selftest": COLUMNS, "smallest": SMALLEST}, WORDS, frozenset({"smallest"}), "selftest.json"
)


class Fate(StrEnum):
    """What became of a fault in a scene."""

    KILLED = "killed"
    SURVIVES = "survives"
    INVISIBLE = "invisible"
    NOTHING = "nothing to spoil"
    CLEAN = "clean"
    FALSE_ALARM = "false alarm"
    BROKEN = "broken"

    @property
    def advice(self) -> str:
        """Meaning in one sentence."""
        return ADVICE[self]


ADVICE = {
    Fate.KILLED: "A check refuses the spoilt engine.",
    Fate.SURVIVES: "It shows in no check of this scene: all it changes is within what is allowed.",
    Fate.INVISIBLE: "It changes no observable beyond rounding, as was proven and measured.",
    Fate.NOTHING: "The scene has nothing that the fault could spoil.",
    Fate.CLEAN: "A control: nothing is wrong, and no check says so.",
    Fate.FALSE_ALARM: "A control that a check refuses: the check is wrong.",
    Fate.BROKEN: "The spoilt engine fails where it should run: the fault is not put in as it is meant.",
}


@dataclass(frozen=True)
class SelftestTables:
    """A self-test's folder, read."""

    cells: pd.DataFrame
    smallest: pd.DataFrame
    record: dict[str, Any]


def read_selftest(folder: Path) -> SelftestTables:
    """Read the self-test in a result folder.

    Raises
    ------
    FileNotFoundError
        If a table is missing.
    """
    found = FILES.read_all(folder)
    return SelftestTables(found["selftest"], found["smallest"], FILES.read_record(folder))
