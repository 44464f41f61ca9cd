"""Budget of a night: each job has its share of the time that is left, and takes on as much as is known to fit."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from barchain.nightly.plan.jobs import NightJob
    from barchain.nightly.run_facts import NightRun

RESERVE_S = 25.0
"""Time at the end for judging and telling; a twentieth of a short night"""
ALARM = "selftest"
LEAST_S = 5.0
"""A job with less time than this does not begin: reading barchain alone takes a second"""
FILL = 0.9
"""Part of a job's time that the scenes that are taken on may fill"""
MEASURED = 0.85
"""Part of a cost study's time that it plans with; its first runs are not planned"""


def working_time_s(minutes: float) -> float:
    """Time of all jobs together, without the reserve at the end."""
    whole = 60.0 * minutes
    return whole - min(RESERVE_S, 0.05 * whole)


def limit_s(job: NightJob, rest: Sequence[NightJob], left_s: float) -> float:
    """Time of a job: its share of what is left, among itself and the jobs after it.

    Planted faults get enough to begin in the shortest night: without them, no other part is worth believing.
    """
    share = left_s * job.share / sum(each.share for each in (job, *rest))
    return min(max(share, LEAST_S), left_s) if job.study == ALARM else share


def pace_s(name: str, last: NightRun | None) -> float | None:
    """Time of one item of a part on the last night of the plan; None where nothing was done."""
    for part in last.parts if last else ():
        if part.name == name and part.done and part.duration_s > 0.0:
            return part.duration_s / part.done
    return None


def fitting(job: NightJob, time_s: float, pace: float | None) -> tuple[NightJob, tuple[str, ...]]:
    """Job with the scenes that are known to fit, at least one, and the scenes that are left."""
    if pace is None or not job.scenes:
        return job, ()
    count = max(int(FILL * time_s / pace), 1)
    return replace(job, scenes=job.scenes[:count]), job.scenes[count:]
