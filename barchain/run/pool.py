"""Runs in worker processes with a time limit: a crash or a hang costs one run.

A process is used again for further runs, and keeps the changes of an engine: a module, a rounding mode, an environment
variable. Therefore the reference solution is run in processes without any other engine, and each run of a third-party
adapter has a process of its own. Every process computes in one thread.
"""

from __future__ import annotations

import multiprocessing
import os
import queue
import signal
import tempfile
from concurrent.futures import CancelledError
from concurrent.futures import TimeoutError as FutureTimeoutError
from enum import IntEnum
from pathlib import Path
from typing import TYPE_CHECKING

from pebble import ProcessExpired, ProcessPool

from adapters.registry import ENGINES
from barchain.boundary.threads import one_thread_each, temporary_root
from barchain.run.job import SOLUTION_ROLES, Job, RunResult, failure
from barchain.run.outside_runs import run_outside
from barchain.run.time_limits import COMPILE_S, SOLUTION_PATIENCE, TimeLimit
from barchain.run.worker import run_job
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from pebble import ProcessFuture

RUNS_PER_WORKER = 40  # some engines leak memory with every model


class PoolGroup(IntEnum):
    """Runs that may share a process, in the order of running."""

    SOLUTION = 0
    """The reference, for reference solutions"""
    REGISTERED = 1
    """Engines behind barchain's own adapters"""
    THIRD_PARTY = 2
    """Engines that other packages register: one run, one process behind the boundary"""


def pool_group(job: Job) -> PoolGroup:
    """Group of processes that a run belongs to."""
    if job.role in SOLUTION_ROLES:
        return PoolGroup.SOLUTION
    return PoolGroup.REGISTERED if job.registration in ENGINES.values() else PoolGroup.THIRD_PARTY


def run_jobs(
    jobs: Iterable[Job],
    *,
    time_limit_s: float,
    workers: int | None = None,
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
    workers : int, optional
        Number of processes side by side; all cores by default.
    compile_s : float
        Additional wall time for compiling, s; 0 if everything is known to be compiled.
    solution_patience : float
        Limit of a run for the reference solution, relative to `time_limit_s`.
    """
    waiting = list(jobs)
    for group in PoolGroup:
        own = [job for job in waiting if pool_group(job) is group]
        if own:
            limit_s = time_limit_s * (solution_patience if group is PoolGroup.SOLUTION else 1.0)
            if group is PoolGroup.THIRD_PARTY:
                yield from run_outside(own, limit_s, workers)
            else:
                yield from run_together(own, TimeLimit(limit_s, compile_s), workers)


def run_together(jobs: list[Job], limit: TimeLimit, workers: int | None) -> Iterator[tuple[Job, RunResult]]:
    """Run the jobs of one group of processes, and yield each result as it comes."""
    done: queue.SimpleQueue[tuple[Job, Path, ProcessFuture]] = queue.SimpleQueue()
    context = multiprocessing.get_context("spawn")  # loaded engines are not safe to fork
    count = min(workers or os.cpu_count() or 1, len(jobs))
    with one_thread_each(), tempfile.TemporaryDirectory(dir=temporary_root()) as logs:
        pool = ProcessPool(count, max_tasks=RUNS_PER_WORKER, context=context)
        try:
            for number, job in enumerate(jobs, start=1):
                log = Path(logs) / f"{number}.log"
                future = pool.schedule(run_job, (job, log), timeout=limit.allowed_s(job))
                future.add_done_callback(lambda f, job=job, log=log: done.put((job, log, f)))
            for _ in jobs:
                job, log, future = done.get()
                result = limit.judged(job, collect(future, log, limit.allowed_s(job)))
                yield job, result
        finally:
            pool.stop()
            pool.join()


def collect(future: ProcessFuture, log: Path, time_limit_s: float) -> RunResult:
    """Result of a run, or a failure that describes the end of its process."""
    try:
        result: RunResult = future.result()
    except (FutureTimeoutError, CancelledError):
        return failure(Outcome.TIMED_OUT, f"no result within {time_limit_s:g} s")
    except ProcessExpired as error:
        return failure(Outcome.FAILED, f"its process died ({describe_exit(error.exitcode)}){last_words(log)}")
    except BaseException as error:  # an exit that a worker hands on as an exception is no request to end
        if isinstance(error, KeyboardInterrupt):
            raise
        return failure(Outcome.FAILED, f"its result could not be brought back: {type(error).__name__}: {error}")
    return result


def describe_exit(code: int | None) -> str:
    """``signal 11, SIGSEGV`` or ``exit code 3``."""
    if code is not None and code < 0:
        return f"signal {-code}, {signal.Signals(-code).name}"
    return f"exit code {code}"


def last_words(log: Path) -> str:
    """Last line in the log of a dead process; empty without one."""
    lines = log.read_text(errors="replace").split("\n") if log.is_file() else []
    said = [line.strip() for line in lines if line.strip()]
    return f"; last output: {said[-1][:200]}" if said else ""
