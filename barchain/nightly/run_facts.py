"""What a night did of its plan: the parts that ran or were left, and the test of its alarm by planted faults."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Sequence

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
