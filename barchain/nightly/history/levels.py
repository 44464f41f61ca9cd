"""Levels of figures: the model. What each figure may be, what was told of it last, and the steps that it is above.

Of each figure two questions are kept apart. *What is new?* compares a night with the value that was told last: not with
that of the night before, so that small moves inside an interval can't add up unseen. *What is worse than it was?*
compares with the figure's level. Each piece of news while a figure is above its level is a step; back at its level it
has none.
"""

from __future__ import annotations

from collections.abc import Mapping  # noqa: TC003  # pydantic reads the annotations of files
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar

from barchain.nightly.figures.changes import Change, Direction
from barchain.nightly.figures.figure import EarlierNames, Figure, FigureIdentity  # the same

if TYPE_CHECKING:
    from collections.abc import Callable

    from barchain.nightly.figures.figure import NightSummary


F = TypeVar("F")
"""A figure; in a file its number"""
G = TypeVar("G")


class StepOf(NamedTuple, Generic[F]):
    """News of a figure that is above its level."""

    last: str
    """Name of the last night with the earlier value"""
    night: str
    """Name of the first night with the value"""
    now: F
    settings: tuple[str, ...] = ()
    """Settings of the run before and since, where they differ"""


class LevelOf(NamedTuple, Generic[F]):
    """State of a figure after a night; a named tuple, as each night replaces the states of all figures."""

    level: F
    """What the figure may be"""
    since: str
    """Name of the night on which the level was measured"""
    right: bool
    """Whether the verdict on its run was not that it is wrong"""
    told: F
    """Value that was told last"""
    last: F
    """Latest result that was there"""
    last_night: str
    """Night of the latest result"""
    present: str
    """Latest night with the figure, with or without a result"""
    steps: tuple[StepOf[F], ...] = ()
    """News since the figure is above its level"""
    better: tuple[F, ...] = ()
    """Results of the last nights in a row that were better than the level"""
    seen: tuple[tuple[str, str, str], ...] = ()
    """Of a trajectory: states of its parts, each with its digest and the latest night, the latest one last"""
    content: str = ""
    """Digest of the scene"""
    plan: str = ""
    """Plan of the latest night with the figure"""
    occasions: int = 0
    """Occasions of that plan in a row that had the figure, at most those that count"""
    complete: int = 0
    """Complete nights of that plan in a row that had the figure, at most those that count"""
    left_out: int = 0
    """Nights in a row that had no time for the run"""
    earlier: EarlierNames = ()

    def mapped(self, to: Callable[[F], G], **changes: Any) -> LevelOf[G]:
        """State with something else in the place of each figure, and perhaps with other changes."""
        row: Any = self
        found: LevelOf[G] = row._replace(
            level=to(row.level), told=to(row.told), last=to(row.last), better=tuple(map(to, row.better)),
            steps=tuple(step._replace(now=to(step.now)) for step in row.steps), **changes,
        )  # fmt: skip
        return found


Step = StepOf[Figure]
Level = LevelOf[Figure]


@dataclass(frozen=True)
class LevelTable:
    """Levels of all figures after a night."""

    night: str = ""
    """Name of the last night; empty before the first"""
    plan: str = ""
    folded: tuple[tuple[str, str, bool], ...] = ()
    """Names of all nights that count, each with the digest of its figures, and whether it came late"""
    rows: Mapping[FigureIdentity, Level] = field(default_factory=dict)


@dataclass(frozen=True)
class FoldedNight:
    """Levels after a night, and what the night tells."""

    table: LevelTable
    news: tuple[Change, ...] = ()
    """Changes against what was told last, other than steps of times and memory"""
    judged: int = 0
    """Figures that have an earlier one, those among them that are gone since tonight"""
    same: int = 0
    """Figures that differ from the night before within rounding or their intervals"""
    new: int = 0
    """Figures without an earlier one, other than of studies that do other scenes each night"""
    left_out: int = 0
    """Figures of the night before that this night lacks, if that night had another plan"""
    renamed: tuple[str, ...] = ()
    """Settings and scenes that have other names since this night"""


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
    def is_first(self) -> bool:
        """Whether no night came before; one that is pruned did."""
        return len(self.table.folded) <= 1

    @property
    def replanned(self) -> bool:
        """Whether the night before had another plan."""
        return bool(self.compared_with) and self.compared_with[-1].plan != self.night.plan

    @property
    def worse(self) -> bool:
        """Whether this night tells a change for the worse."""
        return any(change.direction is Direction.WORSE for change in self.tonight)
