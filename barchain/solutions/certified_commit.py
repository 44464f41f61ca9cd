"""Certified solutions for the repository, made and compared with fresh runs: tables, and solutions that judge."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from barchain.metrics.quantities import differences
from barchain.solutions.certified import committed_tables, table_path, table_times
from barchain.solutions.certified_judge import certified_jobs, establish_certified
from barchain.solutions.certified_run import fresh
from barchain.solutions.certified_table import (
    CertifiedTable,
    DamagedTableError,
    physics_digest,
    read_table,
    write_table,
)
from barchain.solutions.sampling import closely_sampled
from barchain.solutions.shipped import shipped_path, shipped_solution, write_solution

if TYPE_CHECKING:
    from pathlib import Path

    from adapters.trajectory import Array
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene


def make(scene: Scene) -> CertifiedTable:
    """Certified solution of a shipped scene at the instants of its table, with errors from all samples of the run."""
    wanted = table_times(scene)
    every = np.unique(np.concatenate([wanted, scene.times_s]))
    full = fresh(scene, every)
    row = np.searchsorted(full.trajectory.t_s, wanted[wanted <= full.trajectory.t_s[-1]])
    error = {name: values[row] for name, values in full.error.items()}
    command = maker(scene.name)
    return CertifiedTable(full.scene, full.physics, full.precision, command, full.trajectory.samples(row), error)


def maker(name: str) -> str:
    """Command that makes the certified solution of a shipped scene."""
    return f"barchain certified {name} --out DIR"


def make_judge(scene: Scene) -> ReferenceSolution:
    """Certified solution that judges a shipped scene, at the samples of a comparison."""
    sampled = closely_sampled(scene)
    runs = (
        job.registration.load()(**dict.fromkeys(job.options, True)).run(job.scene, job.setting)
        for job in certified_jobs(sampled)
    )
    return establish_certified(sampled, *runs)


def commit(scene: Scene, folder: Path) -> CertifiedTable:
    """Make a certified solution, and write its two files into `folder` by the scene's name."""
    table = make(scene)
    write_table(folder / f"{scene.name}.csv", table)
    write_solution(shipped_path(scene.name, folder), make_judge(scene))
    committed_tables.cache_clear()  # the folder may be that of the committed tables
    return table


MOST_GROWN = 1e14
"""Largest amplification that a verdict uses: rounding to double then exceeds the predictability limit"""
AMPLIFICATION_SHARE = 0.01
"""Largest relative change of the amplification, whose perturbed runs are known to 1e-4"""


@dataclass(frozen=True)
class CommittedTableCheck:
    """Comparison of a fresh certified solution with the committed one."""

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


def check(scene: Scene) -> CommittedTableCheck:
    """Compare both files of a fresh certified solution with the committed ones, inside both error bars."""
    table, shipped = check_table(scene), shipped_solution(closely_sampled(scene))
    if not table.agrees or shipped is None:
        return table
    return CommittedTableCheck(scene.name, worse(table.share, check_judge(scene, shipped).share))


def worse(one: dict[str, float], other: dict[str, float]) -> dict[str, float]:
    """Larger share of each quantity."""
    return {name: max(one.get(name, 0.0), other.get(name, 0.0)) for name in one | other}


def check_table(scene: Scene) -> CommittedTableCheck:
    """Compare a fresh table with the committed one, inside both error bars."""
    path = table_path(scene)
    if not path.is_file():
        return CommittedTableCheck(scene.name, {}, f"has no certified solution; make it: {maker(scene.name)}")
    try:
        kept = read_table(path)
    except DamagedTableError as error:
        return CommittedTableCheck(scene.name, {}, str(error))
    if kept.physics != physics_digest(scene):
        return CommittedTableCheck(scene.name, {}, f"has changed since; make it again: {kept.command}")
    return compare(scene.name, kept, make(scene))


def check_judge(scene: Scene, kept: ReferenceSolution) -> CommittedTableCheck:
    """Compare a fresh judging solution with the shipped one: inside both error bars, and equally amplified."""
    again = make_judge(scene)
    apart = differences(kept.trajectory, again.trajectory)
    shares = {k: share(d[: len(kept.error[k])], kept.error[k] + again.error[k]) for k, d in apart.items()}
    grown = np.abs(again.amplification / kept.amplification - 1.0)[kept.amplification <= MOST_GROWN]
    return CommittedTableCheck(scene.name, shares | {"amplification": float(grown.max()) / AMPLIFICATION_SHARE})


def compare(name: str, kept: CertifiedTable, again: CertifiedTable) -> CommittedTableCheck:
    """Differences of two certified solutions at the same instants relative to their error bars."""
    if kept.trajectory.t_s.shape != again.trajectory.t_s.shape:
        return CommittedTableCheck(name, {}, f"has other instants than committed; make it again: {kept.command}")
    apart = differences(kept.trajectory, again.trajectory)
    return CommittedTableCheck(name, {k: share(d, kept.error[k] + again.error[k]) for k, d in apart.items()})


def share(apart: Array, allowed: Array) -> float:
    """Largest share of what is allowed; nothing is allowed where both are zero."""
    return float(np.divide(apart, allowed, out=np.where(apart > 0.0, np.inf, 0.0), where=allowed > 0.0).max())
