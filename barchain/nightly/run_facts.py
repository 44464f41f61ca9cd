"""What a night did of its plan: the parts that ran or were left, and the test of its alarm by planted faults."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class PartState(StrEnum):
    """State of a part of a plan at the end of its night."""

    DONE = "done"
    LEFT = "left"
    """It did not fit into the night and goes first on the next one"""
    FAILED = "failed"
    """It ended with an error"""


@dataclass(frozen=True)
class PartResult:
    """Part of a plan at the end of its night."""

    name: str
    state: PartState
    share_s: float
    """Share of the budget"""
    duration_s: float = 0.0
    left: tuple[str, ...] = ()
    """What of the part did not fit, in words, e.g. scenes or engines"""
    reason: str = ""
    """Why the part was left or failed"""


@dataclass(frozen=True)
class AlarmTest:
    """Planted faults of a night, and those that no check told."""

    planted: int
    missed: tuple[str, ...] = ()
    """Faults that no check detected: one is enough to make a night void"""
    seed: int = 0


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

    @property
    def complete(self) -> bool:
        """Whether all parts were done."""
        return all(part.state is PartState.DONE for part in self.parts)
