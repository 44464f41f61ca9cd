"""Tasks of cases: a run with its time limit, each in a worker process.

A crash or a hang costs one task. A process is used again for further runs, and keeps the changes of an engine: a
module, a rounding mode, an environment variable. Therefore the judging solutions are run in processes without any
judged engine, and each run of a third-party adapter has a process of its own. Every process computes in one thread.
Processes are those of this machine, or stand beside the workers of a Dask cluster (:mod:`barchain.runs.executors`).
"""

from __future__ import annotations

import dataclasses
import math
from enum import IntEnum
from typing import TYPE_CHECKING

from adapters.engine import AccuracyParameter
from adapters.registry import ENGINES
from barchain.runs import questions
from barchain.runs.cases import Task, alone, run_cases
from barchain.runs.executors import ALL_CORES
from barchain.runs.job import COMPILE_S, JUDGING_ROLES, SOLUTION_PATIENCE, Job, TimeLimit
from barchain.runs.run import outside_call, outside_result, shared_call, shared_result

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from barchain.runs.call import Answer
    from barchain.runs.executors import Executor
    from barchain.runs.job import RunResult

RUNS_PER_WORKER = 40  # some engines leak memory with every model
STEPS_PER_RADIAN = 1.0
"""Of the fastest rate at rtol = 1; methods of high order take rtol^(-1/8) times more"""
ORDER = 8.0
COMPILING = 1e18
"""Work of a run that compiles first"""


class PoolGroup(IntEnum):
    """Runs that may share a process, in the order of running."""

    SOLUTION = 0
    """The reference or heyoka, for the solutions that judge"""
    REGISTERED = 1
    """Engines behind barchain's own adapters"""
    THIRD_PARTY = 2
    """Engines that other packages register: one run, one process behind the boundary"""


def pool_group(job: Job) -> PoolGroup:
    """Group of processes that a run belongs to."""
    if job.role in JUDGING_ROLES:
        return PoolGroup.SOLUTION
    return PoolGroup.REGISTERED if job.registration in ENGINES.values() else PoolGroup.THIRD_PARTY


def run_jobs(
    jobs: Iterable[Job], *, time_limit_s: float, executor: Executor = ALL_CORES
) -> Iterator[tuple[Job, RunResult]]:
    """Run jobs in worker processes and yield each result as it comes.

    Parameters
    ----------
    jobs : iterable of Job
    time_limit_s : float
        As for :func:`limit_of`.
    executor : Executor
        Place of the processes; all cores of this machine by default.

    Raises
    ------
    ClusterLostError
        If the executor is a cluster, and fails; results so far have been yielded.
    """
    return run_cases(((job, alone(run_task(job, limit_of(job, time_limit_s)))) for job in jobs), executor)


def limit_of(job: Job, time_limit_s: float) -> TimeLimit:
    """Limit of a run by its group of processes.

    Parameters
    ----------
    job : Job
    time_limit_s : float
        Wall time after which a run's process is ended, s; :data:`SOLUTION_PATIENCE` times as much for the solution that
        judges. An engine that compiles has :data:`COMPILE_S` more, and the limit holds for its `simulate` alone.
    """
    group = pool_group(job)
    if group is PoolGroup.THIRD_PARTY:
        return TimeLimit(time_limit_s, 0.0)
    return TimeLimit(time_limit_s * (SOLUTION_PATIENCE if group is PoolGroup.SOLUTION else 1.0), COMPILE_S)


def run_task(
    job: Job, limit: TimeLimit, group: PoolGroup | None = None, kept: Callable[[RunResult], object] | None = None,
    *, first: bool = False, instead: Callable[[], RunResult | None] = lambda: None, repetition: int = 0,
) -> Task:  # fmt: skip
    """Task that makes a run, for a case.

    Runs of judging solutions come first, then the longest.

    Parameters
    ----------
    job : Job
    limit : TimeLimit
    group : PoolGroup, optional
        Group of processes; it follows from the job by default.
    kept : callable, optional
        Called with the result as soon as it is there.
    first : bool
        Whether it comes before the other runs of its group.
    instead : callable
        Result that makes the run needless, asked for at its turn.
    repetition : int
        Number of a run that is made several times: equal numbers share one answer.
    """
    chosen = pool_group(job) if group is None else group
    if chosen is PoolGroup.THIRD_PARTY:
        call, result_of = outside_call(questions.run, job, limit.time_s), outside_result
    else:
        own, pool = chosen is PoolGroup.SOLUTION, f"{chosen.name.lower()} runs"
        call, result_of = shared_call(job, limit, pool, RUNS_PER_WORKER, own_work=own), shared_result

    def result(answer: Answer) -> RunResult:
        found = limit.judged(job, result_of(job, answer))
        if kept is not None:
            kept(found)
        return found

    call = dataclasses.replace(call, repetition=repetition)
    return Task(call, result, (float(chosen), -math.inf if first else -expected_work(job)), instead)


def expected_work(job: Job) -> float:
    """Steps times bars that a run takes, as far as scene and setting tell.

    Only the order of jobs depends on it: the longest come first, so that no process waits at the end for a long one.
    """
    scene, setting = job.scene, job.setting
    if job.registration.compiles and job.registration in ENGINES.values():
        return COMPILING * scene.bars
    turns = scene.run.duration_s / scene.step_period_s
    steps = setting.value * turns
    if setting.parameter is AccuracyParameter.RTOL:
        steps = STEPS_PER_RADIAN * 2.0 * math.pi * turns * scene.bars * setting.value ** (-1.0 / ORDER)
    return max(steps, scene.run.samples) * scene.bars
