"""Timing of `simulate` alone: one process for each engine, one thread, one core, one process at work at a time.

A run's time leaves out the wait for a processor (:mod:`barchain.runs.phases`). What else disturbs a run only
adds to its time. The time of a turn is therefore the least of its runs, and the time of a point the median over turns
that lie apart. An engine's process lives through the whole study: imports and compiled code stay warm. A crash or a
timed-out run costs its own point; the next process runs untimed once before it is timed.

Times without the wait for a processor still grow on a busy machine, by up to a tenth: caches and cores are shared. So a
study of times records how busy the machine was (:class:`OtherLoad`).
"""

from __future__ import annotations

import contextlib
import gc
import os
import time
from functools import partial
from typing import TYPE_CHECKING, TypeVar

import psutil

from barchain.runs import questions
from barchain.runs.call import QUESTION_S, Call
from barchain.runs.cases import Task
from barchain.runs.job import Job, RunResult, TimeLimit, failure
from barchain.runs.run import message_of, outside_call, outside_result, ran, run_job, shared_result
from barchain.runs.tasks import PoolGroup, pool_group
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Callable

    from barchain.runs.call import Answer

LEAST_S = 0.02  # of simulate in one turn: thousands of clock ticks, and longer than a process switch
MOST_RUNS = 100  # in one turn
LONG_S = 0.5  # longer runs are timed from the first pass on, and seldom repeated
STARTUP_S = 120.0  # in addition to the limit of a process that has yet to import; `TimeLimit` adds time for compiling
PHASES = ("build", "simulate", "read")
MOST_TURNS = 1_000_000  # a process is kept as long as it lives
T = TypeVar("T")

warmed: set[str] = set()  # digests of scenes that this process has run: the first run of a scene is never timed


def pin(core: int | None) -> None:
    """Pin this process to one core, if the system can."""
    if core is not None and hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {core})


def quietest_core() -> int | None:
    """Core for timing: the last allowed core, as interrupts and other work prefer the first."""
    return max(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else None


def turn(job: Job, least_s: float, simulate_s: float | None = None) -> RunResult:
    """Run `job` in this process until `least_s` of `simulate`, or five times that of all phases, are measured.

    A failure ends the turn; `simulate_s` is as in `run_job`.

    Returns
    -------
    RunResult
        Result of the last run; its `seconds` are the least of the turn. ``runs`` is the number of runs, ``cold`` the
        additional time of the first run to build and simulate, for imports and compiling.
    """
    cold: list[RunResult] = []
    if job.scene.digest not in warmed:
        cold.append(run_job(job, simulate_s))
        if cold[0].outcome is not Outcome.PASS:
            return cold[0]
        warmed.add(job.scene.digest)
    gc.collect()
    gc.freeze()  # the next collection skips objects of now, which saves 60 ms
    gc.disable()
    found, simulated_s, spent_s = cold, 0.0, 0.0
    try:
        while True:
            last = run_job(job, simulate_s)
            if last.outcome is not Outcome.PASS:
                return last
            found = [*found, last]
            simulated_s += last.seconds["simulate"]
            spent_s += sum(last.seconds.values())
            enough = simulated_s >= least_s or spent_s >= 5.0 * least_s
            if enough or len(found) - len(cold) == MOST_RUNS:
                break
    finally:
        gc.enable()
    seconds = {phase: min(r.seconds[phase] for r in found) for phase in PHASES}
    seconds["runs"] = float(len(found))
    if len(found) > 1:
        seconds["cold"] = sum(found[0].seconds[p] - seconds[p] for p in ("build", "simulate"))
    return RunResult(last.outcome, last.reason, last.trajectory, seconds)


def timed_turn(job: Job, least_s: float, core: int | None, simulate_s: float | None) -> bytes:
    """Message with the result of :func:`turn`, run on one core."""
    pin(core)
    return message_of(turn(job, least_s, simulate_s))


class TimingBench:
    """Timed runs as tasks of a case, and the time that they have taken.

    A kept answer counts with the time that it took when it was made. What a budget allows is therefore the same for a
    study that goes on as for one that was never interrupted.
    """

    def __init__(self) -> None:
        """Nothing has been run yet."""
        self.spent_s, self.core = 0.0, quietest_core()

    def task(self, call: Call, result: Callable[[Answer], T]) -> Task:
        """Task whose time counts."""

        def taken(answer: Answer) -> T:
            self.spent_s += answer.seconds
            return result(answer)

        return Task(call, taken)

    def run(self, job: Job, time_limit_s: float, repetition: int = 0) -> Task:
        """Task with the result of one turn; `repetition` numbers the turns of a job.

        The limit holds for each `simulate`; the process has more time, for imports and compiling.
        """
        if pool_group(job) is PoolGroup.THIRD_PARTY:
            call = outside_call(
                questions.turn, job, time_limit_s + QUESTION_S, LEAST_S, MOST_RUNS, repetition=repetition
            )
            return self.task(call, partial(outside_result, job))
        limit = TimeLimit(time_limit_s)

        def result(answer: Answer) -> RunResult:
            found = limit.judged(job, shared_result(job, answer))
            late = found.seconds.get("simulate", 0.0) > time_limit_s
            return failure(Outcome.TIMED_OUT, f"simulate took longer than {time_limit_s:g} s") if late else found

        call = Call(
            timed_turn, (job, LEAST_S), STARTUP_S + limit.allowed_s(job), job.engine, MOST_TURNS,
            aside=(self.core, time_limit_s), repetition=repetition, worth_keeping=ran,
        )  # fmt: skip
        return self.task(call, result)


def busy_s() -> float:
    """Time that all processors have worked so far, s; time that a hypervisor gave to other machines counts too."""
    spent = psutil.cpu_times()._asdict()
    idle = ("idle", "iowait", "guest", "guest_nice")  # guests are in the time of users already
    return float(sum(value for name, value in spent.items() if name not in idle))


def own_s() -> float:
    """Time that this process and those that it started have used so far, s."""
    found, processes = 0.0, [psutil.Process()]
    with contextlib.suppress(psutil.Error):
        processes += processes[0].children(recursive=True)
    for process in processes:
        with contextlib.suppress(psutil.Error):
            spent = process.cpu_times()
            found += spent.user + spent.system + spent.children_user + spent.children_system
    return found


class OtherLoad:
    """Load by other processes from its making on."""

    def __init__(self) -> None:
        """Begin."""
        self.start_s, self.busy_s, self.own_s = time.monotonic(), busy_s(), own_s()

    def processors(self) -> float:
        """Mean number of processors that other processes have used since the start; at least 0."""
        wall_s = time.monotonic() - self.start_s
        others_s = busy_s() - self.busy_s - (own_s() - self.own_s)
        return max(others_s / wall_s, 0.0) if wall_s > 0.0 else 0.0
