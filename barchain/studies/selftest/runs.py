"""Runs of the self-test: each is made once, in worker processes or in this one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.faults.insertion import FaultRegistration
from barchain.runs.executors import ALL_CORES
from barchain.runs.pool import run_jobs, run_together
from barchain.runs.run import run_job
from barchain.runs.time_limits import TimeLimit

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from barchain.runs.executors import Executor
    from barchain.runs.job import Job, RunResult

    Runner = Callable[[list[Job]], Iterable[tuple[Job, RunResult]]]

TIME_LIMIT_S = 120.0


def in_workers(executor: Executor = ALL_CORES, time_limit_s: float = TIME_LIMIT_S) -> Runner:
    """Worker processes of an executor; engines with a fault share processes, as they are barchain's."""

    def run(jobs: list[Job]) -> Iterator[tuple[Job, RunResult]]:
        own = [job for job in jobs if isinstance(job.registration, FaultRegistration)]
        unmodified = [job for job in jobs if not isinstance(job.registration, FaultRegistration)]
        yield from run_jobs(unmodified, time_limit_s=time_limit_s, executor=executor)
        if own:
            yield from run_together(own, TimeLimit(time_limit_s), executor)

    return run


def in_this_process(jobs: list[Job]) -> Iterator[tuple[Job, RunResult]]:
    """One after the other, without a limit of time."""
    for job in jobs:
        yield job, run_job(job)


class RunCache:
    """Results of runs by their key."""

    def __init__(self, run: Runner) -> None:
        """Start with none."""
        self.run = run
        self.results: dict[str, RunResult] = {}

    def made(self, jobs: Iterable[Job]) -> Iterator[Job]:
        """Make those runs that were not made yet; each as soon as it is there."""
        missing = {job.key: job for job in jobs if job.key not in self.results}
        if missing:
            for job, result in self.run(list(missing.values())):
                self.results[job.key] = result
                yield job

    def make(self, jobs: Iterable[Job]) -> None:
        """Make those runs that were not made yet."""
        for _ in self.made(jobs):
            pass

    def forget(self, jobs: Iterable[Job]) -> None:
        """Drop the results of runs."""
        for job in jobs:
            self.results.pop(job.key, None)

    def __contains__(self, job: Job) -> bool:
        """Whether a run was made."""
        return job.key in self.results

    def __getitem__(self, job: Job) -> RunResult:
        """Result of a run."""
        return self.results[job.key]
