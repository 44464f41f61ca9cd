"""Cost of an effect in time: the same run with and without it, in turn, in one process on one core.

A ratio is that of two times of one round, so that a machine that is slower for a while slows both; shown is the median
of the rounds. Beside it stand what one evaluation takes longer, timed by itself in rounds alike, and how many more
there are. What is left of the run's ratio lies between evaluations: the search for instants at which a bar turns its
other face or a shadow begins or ends, and steps begun anew there.

A run too long for three rounds of all runs is timed over its first part only.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.runs.call import Call
from barchain.runs.message import message_bytes, read_message
from barchain.studies.timing.bench import TimingBench, pin
from barchain.studies.timing.evaluation import DIRECT, evaluation_times, loop_of
from barchain.studies.timing.statistics import median_time
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from barchain.runs.cases import Case
    from barchain.runs.job import Job
    from scenarios import Scene

LEAST_ROUNDS = 3  # that are to fit: with them every price has a range
SHORTEST = 0.02  # share of the run that is timed at least
BATCH_S = 0.001  # of evaluations: shorter than a turn of another process on the same core
BATCHES = 20  # in one turn of an evaluation, whose time is the least of them: what disturbs only adds
EVALUATION_TURNS = 9
EVALUATIONS_S = 600.0  # allowed to all turns: some 0.2 s a run, and the first evaluations


@dataclass
class Timed:
    """Times of one run, round by round, NaN where it failed."""

    seconds: list[float] = field(default_factory=list)
    evaluations: int = 0
    evaluation_s: list[float] = field(default_factory=list)
    """Of one evaluation at the start, turn by turn; empty where the engine's can't be had by itself"""


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
) -> Case[list[Timed]]:
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
    found, bench = [Timed() for _ in jobs], TimingBench()
    for job in jobs:
        yield [bench.run(job, time_limit_s)]
    end_s = bench.spent_s + seconds
    for turn in range(1, repeats + 1):
        for job, own in zip(jobs, found, strict=True):
            (result,) = yield [bench.run(job, time_limit_s, turn)]
            good = result.outcome is Outcome.PASS and result.trajectory is not None
            own.seconds.append(result.seconds["simulate"] if good else float("nan"))
            if good:
                own.evaluations = int(result.trajectory.info.get("evaluations", 0))
        told(turn)
        if bench.spent_s > end_s:
            break
    rated = [(job, own) for job, own in zip(jobs, found, strict=True) if job.engine in DIRECT]
    work = tuple((job.engine, job.scene) for job, _ in rated)
    call = Call(timed_evaluations, (work, EVALUATION_TURNS), EVALUATIONS_S, "evaluations", aside=(bench.core,))
    (times,) = yield [bench.task(call, lambda answer: read_message(answer.needed())[1]["evaluation_s"])]
    for (_, own), evaluation_s in zip(rated, times.T, strict=True):
        own.evaluation_s = evaluation_s.tolist()
    return found


def timed_evaluations(work: Sequence[tuple[str, Scene]], turns: int, core: int | None) -> bytes:
    """Message with the times of one evaluation of engines in scenes, in turn, again and again: (turns, n) s."""
    pin(core)
    loops = [loop_of(engine, scene) for engine, scene in work]
    return message_bytes({}, {"evaluation_s": evaluation_times(loops, turns, BATCH_S, BATCHES)})


def price_columns(present: Timed, absent: Timed) -> dict[str, Any]:
    """Columns of the cost of an effect: of a run with it over one without it; none where either was never timed.

    The time of an evaluation, and its ratio, are left out where they are not known.
    """
    ratios = np.array(present.seconds) / np.array(absent.seconds)
    ratios = ratios[np.isfinite(ratios)]
    if not len(ratios) or not present.evaluations or not absent.evaluations:
        return {}
    found = median_time(ratios).columns("time_ratio") | {
        "rounds": len(ratios),
        "evaluations_ratio": present.evaluations / absent.evaluations,
        "evaluations": present.evaluations,
        "seconds": float(np.nanmedian(present.seconds)),
    }
    if present.evaluation_s and absent.evaluation_s:
        one = median_time(np.array(present.evaluation_s) / np.array(absent.evaluation_s))
        found |= one.columns("evaluation_ratio")
    if present.evaluation_s:
        found["evaluation_s"] = float(np.median(present.evaluation_s))
    return found
