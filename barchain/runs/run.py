"""A run of an engine: the call that makes it, the work in its process, and the result, checked here.

barchain's own adapters check their trajectory in the process of the run. The answer of an engine of another package is
checked here as if it came from a stranger. Both come as text and float64 arrays, which are read without running code.
"""

from __future__ import annotations

import contextlib
import dataclasses
import math
import tempfile
from typing import TYPE_CHECKING, Any

from adapters.engine import EngineError
from adapters.trajectory import Trajectory
from barchain.runs import questions
from barchain.runs.asking import Reply, ask, declarations_of, failed_reply, question_call, reply_of
from barchain.runs.call import Answer, Call, CallEnd
from barchain.runs.environment import temporary_root
from barchain.runs.job import RunResult, failure
from barchain.runs.message import MessageError, message_bytes, plain_info, plain_number, plain_text, read_message
from barchain.runs.phases import failed, three_phases
from barchain.runs.questions import ARRAYS, sendable
from barchain.runs.same_code import need_same_version, version_of
from barchain.runs.trajectory_checks import fault, shape_fault
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from adapters.engine import Declarations
    from adapters.trajectory import Array
    from barchain.record.study_store import StudyStore
    from barchain.runs.asking import Question
    from barchain.runs.job import Job, TimeLimit
    from scenarios import Scene

OUTCOMES = {"missing": Outcome.MISSING, "timed_out": Outcome.TIMED_OUT, "unsupported": Outcome.UNSUPPORTED}


def run_job(job: Job, simulate_s: float | None = None) -> RunResult:
    """Run `job` of barchain's own adapter in a temporary folder; every exception becomes a failure.

    Parameters
    ----------
    job : Job
    simulate_s : float, optional
        Wall time after which the engine's ``simulate`` ends this process by SIGALRM, s.
    """
    with temporary_folder() as folder, contextlib.chdir(folder):
        try:
            registration = job.registration
            seen, seconds = three_phases(registration.engine(job.options), job.scene, job.setting, simulate_s)
            return checked_result(job.scene, registration.declarations(), seen, seconds)
        except BaseException as error:  # also SystemExit: all are the engine's
            return failed_result(job, failed_reply(failed(error)))


def temporary_folder() -> tempfile.TemporaryDirectory[str]:
    """Folder for one run, removed with the comparing process's at the latest."""
    return tempfile.TemporaryDirectory(dir=temporary_root(), ignore_cleanup_errors=True)


def checked_result(scene: Scene, engine: Declarations, trajectory: Trajectory, seconds: dict[str, float]) -> RunResult:
    """Result of a run with a trajectory, which is checked here; `seconds` by phase."""
    outcome, reason = fault(scene, engine, trajectory) or (Outcome.PASS, trajectory.ended)
    return RunResult(outcome, reason, trajectory, seconds)


def shared_call(job: Job, limit: TimeLimit, pool: str, runs_per_worker: int, *, own_work: bool = False) -> Call:
    """Run of barchain's own adapter, in a process that runs of the same pool share.

    Parameters
    ----------
    job : Job
    limit : TimeLimit
    pool : str
        Runs of one pool share processes.
    runs_per_worker : int
        Number of runs after which a process is replaced.
    own_work : bool
        Whether the run serves judging: its limit is processor time, and `simulate` has none of its own.
    """
    return Call(
        shared_run, (job, version_of(job.registration)), limit.allowed_s(job), pool, runs_per_worker, own_work,
        aside=(None if own_work else limit.simulate_s(job),), worth_keeping=ran,
    )  # fmt: skip


def shared_run(job: Job, version: str, simulate_s: float | None = None) -> bytes:
    """Run a job in this process; `simulate_s` as in :func:`run_job`.

    Raises
    ------
    WrongWorkerError
        If the engine's package has another version here.
    """
    need_same_version(version_of(job.registration), version)
    return message_of(run_job(job, simulate_s))


def message_of(result: RunResult) -> bytes:
    """Message with a result; a trajectory that can't be sent is dropped with the reason."""
    seen = result.trajectory
    try:
        arrays = {} if seen is None else sendable(seen, keep_order=True)
        words = {} if seen is None else {"ended": seen.ended, "info": plain_info(seen.info)}
    except MessageError as error:
        if result.outcome is Outcome.PASS:
            return message_of(failure(Outcome.FAILED, str(error)))
        return message_of(dataclasses.replace(result, trajectory=None))
    header = {
        "outcome": str(result.outcome), "reason": result.reason, "seconds": result.seconds,
        "rejected": result.rejected, "ran": seen is not None, **words,
    }  # fmt: skip
    return message_bytes(header, arrays)


