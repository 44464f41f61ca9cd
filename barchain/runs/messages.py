"""Runs and their results as messages between processes: text and float64 arrays, read without running code."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any

from barchain.runs.asking import question_call, reply_of
from barchain.runs.call import Answer, Call, CallEnd
from barchain.runs.job import RunResult, failure
from barchain.runs.limits import OutsideLimits
from barchain.runs.message import (
    MessageError,
    message_bytes,
    plain_info,
    plain_text,
    read_message,
)
from barchain.runs.outside_runs import durations, result_of, trajectory_from
from barchain.runs.questions import sendable
from barchain.runs.run import run_job
from barchain.runs.trajectory_checks import shape_fault
from barchain.runs.versions import need_same_version, version_of
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from barchain.runs.job import Job

ENDS = {CallEnd.TIMED_OUT: Outcome.TIMED_OUT}


def shared_call(
    job: Job, limit_s: float, simulate_s: float | None, pool: str, runs_per_worker: int, *, own_work: bool = False
) -> Call:
    """Run of barchain's own adapter, in a process that runs of the same pool share.

    Parameters
    ----------
    job : Job
    limit_s : float
        Wall time of the run, s.
    simulate_s : float, optional
        Wall time of the engine's ``simulate`` alone, s.
    pool : str
        Runs of one pool share processes.
    runs_per_worker : int
        Number of runs after which a process is replaced.
    own_work : bool
        Whether the run serves judging: its limit is processor time, and `simulate` has none of its own.
    """
    return Call(
        shared_run, (job, version_of(job.registration)), limit_s, pool, runs_per_worker, own_work,
        aside=(None if own_work else simulate_s,), worth_keeping=ran,
    )  # fmt: skip


def outside_call(question: str, job: Job, limit_s: float, *more: Any, repetition: int = 0) -> Call:
    """Run of an engine of another package, in a process of its own behind the boundary.

    Parameters
    ----------
    question : str
        ``run``, ``turn`` or ``first_run``, see :mod:`barchain.runs.questions`.
    job : Job
    limit_s : float
        Wall time of the process, s.
    *more : Any
        Further arguments of the question.
    repetition : int
        Number of a measurement that is made several times.
    """
    asked = job.registration, job.options, job.scene, job.setting, *more
    call = question_call(question, *asked, limits=OutsideLimits(limit_s), version=version_of(job.registration))
    return dataclasses.replace(call, repetition=repetition, worth_keeping=ran)


def shared_run(job: Job, version: str, simulate_s: float | None = None) -> bytes:
    """Run a job in this process; `simulate_s` as in :func:`barchain.runs.run.run_job`.

    Raises
    ------
    WrongWorkerError
        If the engine's package has another version here.
    """
    need_same_version(version_of(job.registration), version)
    return message_of(run_job(job, simulate_s))


def message_of(result: RunResult) -> bytes:
    """Message with a result; a trajectory that can't be sent is dropped with the reason."""
    try:
        arrays = {} if result.trajectory is None else sendable(result.trajectory, keep_order=True)
        info = {} if result.trajectory is None else plain_info(result.trajectory.info)
    except MessageError as error:
        if result.outcome is Outcome.PASS:
            return message_of(failure(Outcome.FAILED, str(error)))
        return message_of(dataclasses.replace(result, trajectory=None))
    ended = "" if result.trajectory is None else result.trajectory.ended
    header = {
        "outcome": str(result.outcome), "reason": result.reason, "seconds": result.seconds,
        "rejected": result.rejected, "ended": ended, "info": info, "ran": result.trajectory is not None,
    }  # fmt: skip
    return message_bytes(header, arrays)


def ran(content: bytes) -> bool:
    """Whether the message of a run tells of a trajectory: a run that failed is tried again."""
    try:
        header, _ = read_message(content)
    except MessageError:
        return False
    return "failed" not in header and header.get("ran") is not False


def failed_run(answer: Answer) -> RunResult:
    """Result of a run whose call gave no answer; `simulate` had not ended where its own timer ended the process."""
    if answer.end is CallEnd.OWN_TIMER:
        return RunResult(Outcome.TIMED_OUT, answer.reason, seconds={"simulate": math.inf})
    return failure(ENDS.get(answer.end, Outcome.FAILED), answer.reason)


def shared_result(job: Job, answer: Answer) -> RunResult:
    """Result of :func:`shared_run`, checked."""
    if answer.end is not CallEnd.ANSWERED:
        return failed_run(answer)
    try:
        return result_from(job, *read_message(answer.content))
    except (MessageError, ValueError, TypeError) as error:
        return failure(Outcome.FAILED, f"its result is damaged: {plain_text(error)}")


def result_from(job: Job, header: dict[str, Any], arrays: dict[str, Any]) -> RunResult:
    """Result from the parts of a message.

    Raises
    ------
    MessageError, ValueError, TypeError
        If a part is missing, or of a wrong type or shape.
    """
    outcome = Outcome(str(header.get("outcome")))
    trajectory = trajectory_from(header, arrays) if header.get("ran") else None
    wrong = None if trajectory is None or outcome is not Outcome.PASS else shape_fault(job.scene, trajectory)
    if wrong:
        return failure(*wrong)
    reason = plain_text(header.get("reason", ""))
    return RunResult(outcome, reason, trajectory, durations(header.get("seconds")), bool(header.get("rejected")))


def outside_result(job: Job, answer: Answer) -> RunResult:
    """Result of an engine of another package, checked as if it came from a stranger."""
    return result_of(job, reply_of(answer))
