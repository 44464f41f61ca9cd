"""A judged night: what it tells, and what its figures are."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from barchain.nightly.changes import Direction

if TYPE_CHECKING:
    from collections.abc import Mapping

    from barchain.nightly.changes import Change
    from barchain.nightly.figures import FigureIdentity, NightSummary
    from barchain.nightly.levels import EarlierNames, Level


@dataclass(frozen=True)
class JudgedNight:
    """Night with its changes."""

    night: NightSummary
    compared_with: tuple[NightSummary, ...]
    """Earlier nights that it was judged against, in their order"""
    tonight: tuple[Change, ...] = ()
    """Changes that this night tells first; those that are not reproducible come first"""
    stepped: tuple[Change, ...] = ()
    """All steps of times and memory over these nights"""
    above: Mapping[FigureIdentity, Level] = field(default_factory=dict)
    """Figures that are worse than their levels"""
    judged: int = 0
    """Figures that have an earlier one, those among them that are gone since tonight"""
    same: int = 0
    """Figures that differ from the night before within rounding or their intervals"""
    new: int = 0
    """Figures of this night that have no earlier one, other than of studies that do other scenes each night"""
    left_out: int = 0
    """Figures of the night before that this night lacks, if that night had another plan"""
    renamed: tuple[str, ...] = ()
    """Settings and scenes that have other names since this night"""
    earlier: Mapping[FigureIdentity, EarlierNames] = field(default_factory=dict)
    """Earlier names of the figures that had others, each with its last night"""
    so_far: str = ""
    """What moved most among times and memory that have too few nights for a step"""

    @property
    def by_name(self) -> dict[str, NightSummary]:
        """All of these nights by name."""
        return {night.name: night for night in (*self.compared_with, self.night)}

    @property
    def replanned(self) -> bool:
        """Whether the night before had another plan."""
        return bool(self.compared_with) and self.compared_with[-1].plan != self.night.plan

    @property
    def worse(self) -> bool:
        """Whether this night tells a change for the worse."""
        return any(change.direction is Direction.WORSE for change in self.tonight)
