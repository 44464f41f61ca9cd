"""Nights that changes for the worse are compared with: pruning them would turn a regression green."""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.nightly.history.changes.model import Direction
from barchain.nightly.history.judged import judge
from barchain.nightly.telling.facts import still_holding

if TYPE_CHECKING:
    from collections.abc import Iterator

    from barchain.nightly.history.changes.judging import JudgedNight
    from barchain.nightly.history.store import NightStore


def needed_nights(store: NightStore) -> frozenset[str]:
    """Names of the nights that tell the changes for the worse which the last night of each machine class holds."""
    last = {night.environment.machine_class: night.name for night in store.nights() if night.void is None}
    return frozenset(name for night in last.values() for name in needed_by(judge(store, night)))


def needed_by(judged: JudgedNight) -> Iterator[str]:
    """Last night before each standing change, the one before that, and the first night after."""
    names = [night.name for night in (*judged.compared_with, judged.night)]
    worse = [change for change in judged.tonight if change.direction is Direction.WORSE]
    for change in (*worse, *still_holding(judged)):
        place = names.index(change.last)
        yield from (*names[max(place - 1, 0) : place + 1], change.since)
