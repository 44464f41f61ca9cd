"""Cost of an effect in time: the same run with and without it, in turn, in one process on one core.

A ratio is that of two times of one round, so that a machine that is slower for a while slows both; shown is the median
of the rounds. Beside it stand what one evaluation takes longer, timed by itself in rounds alike, and how many more
there are. What is left of the run's ratio lies between evaluations: the search for instants at which a bar turns its
other face or a shadow begins or ends, and steps begun anew there.

A run too long for three rounds of all runs is timed over its first part only.
"""

from __future__ import annotations

import dataclasses
import gc
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from barchain.runs.timing.bench import TimingBench
from barchain.runs.timing.evaluation import DIRECT, batch_s, calibrated, loop_of
from barchain.runs.timing.statistics import Interval, median_time
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from barchain.runs.job import Job
    from scenarios import Scene

LEAST_S = 0.02  # of simulate in one turn
LEAST_ROUNDS = 3  # that are to fit: with them every price has a range
SHORTEST = 0.02  # share of the run that is timed at least
BATCH_S = 0.001  # of evaluations: shorter than a turn of another process on the same core
BATCHES = 20  # in one turn of an evaluation, whose time is the least of them: what disturbs only adds
EVALUATION_TURNS = 9


@dataclass
class Timed:
    """Times of one run, round by round, NaN where it failed."""

    seconds: list[float] = field(default_factory=list)
    evaluations: int = 0
    evaluation_s: list[float] = field(default_factory=list)
    """Of one evaluation at the start, turn by turn; empty where the engine's can't be had by itself"""


@dataclass(frozen=True)
class Price:
    """Cost with an effect over cost without it."""

    time: Interval
    evaluation: Interval | None
    """Time of one evaluation, over that without; None where it is not known"""
    evaluations: float
    """Their number, over that without"""
    rounds: int


def timed_span_s(scene: Scene, pass_s: float, seconds: float, rounds: int = LEAST_ROUNDS) -> float:
    """Timed part of a run: all of it, or the part of which some rounds, and one to get warm, fit in a time.

    Parameters
    ----------
    scene : Scene
        The scene as it is.
    pass_s : float
        What all runs take once, in all.
    seconds : float
        What the rounds may take.
    rounds : int
        That are wanted at least.
    """
    share = min(1.0, max(SHORTEST, seconds / ((rounds + 1) * pass_s))) if pass_s > 0.0 else 1.0
    end = scene.run.duration_s
    known = [t for t in scene.effects.breaks_s if t < end]  # what begins and ends must be there to be timed
    return min(end, max(share * end, *(1.02 * t for t in known)) if known else share * end)


def shortened(job: Job, span_s: float) -> Job:
    """The run's first part, sampled as often."""
    run = job.scene.run
    if span_s >= run.duration_s:
        return job
    samples = max(2, 1 + round((run.samples - 1) * span_s / run.duration_s))
    return dataclasses.replace(
        job, scene=dataclasses.replace(job.scene, run=dataclasses.replace(run, duration_s=span_s, samples=samples))
    )


def timed_rounds(
    jobs: Sequence[Job], *, repeats: int, seconds: float, time_limit_s: float, told: Callable[[int], None]
) -> list[Timed]:
    """Time all runs in turn, again and again; first once each without looking at the clock, to get warm.

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

    Returns
    -------
    list of Timed
        One for each job.
    """
    found = [Timed() for _ in jobs]
    with TimingBench(LEAST_S) as bench:
        for job in jobs:
            bench.run(job, time_limit_s)
        end = time.perf_counter() + seconds
        for k in range(repeats):
            for job, kept in zip(jobs, found, strict=True):
                one_turn(bench, job, kept, time_limit_s)
            told(k + 1)
            if time.perf_counter() > end:
                break
    return found


def one_turn(bench: TimingBench, job: Job, kept: Timed, time_limit_s: float) -> None:
    """One more time of a run."""
    result = bench.run(job, time_limit_s)
    good = result.outcome is Outcome.PASS and result.trajectory is not None
    kept.seconds.append(result.seconds["simulate"] if good else float("nan"))
    if good and result.trajectory is not None:
        kept.evaluations = int(result.trajectory.info.get("evaluations", 0))


def time_evaluations(pairs: Iterable[tuple[Job, Timed]], turns: int = EVALUATION_TURNS) -> None:
    """Time one evaluation of each run in turn, again and again, into its `evaluation_s`."""
    loops = [(loop_of(job.engine, job.scene), kept) for job, kept in pairs if job.engine in DIRECT]
    batches = [(loop, calibrated(loop, BATCH_S), kept) for loop, kept in loops]
    gc.collect()
    gc.disable()
    try:
        for _ in range(turns):
            for loop, times, kept in batches:
                kept.evaluation_s.append(min(batch_s(loop, times) for _ in range(BATCHES)) / times)
    finally:
        gc.enable()


def price(present: Timed, absent: Timed) -> Price | None:
    """Time of `present` over that of `absent`; None where either was never timed."""
    ratios = np.array(present.seconds) / np.array(absent.seconds)
    ratios = ratios[np.isfinite(ratios)]
    if not len(ratios) or not present.evaluations or not absent.evaluations:
        return None
    one = None
    if present.evaluation_s and absent.evaluation_s:
        one = median_time(np.array(present.evaluation_s) / np.array(absent.evaluation_s))
    return Price(median_time(ratios), one, present.evaluations / absent.evaluations, len(ratios))
