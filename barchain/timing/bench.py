"""Timing of `simulate` alone: one process an engine, one thread each, one core, one at work at a time.

What disturbs a run only adds to its time, so the time of a turn is the least of its runs; the median over the
turns, which lie apart, is the point's. An engine's process lives through the whole study, so that what it
imported and compiled is warm; a crash or a run past its limit costs its own point, and the next process is
warmed again before it is timed.
"""

from __future__ import annotations

import contextlib
import gc
import multiprocessing
import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from pebble import ProcessPool

from barchain.run.job import Job, RunResult
from barchain.run.pool import TimeLimit, collect
from barchain.run.threads import one_thread_each
from barchain.run.worker import run_job
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Iterable

LEAST_S = 0.02  # of simulate in one turn: thousands of ticks of the clock, and longer than a switch of processes
MOST_RUNS = 100  # in one turn
LONG_S = 0.5  # runs from here on are timed by their first pass too, and seldom repeated
STARTUP_S = 120.0  # allowed on top of the limit to a process that has yet to import; `Limit` adds for compiling
PHASES = ("build", "simulate", "read")

warmed: set[str] = set()  # digests of the scenes that this process has run: the first run of each is never timed


def pin(core: int | None) -> None:
    """Keep this process on one core, where the system can."""
    if core is not None and hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {core})


def awake() -> None:
    """Nothing to do: a process that gets here has imported what it needs."""


def quietest_core() -> int | None:
    """Core to be timed on: the last one allowed, as interrupts and other work settle on the first."""
    return max(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else None


def turn(job: Job, log: Path, least_s: float) -> RunResult:
    """Run `job` in this process until `least_s` of `simulate` are measured.

    Returns
    -------
    RunResult
        Of the last run; its `seconds` are the least of the turn, with ``runs``, their number, and ``cold``, what
        the first run took longer to build and simulate: imports and compiling, if it had to.
    """
    cold: list[RunResult] = []
    if job.scene.digest not in warmed:
        cold.append(run_job(job, log))
        if cold[0].outcome is not Outcome.PASS:
            return cold[0]
        warmed.add(job.scene.digest)
    gc.collect()
    gc.freeze()  # what lives now lives on: the next turn's collection need not look at it again, for 60 ms
    gc.disable()
    try:
        found = repeated(job, log, least_s)
    finally:
        gc.enable()
    return summed_up([*cold, *found])


def repeated(job: Job, log: Path, least_s: float) -> list[RunResult]:
    """Run until `least_s` of `simulate` are measured, or five times that have gone in all; a failure ends it."""
    found: list[RunResult] = []
    while len(found) < MOST_RUNS:
        found.append(run_job(job, log))
        if found[-1].outcome is not Outcome.PASS:
            break
        if sum(r.seconds["simulate"] for r in found) >= least_s:
            break
        if sum(sum(r.seconds.values()) for r in found) >= 5.0 * least_s:
            break
    return found


def summed_up(found: list[RunResult]) -> RunResult:
    """Last run of a turn, with the turn's least times."""
    last = found[-1]
    if last.outcome is not Outcome.PASS:
        return last
    seconds = {phase: min(r.seconds[phase] for r in found) for phase in PHASES}
    seconds["runs"] = float(len(found))
    if len(found) > 1:
        seconds["cold"] = sum(found[0].seconds[p] - seconds[p] for p in ("build", "simulate"))
    return RunResult(last.outcome, last.reason, last.trajectory, seconds)


class TimingBench:
    """One process for each engine, of which only one is at work."""

    def __init__(self, least_s: float = LEAST_S) -> None:
        """Start nothing yet: an engine's process starts with :meth:`start`, or its first turn."""
        self.least_s, self.core = least_s, quietest_core()
        self.pools: dict[str, ProcessPool] = {}
        self.started: set[tuple[str, str]] = set()
        self.logs = tempfile.TemporaryDirectory()
        self.threads = contextlib.ExitStack()

    def __enter__(self) -> TimingBench:
        """Pin the threads of all processes: a pool starts its own when it is first asked, and others after a crash."""
        self.threads.enter_context(one_thread_each())
        return self

    def __exit__(self, *_: object) -> None:
        """End all processes."""
        for pool in self.pools.values():
            pool.stop()
        for pool in self.pools.values():
            pool.join()
        self.threads.close()
        self.logs.cleanup()

    def start(self, engines: Iterable[str]) -> None:
        """Start the processes side by side: importing is most of a short study, and nothing is timed yet."""
        for future in [self.pool(name).schedule(awake) for name in engines]:
            future.exception()

    def run(self, job: Job, time_limit_s: float) -> RunResult:
        """One turn; the first on a scene, and the first after a crash, may import and compile besides."""
        log, pair = Path(self.logs.name) / f"{job.engine}.log", (job.engine, job.scene.digest)
        allowed = time_limit_s if pair in self.started else TimeLimit(time_limit_s).allowed_s(job) + STARTUP_S
        future = self.pool(job.engine).schedule(turn, (job, log, self.least_s), timeout=allowed)
        result = collect(future, log, allowed)
        if "simulate" in result.seconds:
            self.started.add(pair)
        else:  # its process may be gone
            self.started = {p for p in self.started if p[0] != job.engine}
        return result

    def pool(self, engine: str) -> ProcessPool:
        """Process of an engine."""
        if engine not in self.pools:
            context = multiprocessing.get_context("spawn")  # engines are not safe to fork once loaded
            self.pools[engine] = ProcessPool(1, initializer=pin, initargs=(self.core,), context=context)
        return self.pools[engine]
