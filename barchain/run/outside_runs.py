"""Runs of engines of other packages: the answer is checked here as if it came from a stranger."""

from __future__ import annotations

import math
import os
from concurrent.futures import ThreadPoolExecutor, as_completed
from typing import TYPE_CHECKING

from adapters.engine import EngineError
from adapters.trajectory import Trajectory
from barchain.boundary.declared import engine_class
from barchain.boundary.limits import OutsideLimits
from barchain.boundary.message import MessageError, plain_info, plain_number, plain_text
from barchain.boundary.process import STOP, Reply, ask
from barchain.boundary.questions import ARRAYS
from barchain.run.job import RunResult, failure
from barchain.run.trajectory_checks import fault, shape_fault
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Iterator

    from barchain.run.job import Job
    from scenarios import Scene

OUTCOMES = {"missing": Outcome.MISSING, "timed_out": Outcome.TIMED_OUT}


def run_outside(jobs: list[Job], time_s: float, workers: int | None) -> Iterator[tuple[Job, RunResult]]:
    """Run jobs, each in a process of its own, and yield each result as it comes."""
    count = min(workers or os.cpu_count() or 1, len(jobs))
    with STOP.armed(), ThreadPoolExecutor(count) as threads:
        waiting = {threads.submit(one_run, job, time_s): job for job in jobs}
        try:
            for future in as_completed(waiting):
                yield waiting[future], future.result()
        finally:
            STOP.set()
            for future in waiting:
                future.cancel()


def one_run(job: Job, time_s: float) -> RunResult:
    """Result of one run; never an exception for what the engine does."""
    asked = (job.registration, job.options, job.scene, job.setting)
    return result_of(job, ask("run", *asked, limits=OutsideLimits(time_s)))


def one_turn(job: Job, time_s: float, least_s: float, most: int) -> RunResult:
    """Result of a timed turn, in one process: see :func:`barchain.boundary.questions.turn`."""
    asked = (job.registration, job.options, job.scene, job.setting, least_s, most)
    return result_of(job, ask("turn", *asked, limits=OutsideLimits(time_s)))


def one_first_run(job: Job, time_s: float, warm: Scene) -> tuple[RunResult, float]:
    """Result and peak memory, B, of a run after a small one, see :func:`barchain.boundary.questions.first_run`."""
    asked = (job.registration, job.options, job.scene, job.setting, warm)
    reply = ask("first_run", *asked, limits=OutsideLimits(time_s))
    memory_B = plain_number(reply.header.get("memory_B"))
    return result_of(job, reply), math.nan if memory_B is None else float(memory_B)


def result_of(job: Job, reply: Reply) -> RunResult:
    """Result of a run from its answer."""
    if reply.problem:
        outcome = OUTCOMES.get(reply.kind, Outcome.FAILED)
        hint = f"; try: {job.registration.install}" if outcome is Outcome.MISSING else ""
        return failure(outcome, reply.problem + hint, rejected=reply.rejected)
    try:
        return checked(job, reply)
    except (MessageError, EngineError) as error:
        return failure(Outcome.FAILED, str(error))


def checked(job: Job, reply: Reply) -> RunResult:
    """Result of a run that has answered; a trajectory of wrong shapes is dropped.

    Raises
    ------
    MessageError
        If the answer lacks a part, or holds one of a wrong type.
    EngineError
        If the engine's declarations can't be had.
    """
    unknown = sorted(set(reply.arrays) - set(ARRAYS))
    if unknown:
        raise MessageError(f"its answer holds unknown arrays: {plain_text(', '.join(unknown))}")
    given = reply.header.get("seconds")
    given = given if isinstance(given, dict) else {}
    seconds = {plain_text(k, 20): float(plain_number(v) or 0.0) for k, v in given.items()}
    try:
        trajectory = Trajectory(
            **reply.arrays,
            ended=plain_text(reply.header.get("ended", "")),
            info=plain_info(reply.header.get("info")),
        )
    except TypeError as error:
        raise MessageError(f"its answer is incomplete: {plain_text(error)}") from None
    engine = engine_class(job.registration)
    wrong = shape_fault(job.scene, trajectory)
    if wrong:
        return failure(*wrong)
    found = fault(job.scene, engine, trajectory)
    if found:
        return RunResult(found[0], found[1], trajectory, seconds)
    return RunResult(Outcome.PASS, trajectory.ended, trajectory, seconds)
