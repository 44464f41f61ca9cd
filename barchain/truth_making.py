"""Committed truths made, and made again to be compared with what is committed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from barchain.oracle import committed_tables, table_path, table_times
from barchain.oracle_run import fresh
from barchain.quantities import differences
from barchain.truth_tables import DamagedTableError, TruthTable, physics_digest, read_table, write_table

if TYPE_CHECKING:
    from adapters.engine import Array
    from scenarios import Scene


def make(scene: Scene) -> TruthTable:
    """Truth of a shipped scene at the instants of its table, its errors seen at all samples of the run."""
    wanted = table_times(scene)
    every = np.unique(np.concatenate([wanted, scene.times_s]))
    full = fresh(scene, every)
    row = np.searchsorted(full.trajectory.t_s, wanted[wanted <= full.trajectory.t_s[-1]])
    error = {name: values[row] for name, values in full.error.items()}
    command = f"barchain truths {scene.name}"
    return TruthTable(full.scene, full.physics, full.precision, command, full.trajectory.samples(row), error)


def commit(scene: Scene) -> TruthTable:
    """Make a truth and write it where it is committed."""
    table = make(scene)
    write_table(table_path(scene), table)
    committed_tables.cache_clear()
    return table


@dataclass(frozen=True)
class Check:
    """How a fresh truth compares with the committed one."""

    scene: str
    share: dict[str, float]
    """For each quantity, the largest difference over what both error bars allow"""
    fault: str = ""
    """Why they can't be compared; empty if they can"""

    @property
    def agrees(self) -> bool:
        """Whether all of it lies inside the error bars."""
        return not self.fault and all(s <= 1.0 for s in self.share.values())

    @property
    def said(self) -> str:
        """One line."""
        worst = max(self.share.values(), default=0.0)
        verdict = "agrees" if self.agrees else "DIFFERS"
        return f"{self.scene}: {self.fault or f'{verdict}, by {worst:.2f} of the error bars'}"


def check(scene: Scene) -> Check:
    """Compare a fresh truth with the committed one, inside both error bars."""
    path = table_path(scene)
    if not path.is_file():
        return Check(scene.name, {}, f"has no committed truth; make it: barchain truths {scene.name}")
    try:
        kept = read_table(path)
    except DamagedTableError as error:
        return Check(scene.name, {}, str(error))
    if kept.physics != physics_digest(scene):
        return Check(scene.name, {}, f"has changed since; make it again: {kept.command}")
    return compare(scene.name, kept, make(scene))


def compare(name: str, kept: TruthTable, again: TruthTable) -> Check:
    """Differences of two truths at the same instants over their error bars."""
    if kept.trajectory.t_s.shape != again.trajectory.t_s.shape:
        return Check(name, {}, f"has other instants than committed; make it again: {kept.command}")
    apart = differences(kept.trajectory, again.trajectory)
    return Check(name, {k: share(d, kept.error[k] + again.error[k]) for k, d in apart.items()})


def share(apart: Array, allowed: Array) -> float:
    """Largest share of what is allowed; nothing is allowed where both are zero."""
    return float(np.divide(apart, allowed, out=np.where(apart > 0.0, np.inf, 0.0), where=allowed > 0.0).max())
