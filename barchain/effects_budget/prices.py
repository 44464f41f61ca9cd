"""What an effect costs in time: the same run with and without it, in turn, in one process on one core.

A ratio is that of two times of one round, so that a machine that is slower for a while slows both; shown is the median
of the rounds. Beside it stand what one evaluation takes longer, timed by itself, and how many more there are. A run
takes longer than both say where it looks for instants at which a bar turns its other face, or a shadow ends.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from barchain.cost.curves import Interval, median_time
from barchain.cost.timing import Bench
from barchain.scaling.evaluation import DIRECT, evaluation_times, loop_of
from reports.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from barchain.job import Job

LEAST_S = 0.01  # of simulate in one turn
EVALUATION_S = 0.002  # of a batch of evaluations
EVALUATION_TURNS = 3


@dataclass
class Timed:
    """Times of one run, round by round, NaN where it failed."""

    seconds: list[float] = field(default_factory=list)
    evaluations: int = 0
    evaluation_s: float | None = None
    """Of one evaluation at the start, the least of some turns; None where the engine's can't be had by itself"""


@dataclass(frozen=True)
class Price:
    """Cost with an effect over cost without it."""

    time: Interval
    evaluation: float | None
    """Time of one evaluation, over that without; None where it is not known"""
    evaluations: float
    """Their number, over that without"""
    rounds: int


def timed_rounds(
    jobs: Sequence[Job], *, repeats: int, seconds: float, time_limit_s: float, told: Callable[[int], None]
) -> dict[str, Timed]:
    """Time all runs in turn, again and again, by their keys.

    Parameters
    ----------
    jobs : sequence of Job
    repeats : int
        Rounds at most.
    seconds : float
        After which no further round is begun.
    time_limit_s : float
        Of one run.
    told : callable
        Told the number of each round that is over.
    """
    found = {job.key: Timed() for job in jobs}
    end = time.perf_counter() + seconds
    with Bench(LEAST_S) as bench:
        for k in range(repeats):
            for job in jobs:
                one_turn(bench, job, found[job.key], time_limit_s)
            told(k + 1)
            if time.perf_counter() > end:
                break
    for job in jobs:
        if job.engine in DIRECT:
            times = evaluation_times(loop_of(job.engine, job.scene), EVALUATION_TURNS, EVALUATION_S)
            found[job.key].evaluation_s = float(times.min())
    return found


def one_turn(bench: Bench, job: Job, kept: Timed, time_limit_s: float) -> None:
    """One more time of a run."""
    result = bench.run(job, time_limit_s)
    good = result.outcome is Outcome.PASS and result.trajectory is not None
    kept.seconds.append(result.seconds["simulate"] if good else float("nan"))
    if good and result.trajectory is not None:
        kept.evaluations = int(result.trajectory.info.get("evaluations", 0))


def price(present: Timed, absent: Timed) -> Price | None:
    """Cost of what is in `present` and not in `absent`; None where a run of either was never timed."""
    ratios = np.array(present.seconds) / np.array(absent.seconds)
    ratios = ratios[np.isfinite(ratios)]
    if not len(ratios) or not present.evaluations or not absent.evaluations:
        return None
    one = None
    if present.evaluation_s is not None and absent.evaluation_s is not None:
        one = present.evaluation_s / absent.evaluation_s
    return Price(median_time(ratios), one, present.evaluations / absent.evaluations, len(ratios))
