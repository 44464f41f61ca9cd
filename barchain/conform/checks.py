"""Checks of an engine: what was found, in which group, where the convention stands."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from enum import StrEnum
from typing import Any


class CheckState(StrEnum):
    """Result of a check."""

    PASSED = "passed"
    WARNING = "warning"
    """Something that users of the engine should know; no failure"""
    UNSUPPORTED = "unsupported"
    """The engine declares that it can't do this"""
    NOT_RUN = "not run"
    """An earlier failure makes the check meaningless"""
    FAILED = "failed"


PASSED, WARNING, UNSUPPORTED, NOT_RUN, FAILED = CheckState


class Group(StrEnum):
    """Groups of checks, in the order in which they run."""

    LOADING = "loading"
    CONVENTIONS = "conventions"
    PHYSICS = "physics"
    ACCURACY = "accuracy"
    BEHAVIOUR = "behaviour"


@dataclass(frozen=True)
class Check:
    """One check of an engine."""

    group: Group = field(default=Group.LOADING, kw_only=True)
    """Set, as the time, by the examination"""
    name: str
    state: CheckState
    words: str = ""
    """What was found, in one line"""
    page: str = ""
    """Page and section that state the convention; that of the group where it is empty"""
    explained: bool = False
    """Whether a known mistake explains the failure"""
    scene: str = ""
    """Scene that shows a failure: `barchain compare SCENE --engine NAME` runs it again"""
    seconds: float = 0.0
    """Time since the check before"""
    stops: bool = True
    """Whether a failure makes the stages after it meaningless; that of rounding does not"""


@dataclass(frozen=True)
class ConformanceReport:
    """All checks of one engine."""

    engine: str
    version: str
    checks: tuple[Check, ...]
    seconds: float
    whole: bool = True
    """Whether all groups and scenes were examined"""

    @property
    def passed(self) -> bool:
        """Whether no check failed and at least one was passed; of the whole, one on a scene of the physics."""
        return not self.failures and self.agreed

    @property
    def agreed(self) -> bool:
        """Whether a scene of the physics was passed; of a part, whether a check beyond loading was made, if any is."""
        if self.whole:
            return any(c.group is Group.PHYSICS and c.state is CheckState.PASSED for c in self.checks)
        beyond = [c.state for c in self.checks if c.group is not Group.LOADING]
        return not beyond or any(state in (CheckState.PASSED, CheckState.WARNING) for state in beyond)

    @property
    def verdict(self) -> str:
        """Result in words; a part of the examination is no conformance."""
        if self.whole:
            return "conforms" if self.passed else "does not conform"
        if not self.failures and not self.agreed:
            return "supports nothing of this part of the examination"
        return f"{'passes' if self.passed else 'fails'} a part of the examination"

    @property
    def failures(self) -> tuple[Check, ...]:
        """Checks that failed."""
        return tuple(c for c in self.checks if c.state is CheckState.FAILED)

    def as_dict(self) -> dict[str, Any]:
        """Content as JSON values."""
        return {
            "engine": self.engine, "version": self.version, "passed": self.passed, "whole": self.whole,
            "seconds": round(self.seconds, 3),
            "checks": [
                {key: str(value) for key, value in asdict(c).items()}
                | {"explained": c.explained, "stops": c.stops, "seconds": round(c.seconds, 3)}
                for c in self.checks
            ],
        }  # fmt: skip
