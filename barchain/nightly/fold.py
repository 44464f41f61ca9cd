"""Fold of the nights of a history: which nights a night is judged from, and in which order.

A night is judged from the earlier ones of its machine class. The first of a class is judged from the nights of another
class that were there before, so that a change that came with a new machine stands on its later nights.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from barchain.nightly.advance import advance
from barchain.nightly.figures import STEPPED
from barchain.nightly.level_files import FILE, keep_levels, read_levels
from barchain.nightly.levels import FoldedNight, LevelTable
from barchain.nightly.table import read_figures
from barchain.nightly.told import told_by

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from barchain.nightly.figures import NightSummary
    from barchain.nightly.history import NightStore


def folded_night(store: NightStore, chosen: NightSummary, every: Sequence[NightSummary]) -> FoldedNight:
    """Levels after a night, and what it tells: those that its folder keeps, else folded from the nights before.

    Kept levels hold as long as each night that they fold is as it was. A night that was there when they were folded and
    is gone since has been pruned.

    Parameters
    ----------
    store : NightStore
    chosen : NightSummary
    every : sequence of NightSummary
        Nights of the history in their order.
    """
    wrong = {*store.left_out(), *(night.name for night in every if night.void is not None)}
    nights = [night for night in every if night.name not in wrong]
    return folded_of_nights(store, chosen, nights, wrong)


def folded_of_nights(
    store: NightStore, chosen: NightSummary, nights: Sequence[NightSummary], wrong: Collection[str]
) -> FoldedNight:
    """Levels after one of the nights that count; `wrong` names those that don't: what folds them is folded again."""
    place = {night.name: k for k, night in enumerate(nights)}
    own = [night for night in nights[: place[chosen.name] + 1] if is_same_class(night, chosen)]
    kept, base = kept_levels(store, own, {night.name: night.digest for night in nights}, wrong)
    if kept is not None and base is not None and base.name == chosen.name:
        return kept
    others = [night for night in nights[: place[own[0].name]] if night.added <= own[0].added]
    if kept is not None:
        table = kept.table
    elif others:
        table = without_times(folded_of_nights(store, others[-1], nights, wrong).table)
    else:
        table = LevelTable()
    known = {name for name, _, _ in table.folded}
    missing = [night for night in own if night.name not in known]
    late = late_nights(missing, own, told_at(store) if len(missing) > 1 else {})
    late |= {night.name for night in missing if base is not None and night.started < base.started}
    found = FoldedNight(table)
    for night, content in store.contents(missing):
        is_late = night.name in late and night.name != chosen.name
        found = advance(found.table, night, read_figures(content), late=is_late)
    if found.table.night == chosen.name:  # else it is damaged
        keep_levels(store.place, found)
    return found


def is_same_class(night: NightSummary, other: NightSummary) -> bool:
    """Whether two nights are of one machine class."""
    return night.environment.machine_class == other.environment.machine_class


def kept_levels(
    store: NightStore, own: Sequence[NightSummary], digests: Mapping[str, str], wrong: Collection[str]
) -> tuple[FoldedNight, NightSummary] | tuple[None, None]:
    """Levels of the latest night that keeps some that hold, and that night."""
    there = {name.partition("/")[0] for name in store.place.sizes(f"*/{FILE}")}
    for night in reversed(own):
        found = read_levels(store.place, night) if night.name in there else None
        if found is not None and not any(
            name in wrong or digests.get(name, digest) != digest for name, digest, _ in found.table.folded
        ):
            return found, night
    return None, None


def without_times(table: LevelTable) -> LevelTable:
    """Levels of one machine class from which the first night of another one is judged: it has other times."""
    return replace(table, rows={i: row for i, row in table.rows.items() if i.kind not in STEPPED})


def told_at(store: NightStore) -> dict[str, str]:
    """Instants at which nights told their changes, by name."""
    return {name: facts.told for name, facts in told_by(store).items() if facts.told}


def late_nights(some: Sequence[NightSummary], own: Sequence[NightSummary], told: Mapping[str, str]) -> set[str]:
    """Names of those nights that were added after a later night of their class had told its changes."""
    return {
        night.name
        for night in some
        if any(other.started > night.started and night.added > told.get(other.name, night.added) for other in own)
    }
