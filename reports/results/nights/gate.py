"""Result of a gate: what two builds of an engine differ in, and the answer. It is told, and never stored."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from reports.results.nights.document import ChangeEntry


@dataclass(frozen=True)
class GateResult:
    """What changed from one build of an engine to another one."""

    answer: str
    """Sentence that opens the comment"""
    engine: str
    base: str
    """As it was given"""
    head: str
    worse: tuple[ChangeEntry, ...]
    """Changes for the worse that are not listed as known failures"""
    listed: tuple[tuple[ChangeEntry, str], ...]
    """Those that are, each with its entry in words"""
    better: tuple[ChangeEntry, ...]
    changed: tuple[ChangeEntry, ...]
    """Neither better nor worse, other than bits"""
    ended: tuple[str, ...]
    """Known failures whose day has come"""
    passing: tuple[str, ...]
    """Known failures that fail no more"""
    notes: tuple[str, ...]
    """What was compared, and what was not"""

    @property
    def failed(self) -> bool:
        """Whether the gate stays closed."""
        return bool(self.worse or self.ended)
