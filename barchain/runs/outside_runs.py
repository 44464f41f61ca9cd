"""Runs of engines of other packages: the answer is checked here as if it came from a stranger."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from adapters.engine import EngineError
from adapters.trajectory import Trajectory
from barchain.runs.asking import Reply, ask
from barchain.runs.declared import engine_class
from barchain.runs.job import RunResult, failure
from barchain.runs.limits import OutsideLimits
from barchain.runs.message import MessageError, plain_info, plain_number, plain_text
from barchain.runs.questions import ARRAYS
from barchain.runs.trajectory_checks import fault, shape_fault
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from adapters.trajectory import Array
    from barchain.runs.job import Job

OUTCOMES = {"missing": Outcome.MISSING, "timed_out": Outcome.TIMED_OUT}


def one_run(job: Job, time_s: float) -> RunResult:
    """Result of one run; never an exception for what the engine does."""
    asked = (job.registration, job.options, job.scene, job.setting)
    return result_of(job, ask("run", *asked, limits=OutsideLimits(time_s)))


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
    seconds, trajectory = durations(reply.header.get("seconds")), trajectory_from(reply.header, reply.arrays)
    engine = engine_class(job.registration)
    wrong = shape_fault(job.scene, trajectory)
    if wrong:
        return failure(*wrong)
    found = fault(job.scene, engine, trajectory)
    if found:
        return RunResult(found[0], found[1], trajectory, seconds)
    return RunResult(Outcome.PASS, trajectory.ended, trajectory, seconds)


def trajectory_from(header: dict[str, Any], arrays: dict[str, Array]) -> Trajectory:
    """Trajectory from the parts of an answer.

    Raises
    ------
    MessageError
        If a part is missing, unknown or of a wrong type.
    """
    unknown = sorted(set(arrays) - set(ARRAYS))
    if unknown:
        raise MessageError(f"its answer holds unknown arrays: {plain_text(', '.join(unknown))}")
    try:
        ended, info = plain_text(header.get("ended", "")), plain_info(header.get("info"))
        return Trajectory(**arrays, ended=ended, info=info, scene="", engine="", setting="", torque_bars=())
    except TypeError as error:
        raise MessageError(f"its answer is incomplete: {plain_text(error)}") from None


def durations(given: object) -> dict[str, float]:
    """Wall times by phase from an answer, s."""
    found = given if isinstance(given, dict) else {}
    return {plain_text(k, 20): float(plain_number(v) or 0.0) for k, v in found.items()}
