"""Mistakes that engines make: in what is read out of the right motion, in its start, or in its equations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.trajectory import Trajectory
    from scenarios import Scene

    ReadingChange = Callable[[Scene, Trajectory], Trajectory]

PAGE = "docs/explanation/engine_conventions.md"


@dataclass(frozen=True)
class Mistake:
    """A known mistake of an engine or its adapter."""

    name: str
    """Short name in lower case, with hyphens"""
    sentence: str
    """Subject and verb without a full stop; the first word is `the`"""
    section: str
    """Heading of the section in :data:`PAGE` that states the convention, as an anchor"""

    @property
    def anchor(self) -> str:
        """Page and section that state the right convention."""
        return f"{PAGE}#{self.section}"


@dataclass(frozen=True)
class ReadingMistake(Mistake):
    """Altered reading of the right motion, computed on arrays."""

    read: ReadingChange
    """Trajectory of an engine with this mistake, from the scene and the right trajectory"""
    any_turns: bool = False
    """Whether the angles may differ by whole turns, 2 pi times a constant integer for each bar"""


@dataclass(frozen=True)
class TimingMistake(Mistake):
    """Samples of some channels taken too late or too early."""

    late_samples: float
    """Delay of the reading: sample k holds the state of sample k minus this number; -1, -1/2, 1/2 or 1"""
    fields: tuple[str, ...]
    """Arrays of `Trajectory` that are delayed"""
