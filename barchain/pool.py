"""Runs in worker processes with a time limit: a crash or a hang costs one run."""

from __future__ import annotations

import multiprocessing
import os
import queue
import signal
import tempfile
from concurrent.futures import CancelledError
from concurrent.futures import TimeoutError as FutureTimeoutError
from pathlib import Path
from typing import TYPE_CHECKING

from pebble import ProcessExpired, ProcessPool

from barchain.job import Job, RunResult, failure
from barchain.worker import run_job
from reports.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from pebble import ProcessFuture

RUNS_PER_WORKER = 40  # some engines leak a little with every model


def run_jobs(
    jobs: Iterable[Job], *, time_limit_s: float, workers: int | None = None
) -> Iterator[tuple[Job, RunResult]]:
    """Run jobs in worker processes and yield each result as it comes.

    Parameters
    ----------
    jobs : iterable of Job
    time_limit_s : float
        Wall time after which a run's process is ended.
    workers : int, optional
        Processes side by side; all cores by default.
    """
    done: queue.SimpleQueue[tuple[Job, Path, ProcessFuture]] = queue.SimpleQueue()
    context = multiprocessing.get_context("spawn")  # engines are not safe to fork once loaded
    with tempfile.TemporaryDirectory() as logs:
        pool = ProcessPool(workers or os.cpu_count() or 1, max_tasks=RUNS_PER_WORKER, context=context)
        try:
            waiting = 0
            for waiting, job in enumerate(jobs, start=1):
                log = Path(logs) / f"{waiting}.log"
                future = pool.schedule(run_job, (job, log), timeout=time_limit_s)
                future.add_done_callback(lambda f, job=job, log=log: done.put((job, log, f)))
            for _ in range(waiting):
                job, log, future = done.get()
                yield job, collect(future, log, time_limit_s)
        finally:
            pool.stop()
            pool.join()


def collect(future: ProcessFuture, log: Path, time_limit_s: float) -> RunResult:
    """Result of a run, or the readable end of its process."""
    try:
        result: RunResult = future.result()
    except (FutureTimeoutError, CancelledError):
        return failure(Outcome.TIMED_OUT, f"no result within {time_limit_s:g} s")
    except ProcessExpired as error:
        return failure(Outcome.FAILED, f"its process died ({describe_exit(error.exitcode)}){last_words(log)}")
    except Exception as error:
        return failure(Outcome.FAILED, f"its result could not be brought back: {type(error).__name__}: {error}")
    return result


def describe_exit(code: int | None) -> str:
    """``signal 11, SIGSEGV`` or ``exit code 3``."""
    if code is not None and code < 0:
        return f"signal {-code}, {signal.Signals(-code).name}"
    return f"exit code {code}"


def last_words(log: Path) -> str:
    """Last line that a dead process printed, if any."""
    lines = log.read_text(errors="replace").split("\n") if log.is_file() else []
    said = [line.strip() for line in lines if line.strip()]
    return f"; it last said: {said[-1][:200]}" if said else ""
