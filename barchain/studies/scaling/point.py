"""One point of the study, in a fresh process: memory of the first whole run, then its time again and again."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from barchain.runs import questions
from barchain.runs.asking import reply_of
from barchain.runs.call import QUESTION_S, Call, CallEnd
from barchain.runs.job import Job, RunResult
from barchain.runs.message import message_bytes, plain_number, read_message
from barchain.runs.phases import Peak
from barchain.runs.run import failed_run, outside_call, outside_result, ran, result_of, run_job
from barchain.runs.tasks import PoolGroup, pool_group
from barchain.studies.timing.bench import LEAST_S, LONG_S, MOST_RUNS, STARTUP_S, pin, turn, warmed
from barchain.studies.timing.evaluation import DIRECT, evaluation_times, loop_of
from barchain.studies.timing.statistics import median_time
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from adapters.trajectory import Trajectory
    from barchain.runs.call import Answer
    from barchain.runs.cases import Case
    from barchain.studies.timing.bench import TimingBench
    from reports.results.rows import Row

BUILDS = 3.0  # a model may take this many times as long to build, or compile, as to run
LONG_TURNS = 3  # of runs over LONG_S, the first one counted
COUNTERS = ("evaluations", "steps")


@dataclass(frozen=True)
class ScalingTask:
    """Measurement of one point in a process."""

    job: Job
    """The chain, over the share of its orbit that is run"""
    warm: Job
    """Three bars for a moment: imports and compiling"""
    share: float
    """Of an orbit; 0 where only evaluations are wanted"""
    repeats: int


def measured_point(bench: TimingBench, task: ScalingTask, limit_s: float) -> Case[Row]:
    """Outcome, reason and measured columns of a point; `limit_s` is the wall time of one simulation, s."""
    if pool_group(task.job) is PoolGroup.THIRD_PARTY:
        return (yield from outside_point(bench, task, limit_s))
    allowed = STARTUP_S + (LONG_TURNS + BUILDS) * limit_s
    call = Call(point_message, (task,), allowed, pool="", aside=(limit_s, bench.core), worth_keeping=ran)
    (found,) = yield [bench.task(call, point_of)]
    row: Row = found
    return row


def point_of(answer: Answer) -> Row:
    """Columns of a point from the answer of its process."""
    if answer.end is not CallEnd.ANSWERED:
        return row_of(failed_run(answer))
    header, _ = read_message(answer.content)
    return {name: value for name, value in header.items() if name != "ran"}


def point_message(task: ScalingTask, limit_s: float, core: int | None) -> bytes:
    """Message with :func:`own_point`, run on one core."""
    pin(core)
    found = own_point(task, limit_s)
    return message_bytes(found | {"ran": found["outcome"] == Outcome.PASS.value}, {})


def row_of(result: RunResult, words: str = "") -> Row:
    """Columns of a point whose run is the end of it."""
    return {"outcome": str(result.outcome), "reason": f"{result.reason}{words}"}


def own_point(task: ScalingTask, limit_s: float) -> Row:
    """Warm up, take the memory of one whole run, then times."""
    warm = run_job(task.warm)
    if warm.outcome is not Outcome.PASS:
        return row_of(warm, " (on three bars, to warm up)")
    peak = Peak()
    first = run_job(task.job) if task.share else RunResult(Outcome.PASS)
    if first.outcome is not Outcome.PASS:
        return row_of(first)
    columns: Row = {"memory_B": peak.beyond()} if task.share else {}
    if task.job.engine in DIRECT:  # its right-hand side is timed by itself
        columns |= spread(
            "evaluation", evaluation_times([loop_of(task.job.engine, task.job.scene)], task.repeats)[:, 0]
        )
        columns["per"] = "right-hand side"
    if task.share:
        warmed.add(task.job.scene.digest)  # the first run was the one that is not timed
        again = (run_job(task.job) for _ in range(more_runs(first, limit_s)))
        turns = (turn(task.job, LEAST_S) for _ in range(task.repeats))
        seconds = [r.seconds["simulate"] for r in (again if is_long(first) else turns) if r.outcome is Outcome.PASS]
        columns = run_columns(task, first, seconds) | columns
    return row_of(RunResult(Outcome.PASS)) | columns


def outside_point(bench: TimingBench, task: ScalingTask, limit_s: float) -> Case[Row]:
    """Measure an engine of another package as :func:`own_point` does, each run in a process of its own."""
    job, run_s = task.job, QUESTION_S + (BUILDS + 1.0) * limit_s
    (reply,) = yield [bench.task(outside_call(questions.first_run, job, run_s, task.warm.scene), reply_of)]
    first, memory_B = result_of(job, reply), plain_number(reply.header.get("memory_B"))
    if first.outcome is not Outcome.PASS:
        return row_of(first)
    if is_long(first):
        numbers = range(1, 1 + more_runs(first, limit_s))
        calls = [outside_call(questions.run, job, run_s, repetition=k) for k in numbers]
    else:
        asked = job, run_s + limit_s, LEAST_S, MOST_RUNS
        calls = [outside_call(questions.turn, *asked, repetition=k) for k in range(task.repeats)]
    seconds = []
    for call in calls:
        (result,) = yield [bench.task(call, partial(outside_result, job))]
        if result.outcome is Outcome.PASS:
            seconds.append(result.seconds["simulate"])
    columns = run_columns(task, first, seconds)
    return row_of(RunResult(Outcome.PASS)) | columns | {"memory_B": math.nan if memory_B is None else float(memory_B)}


def is_long(first: RunResult) -> bool:
    """Whether a run is timed from the first time on, and seldom repeated."""
    return first.seconds["simulate"] >= LONG_S


def more_runs(first: RunResult, limit_s: float) -> int:
    """Number of further runs of a long one for which the limit leaves room."""
    return max(0, min(LONG_TURNS, int(limit_s / max(first.seconds["simulate"], LONG_S))) - 1)


def run_columns(task: ScalingTask, first: RunResult, further_s: list[float]) -> Row:
    """Time of a simulation, an orbit, and an evaluation or step; the first run's counts if it is long or alone."""
    counts_first = is_long(first) or not further_s
    seconds = np.array([*([first.seconds["simulate"]] if counts_first else []), *further_s])
    columns: Row = {"share": task.share, "turns": len(seconds)}
    columns |= {"build_s": first.seconds["build"], "simulate_s": float(np.median(seconds))}
    columns |= spread("orbit", seconds / task.share)
    counts = counted(first.trajectory)
    columns |= {name: count / task.share for name, count in counts.items()}
    per = next((name for name in COUNTERS if name in counts), "")
    if per:
        columns |= spread("evaluation", seconds / counts[per]) | {"per": per}
    return columns


def counted(trajectory: Trajectory | None) -> dict[str, float]:
    """Evaluations and steps, where the engine counts them."""
    info = {} if trajectory is None else trajectory.info
    return {name: float(info[name]) for name in COUNTERS if float(info.get(name, 0.0)) > 0.0}


def spread(name: str, times: np.ndarray) -> dict[str, float]:
    """Median with its interval, as columns."""
    return median_time(times).columns(name, f"{name}_s")
