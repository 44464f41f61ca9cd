"""What of old nights may go: their runs, and nights that no change for the worse is compared with.

Pruning a night that a regression is compared with would turn it green.
"""

from __future__ import annotations

import contextlib
import shutil
from typing import TYPE_CHECKING

from barchain.nightly.figures.changes import Direction
from barchain.nightly.figures.rank_test import FEWEST_NEW, FEWEST_OLD
from barchain.nightly.history.judging import FILE, latest_judged
from barchain.nightly.history.news import told_by
from barchain.nightly.history.nights import latest_first

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.nightly.history.nights import NightStore


RUNS_KEPT = 14
"""Last nights whose runs and levels stay"""
RUNS = ("answers", "trajectories", "differences")
"""Folders of a result folder that hold runs; its rows, tables and records stay"""


def prune_runs(store: NightStore, out: Path) -> None:
    """Remove runs and levels of the nights before the last ones.

    Runs stay where a night is void or told a change, levels on the last night of each machine class: those of other
    nights are folded again where somebody asks for them.

    Parameters
    ----------
    store : NightStore
    out : Path
        Folder of all nights, with the results of their parts.
    """
    told, nights = told_by(store), store.nights()
    newest = {night.environment.machine_class: night.name for night in nights if night.void is None}
    levels = store.place.sizes(f"*/{FILE}")
    for night in latest_first(nights)[RUNS_KEPT:]:
        if night.name not in newest.values() and f"{night.name}/{FILE}" in levels:
            store.place.remove(f"{night.name}/{FILE}")
        if night.void is None and night.name in told and not told[night.name].tonight:
            for name in RUNS:
                for runs in (out / night.name).glob(f"*/{name}"):
                    with contextlib.suppress(OSError):  # they go with the next night
                        if runs.resolve() == out.resolve() / runs.relative_to(out):  # no link leads elsewhere
                            shutil.rmtree(runs)


def needed_nights(store: NightStore) -> frozenset[str]:
    """Names of the nights that what is worse on the last night of each machine class is judged from.

    The last night keeps the levels of all figures; the nights of steps have the suspects. Accepted ones are among them,
    as an acceptance names the night of its step.
    """
    latest = latest_judged(store)
    needed = {judged.night.name for judged in latest}
    for judged in latest:
        needed |= {night for row in judged.above.values() for step in row.steps for night in (step.last, step.night)}
        names = list(judged.by_name)
        for change in judged.stepped:
            since = names.index(change.since)
            alike = [name for name in names[:since] if judged.by_name[name].plan == judged.night.plan]
            before = alike[-2 * FEWEST_OLD :] if change.direction is Direction.WORSE else []
            needed |= {change.last, *before, *names[since : since + FEWEST_NEW]}
    return frozenset(needed)
