"""Runs in worker processes with a time limit: a crash or a hang costs one run.

A process is used again for further runs, and keeps the changes of an engine: a module, a rounding mode, an environment
variable. Therefore the judging solutions are run in processes without any judged engine, and each run of a third-party
adapter has a process of its own. Every process computes in one thread. Processes are those of this machine, or stand
beside the workers of a Dask cluster (:mod:`barchain.runs.executors`).
"""

from __future__ import annotations

import math
from enum import IntEnum
from typing import TYPE_CHECKING

from adapters.engine import AccuracyParameter
from adapters.registry import ENGINES
from barchain.runs.cases import Task, alone, run_cases
from barchain.runs.executors import ALL_CORES
from barchain.runs.job import JUDGING_ROLES, Job
from barchain.runs.messages import outside_call, outside_result, shared_call, shared_result
from barchain.runs.time_limits import COMPILE_S, SOLUTION_PATIENCE, TimeLimit

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from barchain.runs.call import Answer, Call
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
    jobs: Iterable[Job],
    *,
    time_limit_s: float,
    executor: Executor = ALL_CORES,
    compile_s: float = COMPILE_S,
    solution_patience: float = SOLUTION_PATIENCE,
) -> Iterator[tuple[Job, RunResult]]:
    """Run jobs in worker processes and yield each result as it comes.

    Parameters
    ----------
    jobs : iterable of Job
    time_limit_s : float
        Wall time after which a run's process is ended, s. An engine that compiles has `compile_s` more, and the limit
        holds for its `simulate` alone.
    executor : Executor
        Place of the processes; all cores of this machine by default.
    compile_s : float
        Additional wall time for compiling, s; 0 if everything is known to be compiled.
    solution_patience : float
        Limit of a run for the judging solution, relative to `time_limit_s`.

    Raises
    ------
    ClusterLostError
        If the executor is a cluster, and fails; results so far have been yielded.
    """
    tasks = ((job, run_task(job, limit_of(job, time_limit_s, compile_s, solution_patience))) for job in jobs)
    return run_cases(((job, alone(task)) for job, task in tasks), executor)


def run_together(
    jobs: Iterable[Job], limit: TimeLimit, executor: Executor = ALL_CORES
) -> Iterator[tuple[Job, RunResult]]:
    """Run jobs in processes that all of them may share, and yield each result as it comes."""
    return run_cases(((job, alone(run_task(job, limit, PoolGroup.REGISTERED))) for job in jobs), executor)


def limit_of(
    job: Job, time_limit_s: float, compile_s: float = COMPILE_S, solution_patience: float = SOLUTION_PATIENCE
) -> TimeLimit:
    """Limit of a run by its group of processes; arguments as of :func:`run_jobs`."""
    group = pool_group(job)
    if group is PoolGroup.THIRD_PARTY:
        return TimeLimit(time_limit_s, 0.0)
    return TimeLimit(time_limit_s * (solution_patience if group is PoolGroup.SOLUTION else 1.0), compile_s)


def run_task(
    job: Job, limit: TimeLimit, group: PoolGroup | None = None, kept: Callable[[RunResult], object] | None = None
) -> Task:
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
    """
    chosen = pool_group(job) if group is None else group
    result_of = outside_result if chosen is PoolGroup.THIRD_PARTY else shared_result

    def result(answer: Answer) -> RunResult:
        found = limit.judged(job, result_of(job, answer))
        if kept is not None:
            kept(found)
        return found

    return Task(call_of(job, chosen, limit), result, (float(chosen), -expected_work(job)))


def call_of(job: Job, group: PoolGroup, limit: TimeLimit) -> Call:
    """Call that makes a run."""
    if group is PoolGroup.THIRD_PARTY:
        return outside_call("run", job, limit.time_s)
    own, pool = group is PoolGroup.SOLUTION, f"{group.name.lower()} runs"
    return shared_call(job, limit.allowed_s(job), limit.simulate_s(job), pool, RUNS_PER_WORKER, own_work=own)


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