def shared_result(job: Job, answer: Answer) -> RunResult:
    """Result of :func:`shared_run`, checked."""
    if answer.end is not CallEnd.ANSWERED:
        return failed_run(answer)
    try:
        header, arrays = read_message(answer.content)
        outcome, reason = Outcome(str(header.get("outcome"))), plain_text(header.get("reason", ""))
        trajectory = trajectory_from(header, arrays) if header.get("ran") else None
        wrong = shape_fault(job.scene, trajectory) if trajectory is not None and outcome is Outcome.PASS else None
        seconds, rejected = durations(header.get("seconds")), bool(header.get("rejected"))
    except (MessageError, ValueError, TypeError) as error:
        return failure(Outcome.FAILED, f"its result is damaged: {plain_text(error)}")
    return failure(*wrong) if wrong else RunResult(outcome, reason, trajectory, seconds, rejected)


def failed_run(answer: Answer) -> RunResult:
    """Result of a run whose call gave no answer; `simulate` had not ended where its own timer ended the process."""
    if answer.end is CallEnd.OWN_TIMER:
        return RunResult(Outcome.TIMED_OUT, answer.reason, seconds={"simulate": math.inf})
    return failure(Outcome.TIMED_OUT if answer.end is CallEnd.TIMED_OUT else Outcome.FAILED, answer.reason)


def ran(content: bytes) -> bool:
    """Whether the message of a run tells of a trajectory: a run that failed is tried again."""
    try:
        header, _ = read_message(content)
    except MessageError:
        return False
    return "failed" not in header and header.get("ran") is not False


def outside_call(question: Question, job: Job, limit_s: float, *more: Any, repetition: int = 0) -> Call:
    """Run of an engine of another package, in a process of its own behind the boundary.

    Parameters
    ----------
    question : callable
        ``run``, ``turn`` or ``first_run`` of :mod:`barchain.runs.questions`.
    job : Job
    limit_s : float
        Wall time of the process, s.
    *more : Any
        Further arguments of the question.
    repetition : int
        Number of a measurement that is made several times.
    """
    call = question_call(question, *asked(job), *more, limit_s=limit_s, version=version_of(job.registration))
    return dataclasses.replace(call, repetition=repetition, worth_keeping=ran)


def asked(job: Job) -> tuple[Any, ...]:
    """Arguments of a question that runs a job."""
    return job.registration, job.options, job.scene, job.setting


def outside_result(job: Job, answer: Answer) -> RunResult:
    """Result of an engine of another package from the answer to a call."""
    return result_of(job, reply_of(answer))


def one_run(job: Job, time_s: float) -> RunResult:
    """Result of one run of an engine of another package; never an exception for what the engine does."""
    return result_of(job, ask(questions.run, *asked(job), limit_s=time_s))


def result_of(job: Job, reply: Reply) -> RunResult:
    """Result of an engine of another package; a trajectory of wrong shapes is dropped."""
    if reply.problem:
        return failed_result(job, reply)
    try:
        trajectory, engine = trajectory_from(reply.header, reply.arrays), declarations_of(job.registration)
    except (MessageError, EngineError) as error:
        return failure(Outcome.FAILED, str(error))
    if wrong := shape_fault(job.scene, trajectory):
        return failure(*wrong)
    return checked_result(job.scene, engine, trajectory, durations(reply.header.get("seconds")))


def failed_result(job: Job, reply: Reply) -> RunResult:
    """Result of a run without an answer; of a library that is missing, with the command that installs it."""
    outcome = OUTCOMES.get(reply.kind, Outcome.FAILED)
    hint = f"; try: {job.registration.install}" if outcome is Outcome.MISSING else ""
    return failure(outcome, reply.problem + hint, rejected=reply.rejected, phase=reply.phase)


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
        return Trajectory(
            **arrays, ended=ended, info=info, scene="", engine="", setting="", torque_bars=(), run_scene=None
        )
    except TypeError as error:
        raise MessageError(f"its answer is incomplete: {plain_text(error)}") from None


def durations(given: object) -> dict[str, float]:
    """Wall times by phase from an answer, s."""
    found = given if isinstance(given, dict) else {}
    return {plain_text(k, 20): float(plain_number(v) or 0.0) for k, v in found.items()}


def keep_run(store: StudyStore, job: Job, result: RunResult) -> None:
    """Write a run's samples as the series ``trajectories/<scene>/<engine>``, and note the run in the record."""
    from reports.results.reading import digest  # noqa: PLC0415  # processes of runs need no tables
    from reports.results.rows import frame_digest  # noqa: PLC0415
    from reports.results.writing import parquet  # noqa: PLC0415

    trajectory = result.trajectory
    frame = None if trajectory is None else trajectory.of_run(job.scene).to_frame()
    content = None if frame is None else parquet(frame)
    name = f"trajectories/{job.scene.name}/{job.file_stem}"
    file = None if content is None else store.files.series_name(name)
    store.record["runs"].append({
        "scene": job.scene.name,
        "engine": job.engine,
        "setting": str(job.setting),
        "role": str(job.role),
        "outcome": str(result.outcome),
        "reason": result.reason,
        "seconds": result.seconds,
        "info": {} if trajectory is None else trajectory.info,
        "file": file,
        "digest": None if content is None else digest(content),
        "rejected": result.rejected,
        "bits": "" if frame is None else frame_digest(frame),
    })  # fmt: skip
    if file is None or content is None:
        store.write_record()
    else:
        store.write_file(file, content)
