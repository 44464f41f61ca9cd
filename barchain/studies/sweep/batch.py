"""Runs of one engine that are made in one call, each measured where it is made.

A run of a short scene takes less time than the call that asks for it: the call, its process and its answer.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.registry import ENGINES
from barchain.metrics.derived import DerivedError, Motion, channel_columns
from barchain.runs.call import Call, CallEnd
from barchain.runs.cases import Task
from barchain.runs.job import COMPILE_S, Job, Role, failure
from barchain.runs.left_out import cannot
from barchain.runs.message import MessageError, message_bytes, plain_text, read_message
from barchain.runs.run import failed_run, ran, run_job
from barchain.runs.same_code import need_same_version, version_of
from barchain.runs.tasks import limit_of, run_task
from barchain.studies.sweep.variation import VariedScene
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from adapters.engine import Setting
    from adapters.registry import Registration
    from barchain.runs.call import Answer
    from barchain.runs.cases import Case
    from barchain.runs.job import RunResult
    from barchain.studies.sweep.measure import Measure
    from scenarios import Scene

RUNS_PER_PROCESS = 400
"""As some engines leak memory with every model"""
POOL = "sweep"


@dataclass(frozen=True)
class MeasuredRun:
    """End of a run, and its measures."""

    outcome: str
    reason: str
    """Why it failed or ended early, or what can't be measured"""
    seconds: float
    """Wall time of `simulate`; NaN of a run that failed"""
    values: tuple[float, ...]
    """One for each measure; NaN without"""


@dataclass(frozen=True)
class Batch:
    """Runs of one engine."""

    scene: Scene
    """As its file gives it"""
    engine: str
    registration: Registration
    setting: Setting
    measures: tuple[Measure, ...]
    paths: tuple[str, ...]
    """Numbers that vary"""
    points: tuple[tuple[float, ...], ...]
    """Their values in each run"""

    def jobs(self) -> list[Job]:
        """Its runs."""
        varied = VariedScene(self.scene)
        scenes = [varied.at(dict(zip(self.paths, point, strict=True))) for point in self.points]
        return [Job(scene, self.engine, self.registration, self.setting, Role.MAIN) for scene in scenes]

    def call(self, limit_s: float) -> Call:
        """Call that makes all runs; `limit_s` is the wall time of each."""
        count = len(self.points)
        more_s = COMPILE_S if self.registration.compiles else 0.0
        return Call(
            batch_bytes, (self, version_of(self.registration)), count * limit_s + more_s, POOL,
            max(1, RUNS_PER_PROCESS // count), aside=(limit_s,), worth_keeping=ran,
        )  # fmt: skip


def runs_of(batch: Batch, limit_s: float) -> Case[list[MeasuredRun]]:
    """Make the runs of a batch: those of barchain's own adapters in one call, others each behind the boundary.

    A run that ends its process, or is ended at its limit, costs its batch: every run of it is then made by itself.
    """
    if batch.registration not in ENGINES.values():
        return (yield from single_runs(batch, limit_s))
    (answer,) = yield [Task(batch.call(limit_s), lambda answer: answer)]
    found = runs_in(batch, answer)
    if found is None and len(batch.points) > 1:
        single = [replace(batch, points=(point,)) for point in batch.points]
        answers = yield [Task(one.call(limit_s), lambda answer: answer) for one in single]
        return [run for one, own in zip(single, answers, strict=True) for run in runs_in(one, own) or [lost(one, own)]]
    return found or [lost(batch, answer)]


def single_runs(batch: Batch, limit_s: float) -> Case[list[MeasuredRun]]:
    """Runs of an engine of another package, measured here."""
    jobs = batch.jobs()
    out = [cannot(job.scene, job.engine, job.registration) for job in jobs]
    able = [job for job, reason in zip(jobs, out, strict=True) if reason is None]
    results = iter((yield [run_task(job, limit_of(job, limit_s)) for job in able]))
    return [
        measured(batch.measures, job, failure(reason.outcome, reason.reason) if reason else next(results))
        for job, reason in zip(jobs, out, strict=True)
    ]


def batch_bytes(batch: Batch, version: str, limit_s: float) -> bytes:
    """Message with the runs of a batch, made in this process.

    Raises
    ------
    WrongWorkerError
        If the engine's package has another version here.
    """
    need_same_version(version_of(batch.registration), version)
    runs = []
    for job in batch.jobs():
        reason = batch.registration.declarations().unsupported(job.scene)
        result = failure(Outcome.UNSUPPORTED, reason) if reason else run_job(job, limit_s)
        runs.append(measured(batch.measures, job, result))
    good = {Outcome.PASS.value, Outcome.UNSUPPORTED.value}
    header = {"runs": [[run.outcome, run.reason] for run in runs], "ran": all(run.outcome in good for run in runs)}
    arrays = {"seconds": np.array([run.seconds for run in runs]), "values": np.array([run.values for run in runs])}
    return message_bytes(header, arrays)


def measured(measures: tuple[Measure, ...], job: Job, result: RunResult) -> MeasuredRun:
    """Measures of a run; what it does not give is its reason."""
    seen = result.trajectory if result.outcome is Outcome.PASS else None
    if seen is None:
        return MeasuredRun(str(result.outcome), result.reason, math.nan, (math.nan,) * len(measures))
    columns_of = cache(partial(channel_columns, Motion(seen.of_run(job.scene, job.engine, str(job.setting)))))
    values, reasons = [], [result.reason] if result.reason else []
    for measure in measures:
        try:
            values.append(measure.of(columns_of(measure.channel.name)))
        except DerivedError as error:
            values.append(math.nan)
            reasons.append(str(error))
    said = "; ".join(dict.fromkeys(reasons))
    return MeasuredRun(str(result.outcome), said, result.seconds.get("simulate", math.nan), tuple(values))


def runs_in(batch: Batch, answer: Answer) -> list[MeasuredRun] | None:
    """Runs of a batch from the answer to its call; None if there is none, or a damaged one."""
    if answer.end is not CallEnd.ANSWERED:
        return None
    try:
        header, arrays = read_message(answer.content)
        ends: Any = header["runs"]
        count = len(batch.points)
        seconds, values = arrays["seconds"].reshape(count), arrays["values"].reshape(count, len(batch.measures))
        return [
            MeasuredRun(str(Outcome(outcome)), plain_text(reason), float(s), tuple(row))
            for (outcome, reason), s, row in zip(ends, seconds, values.tolist(), strict=True)
        ]
    except (MessageError, KeyError, TypeError, ValueError):
        return None


def lost(batch: Batch, answer: Answer) -> MeasuredRun:
    """Run without an answer."""
    damaged = answer.end is CallEnd.ANSWERED
    result = failure(Outcome.FAILED, "its result is damaged") if damaged else failed_run(answer)
    return MeasuredRun(str(result.outcome), result.reason, math.nan, (math.nan,) * len(batch.measures))
