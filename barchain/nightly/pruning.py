"""What of old nights may go: their runs, and nights that no change for the worse is compared with.

Pruning a night that a regression is compared with would turn it green.
"""

from __future__ import annotations

import contextlib
import shutil
from typing import TYPE_CHECKING

import numpy as np

from barchain.nightly.changes import Direction
from barchain.nightly.figures import STEPPED
from barchain.nightly.history import latest_first
from barchain.nightly.judging import judge, still_holding
from barchain.nightly.rank_test import FEWEST_NEW, FEWEST_OLD
from barchain.nightly.renamed import Lineages
from barchain.nightly.told import told_by
from barchain.nightly.vanished import OCCASIONS, Presence

if TYPE_CHECKING:
    from pathlib import Path

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
    """Names of the nights that tell the changes for the worse which the last night of each machine class holds.

    Accepted ones are among them, as an acceptance names the night of its change. So are the nights between which a
    figure got another name, with those beside them: a night may lack the figure.
    """
    table = store.table()
    presence = Presence(table.nights, table.identities, table.cells >= 0)
    last = {night.environment.machine_class: night.name for night in store.nights() if night.void is None}
    needed: set[str] = set()
    for judged in (judge(store, night) for night in last.values()):
        names = list(judged.by_name)
        borders = Lineages((*judged.compared_with, judged.night), presence).borders
        for k in np.unique(np.nonzero(borders)[1]).tolist():
            needed |= {each.name for each in table.nights[max(0, k - 1) : k + 2]}
        for change in judged.changes:
            if change.identity.kind in STEPPED:
                since = names.index(change.since)
                needed |= {*names[since : since + FEWEST_NEW]}
        worse = [change for change in judged.tonight if change.direction is Direction.WORSE]
        for change in (*worse, *still_holding(judged)):
            needed |= needed_by(judged, change)
    return frozenset(needed)


def needed_by(judged: JudgedNight, change: Change) -> set[str]:
    """Nights that a change is judged from.

    These are the night on which the earlier level began, the last nights of the same plan before the change, as many as
    a step of noisy figures and a figure that is gone need, as many complete ones, and the first ones after it.
    """
    nights, stepped = judged.by_name, change.identity.kind in STEPPED
    names = list(nights)
    last, since = names.index(change.last), names.index(change.since)
    alike = [name for name in names[: last + 1] if nights[name].plan == nights[change.last].plan]
    count = 2 * FEWEST_OLD if stepped else OCCASIONS
    complete = [name for name in alike if nights[name].complete]
    after = names[since : since + (FEWEST_NEW if stepped else 1)]
    return {*alike[-count:], *complete[-count:], *after, change.level} - {""}
