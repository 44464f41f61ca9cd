"""Runs in worker processes with a time limit: a crash or a hang costs one run.

A process is used again for further runs, and keeps the changes of an engine: a module, a rounding mode, an environment
variable. Therefore the judging solutions are run in processes without any judged engine, and each run of a third-party
adapter has a process of its own. Every process computes in one thread. Processes are those of this machine, or stand
beside the workers of a Dask cluster (:mod:`barchain.runs.executors`).
"""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING

from adapters.registry import ENGINES
from barchain.runs.cases import Task
from barchain.runs.executors import ALL_CORES
from barchain.runs.job import JUDGING_ROLES, Job
from barchain.runs.messages import outside_call, outside_result, shared_call, shared_result
from barchain.runs.order import expected_work
from barchain.runs.time_limits import COMPILE_S, SOLUTION_PATIENCE, TimeLimit

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from barchain.runs.call import Call
    from barchain.runs.executors import Executor
    from barchain.runs.job import RunResult
    from barchain.runs.session import Session

RUNS_PER_WORKER = 40  # some engines leak memory with every model


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
    limits = limits_of_groups(time_limit_s, compile_s, solution_patience)
    waiting = [(job, pool_group(job)) for job in jobs]
    return answered([(job, group, limits[group]) for job, group in sorted(waiting, key=lambda one: one[1])], executor)


def limits_of_groups(
    time_limit_s: float, compile_s: float = COMPILE_S, solution_patience: float = SOLUTION_PATIENCE
) -> dict[PoolGroup, TimeLimit]:
    """Limit of a run in each group of processes; arguments as of :func:`run_jobs`."""
    return {
        PoolGroup.SOLUTION: TimeLimit(time_limit_s * solution_patience, compile_s),
        PoolGroup.REGISTERED: TimeLimit(time_limit_s, compile_s),
        PoolGroup.THIRD_PARTY: TimeLimit(time_limit_s, 0.0),
    }


def run_task(job: Job, time_limit_s: float, kept: Callable[[RunResult], RunResult]) -> Task:
    """Task that makes a run, for a case; `kept` is called with the result, and returns it.

    Runs of judging solutions come first, then the longest.
    """
    group = pool_group(job)
    limit = limits_of_groups(time_limit_s)[group]
    result_of = outside_result if group is PoolGroup.THIRD_PARTY else shared_result
    return Task(
        call_of(job, group, limit),
        lambda answer: kept(limit.judged(job, result_of(job, answer))),
        (float(group), -expected_work(job)),
    )


def run_together(
    jobs: Iterable[Job], limit: TimeLimit, executor: Executor = ALL_CORES
) -> Iterator[tuple[Job, RunResult]]:
    """Run jobs in processes that all of them may share, and yield each result as it comes."""
    return answered([(job, PoolGroup.REGISTERED, limit) for job in jobs], executor)


def answered(asked: list[tuple[Job, PoolGroup, TimeLimit]], executor: Executor) -> Iterator[tuple[Job, RunResult]]:
    """Submit runs in order, and yield their results as they come."""
    if not asked:
        return
    with executor.session() as session:
        runs = RunQueue(session)
        for job, group, limit in asked:
            runs.add(job, limit, group)
        yield from runs.results()


class RunQueue:
    """Runs of a session, which begin in the order in which they are added; a result may lead to further runs."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self.asked: list[tuple[Job, PoolGroup, TimeLimit]] = []

    def add(self, job: Job, limit: TimeLimit, group: PoolGroup | None = None) -> None:
        """Queue a run; its group of processes follows from the job by default."""
        chosen = pool_group(job) if group is None else group
        self.session.submit(len(self.asked), call_of(job, chosen, limit))
        self.asked.append((job, chosen, limit))

    def results(self) -> Iterator[tuple[Job, RunResult]]:
        """Results as they come, until none is awaited."""
        for k, answer in self.session.answers():
            job, group, limit = self.asked[k]
            result_of = outside_result if group is PoolGroup.THIRD_PARTY else shared_result
            yield job, limit.judged(job, result_of(job, answer))


def call_of(job: Job, group: PoolGroup, limit: TimeLimit) -> Call:
    """Call that makes a run."""
    if group is PoolGroup.THIRD_PARTY:
        return outside_call(job, limit.time_s)
    own, pool = group is PoolGroup.SOLUTION, f"{group.name.lower()} runs"
    return shared_call(job, limit.allowed_s(job), limit.simulate_s(job), pool, RUNS_PER_WORKER, own_work=own)
