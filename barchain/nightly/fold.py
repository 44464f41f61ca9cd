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
from barchain.nightly.told import told_by

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from barchain.nightly.figures import NightSummary
    from barchain.nightly.history import NightStore


def folded_night(store: NightStore, chosen: NightSummary) -> FoldedNight:
    """Levels after a night, and what it tells: those that its folder keeps, else folded from the nights before.

    Kept levels hold as long as each night that they fold is as it was. A night that was there when they were folded and
    is gone since has been pruned.
    """
    nights = [night for night in store.nights() if night.void is None]
    own = [night for night in upto(nights, chosen) if is_same_class(night, chosen)]
    kept, base = kept_levels(store, own, damaged(store))
    if kept is not None and base is not None and base.name == chosen.name:
        return kept
    table = kept.table if kept is not None else levels_of_other_class(store, nights, own[0])
    known = {name for name, _, _ in table.folded}
    missing = [night for night in own if night.name not in known]
    late = late_nights(missing, own, told_at(store) if len(missing) > 1 else {})
    late |= {night.name for night in missing if base is not None and night.started < base.started}
    found, figures = FoldedNight(table), store.table()
    for night in missing:
        is_late = night.name in late and night.name != chosen.name
        found = advance(found.table, night, figures.of_night(night.name), late=is_late)
    keep_levels(store.place, found)
    return found


def upto(nights: Sequence[NightSummary], chosen: NightSummary) -> list[NightSummary]:
    """Nights in their order, up to one."""
    return list(nights[: [night.name for night in nights].index(chosen.name) + 1])


def is_same_class(night: NightSummary, other: NightSummary) -> bool:
    """Whether two nights are of one machine class."""
    return night.environment.machine_class == other.environment.machine_class


def damaged(store: NightStore) -> set[str]:
    """Names of nights that are void, or can't be read: what was folded with them is folded again without them."""
    return {*store.left_out(), *(night.name for night in store.nights() if night.void is not None)}


def kept_levels(
    store: NightStore, own: Sequence[NightSummary], wrong: Collection[str]
) -> tuple[FoldedNight, NightSummary] | tuple[None, None]:
    """Levels of the latest night that keeps some that hold, and that night."""
    there = {name.partition("/")[0] for name in store.place.sizes(f"*/{FILE}")}
    digests = {night.name: night.digest for night in store.nights()}
    for night in reversed(own):
        found = read_levels(store.place, night) if night.name in there else None
        if found is not None and not any(
            name in wrong or digests.get(name, digest) != digest for name, digest, _ in found.table.folded
        ):
            return found, night
    return None, None


def levels_of_other_class(store: NightStore, nights: Sequence[NightSummary], first: NightSummary) -> LevelTable:
    """Levels from which the first night of a machine class is judged: without times, which another machine has not."""
    before = [
        night for night in upto(nights, first)
        if night is not first and night.void is None and night.added <= first.added and not is_same_class(night, first)
    ]  # fmt: skip
    if not before:
        return LevelTable()
    table = folded_night(store, before[-1]).table
    rows = {identity: row for identity, row in table.rows.items() if identity.kind not in STEPPED}
    return replace(table, rows=rows)


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
