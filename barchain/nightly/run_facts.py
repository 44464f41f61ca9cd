"""What a night did of its plan, and the test of its alarm by planted faults."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from reports.tables.faults.selftest import FILES, FaultOutcome, read_selftest

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from pathlib import Path

    import pandas as pd


INTERRUPTED = "the night was interrupted"
"""Reason of a part that was left because its night ended early: it says nothing of the time that the part needs"""
NAMED = 3
"""Names in a sentence about many"""
MOST_NAME = 80
"""Characters of a name in a sentence"""


class PartState(StrEnum):
    """State of a part of a plan at the end of its night."""

    DONE = "done"
    LEFT = "left"
    """Some or all of it did not fit into the night, and goes first on the next one"""
    FAILED = "failed"
    """It ended with an error"""


@dataclass(frozen=True)
class PartResult:
    """Part of a plan at the end of its night."""

    name: str
    state: PartState
    share_s: float
    """Time that it was given"""
    duration_s: float = 0.0
    left: tuple[str, ...] = ()
    """What of the part did not fit: scenes, or the whole part by its name"""
    reason: str = ""
    """Why the part was left or failed"""
    done: int = 0
    """Number of its items (scenes, faults) that were done"""
    command: str = ""
    """Command that repeats the part"""
    missing: str = ""
    """Why engines or scenes that the part names did not run; the others did"""
    bad_input: bool = False
    """Whether a scene of the part can't be read"""


def some_of(names: Sequence[str]) -> str:
    """Names in a sentence, which a history has room for: the first ones, and how many more there are."""
    shown = [name if len(name) <= MOST_NAME else f"{name[: MOST_NAME - 3]}..." for name in names]
    if len(shown) <= NAMED + 1:
        return ", ".join(shown)
    return f"{', '.join(shown[:NAMED])} and {len(shown) - NAMED} more"


@dataclass(frozen=True)
class AlarmTest:
    """Planted faults of a night, and those that no check told."""

    planted: int
    missed: tuple[str, ...] = ()
    """Faults that no check detected: one is enough to make a night void"""
    seed: int = 0
    false_alarms: tuple[str, ...] = ()
    """Scenes in which a check rejected the unmodified engine: one is enough to make a night void"""

    @property
    def void(self) -> str | None:
        """Why the night can't be believed; None if the alarm rang when and only when it had to."""
        if self.missed:
            return f"{len(self.missed)} of {self.planted} planted faults missed: {some_of(self.missed)}"
        if self.false_alarms:
            return f"a check rejects the unmodified engine in {some_of(self.false_alarms)}"
        return None


@dataclass(frozen=True)
class NightRun:
    """What a night did of its plan."""

    plan: str
    """Name of the plan, with the digest of its content"""
    minutes: float
    """Budget"""
    parts: tuple[PartResult, ...] = ()
    alarm: AlarmTest | None = None
    """None if the plan plants no faults, or the night ended before"""
    turn: int = 0
    """Number of the night among those of its plan: decides scenes, faults and seeds that change from night to night"""

    @property
    def complete(self) -> bool:
        """Whether all parts were done, with all engines that they name."""
        return bool(self.parts) and all(part.state is PartState.DONE and not part.missing for part in self.parts)

    def to_json(self) -> str:
        """Content as JSON."""
        return json.dumps(asdict(self), allow_nan=False)

    @classmethod
    def from_json(cls, text: str) -> NightRun:
        """Run from :meth:`to_json`.

        Raises
        ------
        ValueError
            If the text is something else.
        """
        try:
            found = json.loads(text)
            parts = tuple(part_of(entry) for entry in found["parts"])
            alarm = found["alarm"] and AlarmTest(**tuples(found["alarm"]))
            return cls(found["plan"], found["minutes"], parts, alarm, found["turn"])
        except (KeyError, TypeError) as error:
            raise ValueError(f"no run of a night: {error}") from None


def part_of(entry: dict[str, Any]) -> PartResult:
    """Part of an entry of the JSON."""
    return PartResult(**(tuples(entry) | {"state": PartState(str(entry["state"]))}))


def tuples(entry: dict[str, Any]) -> dict[str, Any]:
    """Entry with tuples for JSON's lists."""
    return {name: tuple(value) if isinstance(value, list) else value for name, value in entry.items()}


def scene_name(given: str) -> str:
    """Name of a scene in tables: of a file the file's name without its ending."""
    return given.rpartition("/")[2].removesuffix(".toml") if given.endswith(".toml") else given


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
    from barchain.faults.catalogue import CONTROLS  # noqa: PLC0415  # heavy

    if not FILES.has_record(folder) or not FILES.has(folder, "selftest"):
        return None
    tables = read_selftest(folder)
    unmodified = tables.selftest["fault"].isin(list(CONTROLS))
    faults, controls = tables.selftest[~unmodified], tables.selftest[unmodified]
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
