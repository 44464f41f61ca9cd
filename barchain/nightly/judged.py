"""A judged night: what it tells, and what its figures are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from barchain.nightly.changes import Direction
from barchain.nightly.levels import FoldedNight

if TYPE_CHECKING:
    from collections.abc import Mapping

    from barchain.nightly.changes import Change
    from barchain.nightly.figures import EarlierNames, FigureIdentity, NightSummary
    from barchain.nightly.levels import Level


@dataclass(frozen=True, kw_only=True)
class JudgedNight(FoldedNight):
    """Folded night with the nights that it was compared with, and the steps of times and memory over all of them."""

    night: NightSummary
    compared_with: tuple[NightSummary, ...] = ()
    """Earlier nights that it was judged against, in their order"""
    stepped: tuple[Change, ...] = ()
    """All steps of times and memory over these nights"""
    fresh: tuple[Change, ...] = ()
    """Those of them that this night tells first"""
    so_far: str = ""
    """What moved most among times and memory that have too few nights for a step"""

    @property
    def tonight(self) -> tuple[Change, ...]:
        """Changes that this night tells first; those that are not reproducible come first."""
        return (*self.news, *self.fresh)

    @property
    def above(self) -> Mapping[FigureIdentity, Level]:
        """Figures that are worse than their levels."""
        return {identity: row for identity, row in self.table.rows.items() if row.steps}

    @property
    def earlier(self) -> Mapping[FigureIdentity, EarlierNames]:
        """Earlier names of the figures that had others, each with its last night."""
        return {identity: row.earlier for identity, row in self.table.rows.items() if row.earlier}

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
