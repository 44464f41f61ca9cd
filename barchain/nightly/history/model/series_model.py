"""Figures over nights as the rules of change take them: nights without figures, and one figure over many nights."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from barchain.nightly.history.model.checked_text import MOST_TEXT
from barchain.nightly.history.model.figures import MACHINE, NightPart

if TYPE_CHECKING:
    import datetime
    from collections.abc import Mapping

    from barchain.nightly.history.model.figures import Environment, Figure, FigureIdentity
    from barchain.nightly.run_facts import NightRun


@dataclass(frozen=True)
class NightSummary:
    """Night without its figures."""

    name: str
    started: datetime.datetime
    duration_s: float
    plan: str
    barchain: str
    environment: Environment
    parts: tuple[NightPart, ...]
    figures: int
    """Number of figures"""
    commit: str | None = None
    complete: bool = True
    void: str | None = None
    run: NightRun | None = None
    """What the night did of its plan; None of a night that was added as a result folder"""
    digest: str = ""
    size_B: int = 0
    """Of the file of its figures"""
    added: str = ""
    """Instant at which the history got the night, UTC, ISO 8601; empty where it is not known"""

    @cached_property
    def part_named(self) -> Mapping[str, NightPart]:
        """Parts by name, the machine class among them."""
        machine = NightPart(MACHINE, self.environment.cpu[:MOST_TEXT], self.environment.machine_class)
        return {part.name: part for part in (*self.parts, machine)}

    @property
    def state(self) -> str:
        """State in a word or a reason."""
        return f"void: {self.void}" if self.void else "complete" if self.complete else "incomplete"


@dataclass(frozen=True)
class ValueSeries:
    """Positive values of one figure, for drawing."""

    identity: FigureIdentity
    nights: tuple[str, ...]
    """Names of the nights"""
    values: tuple[float, ...]


@dataclass(frozen=True)
class FigureSeries:
    """One figure over the nights that have it, in their order."""

    identity: FigureIdentity
    nights: tuple[NightSummary, ...]
    figures: tuple[Figure, ...]

    def __post_init__(self) -> None:
        """Check that each figure has its night."""
        if len(self.nights) != len(self.figures):
            raise ValueError(f"{self.identity.name}: {len(self.figures)} figures of {len(self.nights)} nights")
