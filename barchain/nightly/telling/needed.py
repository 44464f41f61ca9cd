"""Nights that changes for the worse are compared with: pruning them would turn a regression green."""

from __future__ import annotations

import datetime
from typing import TYPE_CHECKING

from barchain.nightly.history.changes.accepted import accepting
from barchain.nightly.history.changes.model import Direction
from barchain.nightly.history.judged import accepted, judge
from barchain.nightly.telling.facts import still_holding

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from barchain.nightly.history.changes.judging import JudgedNight
    from barchain.nightly.history.changes.model import Change
    from barchain.nightly.history.store import NightStore


def needed_nights(store: NightStore) -> frozenset[str]:
    """Names of the nights that tell the changes for the worse which the last night of each machine class holds."""
    now, known = datetime.datetime.now(datetime.UTC), accepted(store)
    last = {night.environment.machine_class: night.name for night in store.nights() if night.void is None}
    judged = [judge(store, night) for night in last.values()]
    return frozenset(
        name
        for each in judged
        for name in needed_by(each, [c for c in standing(each) if accepting(c, known, now) is None])
    )


def standing(judged: JudgedNight) -> list[Change]:
    """Changes for the worse of a night and of earlier ones that hold."""
    return [*(change for change in judged.tonight if change.direction is Direction.WORSE), *still_holding(judged)]


def needed_by(judged: JudgedNight, changes: Iterable[Change]) -> Iterator[str]:
    """Last night before each change, the one before that, and the first night after."""
    names = [night.name for night in (*judged.compared_with, judged.night)]
    for change in changes:
        place = names.index(change.last)
        yield from (*names[max(place - 1, 0) : place + 1], change.since)
