"""What of old nights may go: their runs, and nights that no change for the worse is compared with.

Pruning a night that a regression is compared with would turn it green.
"""

from __future__ import annotations

import contextlib
import datetime
import shutil
from typing import TYPE_CHECKING

from barchain.nightly.acceptances import accepted, accepting
from barchain.nightly.changes import Direction
from barchain.nightly.figures import STEPPED
from barchain.nightly.history import latest_first
from barchain.nightly.judging import judge, still_holding
from barchain.nightly.rank_test import FEWEST_NEW, FEWEST_OLD
from barchain.nightly.told import told_by
from barchain.nightly.vanished import OCCASIONS

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path

    from barchain.nightly.acceptances import Acceptance
    from barchain.nightly.changes import Change, JudgedNight
    from barchain.nightly.history import NightStore


RUNS_KEPT = 14
"""Last nights whose runs stay"""
RUNS = ("answers", "trajectories", "differences")
"""Folders of a result folder that hold runs; its rows, tables and records stay"""


def prune_runs(store: NightStore, out: Path) -> None:
    """Remove the runs of the nights before the last ones, unless a night is void or told a change.

    Parameters
    ----------
    store : NightStore
    out : Path
        Folder of all nights, with the results of their parts.
    """
    told = told_by(store)
    for night in latest_first(store.nights())[RUNS_KEPT:]:
        if night.void is None and told.get(night.name, {}).get("changed") == 0:
            for name in RUNS:
                for runs in (out / night.name).glob(f"*/{name}"):
                    with contextlib.suppress(OSError):  # they go with the next night
                        shutil.rmtree(runs)


def needed_nights(store: NightStore) -> frozenset[str]:
    """Names of the nights that tell the changes for the worse which the last night of each machine class holds."""
    now, known = datetime.datetime.now(datetime.UTC), accepted(store)
    last = {night.environment.machine_class: night.name for night in store.nights() if night.void is None}
    judged = [judge(store, night) for night in last.values()]
    return frozenset(
        name
        for each in judged
        for name in (
            *needed_by(each, [c for c in standing(each) if not accepted_for_ever(c, known, now)]),
            *first_nights_of_steps(each),
        )
    )


def standing(judged: JudgedNight) -> list[Change]:
    """Changes for the worse of a night and of earlier ones that hold."""
    return [*(change for change in judged.tonight if change.direction is Direction.WORSE), *still_holding(judged)]


def accepted_for_ever(change: Change, known: Iterable[Acceptance], now: datetime.datetime) -> bool:
    """Whether somebody accepted a change without an end."""
    covering = accepting(change, known, now)
    return covering is not None and covering.until is None


def first_nights_of_steps(judged: JudgedNight) -> Iterator[str]:
    """First nights of the new levels of all steps: told steps and acceptances name them."""
    names = [night.name for night in (*judged.compared_with, judged.night)]
    for change in judged.changes:
        if change.identity.kind in STEPPED:
            since = names.index(change.since)
            yield from names[since : since + FEWEST_NEW]


def needed_by(judged: JudgedNight, changes: Iterable[Change]) -> Iterator[str]:
    """Nights that each change is judged from.

    These are the night on which the earlier level began, the last nights of the same plan before the change, as many as
    a step of noisy figures and a figure that is gone need, and the first ones after it.
    """
    nights = (*judged.compared_with, judged.night)
    names = [night.name for night in nights]
    for change in changes:
        stepped = change.identity.kind in STEPPED
        last, since = names.index(change.last), names.index(change.since)
        alike = [night.name for night in nights[: last + 1] if night.plan == nights[last].plan]
        yield from alike[-(2 * FEWEST_OLD if stepped else OCCASIONS) :]
        yield from names[since : since + (FEWEST_NEW if stepped else 1)]
        yield from (change.level,) if change.level else ()
