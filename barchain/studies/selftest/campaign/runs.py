"""Runs of a campaign: each is made once, in worker processes or in this one."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from adapters.registry import Registration, find_own_engine
from barchain.execution.executors import ALL_CORES
from barchain.run.pool import run_jobs, run_together
from barchain.run.time_limits import TimeLimit
from barchain.run.worker import run_quietly
from barchain.studies.selftest.campaign.faults.catalogue import find
from barchain.studies.selftest.faults.faulty_engine import engine_with_fault

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from adapters.engine import Engine
    from barchain.execution.executors import Executor
    from barchain.run.job import Job, RunResult

    Runner = Callable[[list[Job]], Iterable[tuple[Job, RunResult]]]

TIME_LIMIT_S = 120.0


@dataclass(frozen=True)
class CampaignRegistration(Registration):
    """Names from which a worker makes an engine with a fault in it."""

    host: str = ""
    fault: str = ""

    def load(self) -> type[Engine]:
        """Make the class."""
        fault = find(self.fault)
        return engine_with_fault(fault, fault.natural, find_own_engine(self.host).load())


def campaign_registration(host: str, fault: str) -> CampaignRegistration:
    """Registration of a host with a fault."""
    compiles = find_own_engine(host).compiles
    return CampaignRegistration(f"fault:{fault}:{host}", compiles=compiles, host=host, fault=fault)


def in_workers(executor: Executor = ALL_CORES, time_limit_s: float = TIME_LIMIT_S) -> Runner:
    """Worker processes of an executor; engines with a fault share processes, as they are barchain's."""

    def run(jobs: list[Job]) -> Iterator[tuple[Job, RunResult]]:
        own = [job for job in jobs if isinstance(job.registration, CampaignRegistration)]
        unmodified = [job for job in jobs if not isinstance(job.registration, CampaignRegistration)]
        yield from run_jobs(unmodified, time_limit_s=time_limit_s, executor=executor)
        if own:
            yield from run_together(own, TimeLimit(time_limit_s), executor)

    return run


def in_this_process(jobs: list[Job]) -> Iterator[tuple[Job, RunResult]]:
    """One after the other, without a limit of time."""
    with tempfile.TemporaryDirectory() as folder:
        for job in jobs:
            yield job, run_quietly(job, Path(folder) / "log")


class RunCache:
    """Results of runs by their key."""

    def __init__(self, run: Runner) -> None:
        """Start with none."""
        self.run = run
        self.results: dict[str, RunResult] = {}

    def make(self, jobs: Iterable[Job]) -> None:
        """Make those runs that were not made yet."""
        missing = {job.key: job for job in jobs if job.key not in self.results}
        if missing:
            self.results |= {job.key: result for job, result in self.run(list(missing.values()))}

    def __getitem__(self, job: Job) -> RunResult:
        """Result of a run."""
        return self.results[job.key]
