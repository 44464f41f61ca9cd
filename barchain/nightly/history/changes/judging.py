"""Judgement of a night: all figures by the rules of their kinds, against the earlier nights."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING

from barchain.nightly.history.changes.bits import bit_changes
from barchain.nightly.history.changes.levels import RULES, level_changes, same_changes
from barchain.nightly.history.changes.model import Change, Direction
from barchain.nightly.history.changes.renames import continued
from barchain.nightly.history.changes.times import FALSE_ALARMS, time_changes
from barchain.nightly.history.changes.vanished import SAMPLED, vanished
from barchain.nightly.history.changes.verdicts import without_mended
from barchain.nightly.history.model.figures import STEPPED

if TYPE_CHECKING:
    from collections.abc import Sequence

    from barchain.nightly.history.changes.times import ToldChanges
    from barchain.nightly.history.changes.vanished import Presence
    from barchain.nightly.history.model.series_model import FigureSeries, NightSummary


@dataclass(frozen=True)
class JudgedNight:
    """Night with its changes."""

    night: NightSummary
    compared_with: tuple[NightSummary, ...]
    """Earlier nights that it was judged against, in their order"""
    changes: tuple[Change, ...] = ()
    """All changes over these nights, in the order of the nights; those that are not reproducible first"""
    tonight: tuple[Change, ...] = ()
    """Those that this night tells first"""
    same: tuple[Change, ...] = ()
    """Differences of this night from the one before that rounding or intervals explain"""
    judged: int = 0
    """Figures that have an earlier one, those among them that are gone since tonight"""
    new: int = 0
    """Figures of this night that have no earlier one, other than of studies that do other scenes each night"""
    left_out: int = 0
    """Figures of the night before that this night lacks, if that night had another plan"""
    renamed: tuple[str, ...] = ()
    """Settings and scenes that have other names since this night"""

    @property
    def replanned(self) -> bool:
        """Whether the night before had another plan."""
        return bool(self.compared_with) and self.compared_with[-1].plan != self.night.plan

    @property
    def worse(self) -> bool:
        """Whether this night tells a change for the worse."""
        return any(change.direction is Direction.WORSE for change in self.tonight)


def judge_night(
    series: Sequence[FigureSeries],
    nights: Sequence[NightSummary],
    false_alarms: float = FALSE_ALARMS,
    presence: Presence | None = None,
    told: ToldChanges = MappingProxyType({}),
) -> JudgedNight:
    """Judge the last of some nights.

    Parameters
    ----------
    series : sequence of FigureSeries
        All figures over these nights.
    nights : sequence of NightSummary
        In their order. Void nights are left out; a void night is not judged.
    false_alarms : float
        Probability of a false alarm in a night, of times and memory together.
    presence : Presence, optional
        Nights on which scenes and figures were measured, for figures that are gone; default: those of `series`.
    told : mapping
        Steps of times and memory that earlier nights told, by name of the figure.
    """
    tonight = nights[-1]
    if tonight.void is not None:
        return JudgedNight(tonight, ())
    kept = comparable(nights)
    own, renames = continued([one for one in (restricted(each, kept) for each in series) if one.nights])
    alike = same_class(kept)
    current = [one for one in own if one.nights[-1].name == tonight.name]
    settled = without_mended(
        change
        for one in own
        if one.identity.kind not in STEPPED
        for change in (level_changes(one) if one.identity.kind in RULES else bit_changes(one))
    )
    noisy = [restricted(one, alike) for one in own if one.identity.kind in STEPPED]
    stepped, fresh = time_changes([one for one in noisy if one.nights], false_alarms, told)
    gone = vanished(own, kept, presence)
    changes = sorted([*settled, *stepped, *gone], key=lambda c: (not c.irreproducible, c.since))
    steps = {change.id for change in stepped}
    new = [c for c in changes if c.since == tonight.name and c.id not in steps]
    return JudgedNight(
        tonight, tuple(kept[:-1]), tuple(changes), (*new, *fresh),
        tuple(c for one in current if one.identity.kind in RULES for c in same_changes(one)),
        sum(len(one.nights) > 1 for one in current) + sum(c.since == tonight.name for c in gone),
        sum(len(one.nights) == 1 and not one.identity.quantity.startswith(SAMPLED) for one in current),
        left_out(own, kept), tuple(one.words for one in renames if one.since == tonight.name),
    )  # fmt: skip


def left_out(series: Sequence[FigureSeries], nights: Sequence[NightSummary]) -> int:
    """Number of figures that the night before had last, if it had another plan than the last one."""
    if len(nights) < 2 or nights[-2].plan == nights[-1].plan:
        return 0
    return sum(one.nights[-1].name == nights[-2].name for one in series)


def comparable(nights: Sequence[NightSummary]) -> list[NightSummary]:
    """Nights that the last one is judged against, and itself: those of its machine class, and all before the first.

    A change that came with a new machine stands on its later nights, too.
    """
    believed = [night for night in nights if night.void is None]
    own = same_class(believed)
    return [*believed[: believed.index(own[0])], *own]


def same_class(nights: Sequence[NightSummary]) -> list[NightSummary]:
    """Nights of the machine class of the last one."""
    return [n for n in nights if n.environment.machine_class == nights[-1].environment.machine_class]


def restricted(series: FigureSeries, nights: Sequence[NightSummary]) -> FigureSeries:
    """Series over some nights only."""
    names = {night.name for night in nights}
    kept = [k for k, night in enumerate(series.nights) if night.name in names]
    if len(kept) == len(series.nights):
        return series
    return replace(series, nights=tuple(series.nights[k] for k in kept), figures=tuple(series.figures[k] for k in kept))
