"""One point of the study, in a fresh process: memory of the first whole run, then its time again and again."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.runs.asking import reply_of
from barchain.runs.call import QUESTION_S, Answer, Call, CallEnd
from barchain.runs.job import Job, RunResult
from barchain.runs.measuring import Peak
from barchain.runs.message import message_bytes, plain_number, read_message
from barchain.runs.run import failed_run, outside_call, ran, result_of, run_job
from barchain.runs.tasks import PoolGroup, pool_group
from barchain.runs.timing.bench import LEAST_S, LONG_S, MOST_RUNS, STARTUP_S, pin, quietest_core, turn, warmed
from barchain.runs.timing.evaluation import DIRECT, evaluation_times, loop_of
from barchain.runs.timing.statistics import median_time
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from adapters.trajectory import Trajectory

BUILDS = 3.0  # a model may take this many times as long to build, or compile, as to run
LONG_TURNS = 3  # of runs over LONG_S, the first one counted
COUNTERS = ("evaluations", "steps")

Row = dict[str, Any]


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


def measured_point(task: ScalingTask, limit_s: float, ask: Callable[[Call], Answer]) -> Row:
    """Outcome, reason and measured columns of a point.

    Parameters
    ----------
    task : ScalingTask
    limit_s : float
        Wall time of one simulation, s.
    ask : callable
        Gives the answer of a process of its own to a call.
    """
    if pool_group(task.job) is PoolGroup.THIRD_PARTY:
        return outside_point(task, limit_s, ask)
    allowed = STARTUP_S + (LONG_TURNS + BUILDS) * limit_s
    aside = limit_s, quietest_core()
    answer = ask(Call(point_message, (task,), allowed, pool="", aside=aside, worth_keeping=ran))
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
        columns |= spread("evaluation", evaluation_times(loop_of(task.job.engine, task.job.scene), task.repeats))
        columns["per"] = "right-hand side"
    if task.share:
        warmed.add(task.job.scene.digest)  # the first run was the one that is not timed
        seconds = simulated(task, limit_s, first, lambda _: run_job(task.job), lambda _: turn(task.job, LEAST_S))
        columns = run_columns(task, first, seconds) | columns
    return row_of(RunResult(Outcome.PASS)) | columns


def outside_point(task: ScalingTask, limit_s: float, ask: Callable[[Call], Answer]) -> Row:
    """Measure an engine of another package as :func:`own_point` does, each run in a process of its own."""
    run_s = QUESTION_S + (BUILDS + 1.0) * limit_s
    reply = reply_of(ask(outside_call("first_run", task.job, run_s, task.warm.scene)))
    first, memory_B = result_of(task.job, reply), plain_number(reply.header.get("memory_B"))
    if first.outcome is not Outcome.PASS:
        return row_of(first)

    def again(number: int) -> RunResult:
        return result_of(task.job, reply_of(ask(outside_call("run", task.job, run_s, repetition=number))))

    def turned(number: int) -> RunResult:
        call = outside_call("turn", task.job, run_s + limit_s, LEAST_S, MOST_RUNS, repetition=number)
        return result_of(task.job, reply_of(ask(call)))

    columns = run_columns(task, first, simulated(task, limit_s, first, again, turned))
    return row_of(RunResult(Outcome.PASS)) | columns | {"memory_B": math.nan if memory_B is None else float(memory_B)}


def simulated(
    task: ScalingTask,
    limit_s: float,
    first: RunResult,
    again: Callable[[int], RunResult],
    turned: Callable[[int], RunResult],
) -> list[float]:
    """Times of `simulate`, s: of a long run the first and a few more if the limit leaves room, else of whole turns.

    `again` makes a whole run, `turned` a turn of short runs, whose times are the least of them; both get a number.
    """
    one = first.seconds["simulate"]
    if one >= LONG_S:
        return [one, *passed(map(again, range(1, min(LONG_TURNS, int(limit_s / one)))))]
    return passed(map(turned, range(task.repeats))) or [one]


def passed(results: Iterable[RunResult]) -> list[float]:
    """Times of `simulate` of the runs that passed."""
    return [r.seconds["simulate"] for r in results if r.outcome is Outcome.PASS]


def run_columns(task: ScalingTask, first: RunResult, simulated_s: list[float]) -> Row:
    """Time of a simulation, of an orbit, and of an evaluation or step."""
    seconds = np.array(simulated_s)
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
    found = median_time(times)
    low, high = (found.low, found.high) if len(times) > 1 else (np.nan, np.nan)
    return {f"{name}_s": found.value, f"{name}_low": low, f"{name}_high": high}
