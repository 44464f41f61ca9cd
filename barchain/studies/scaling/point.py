"""One point of the study, in a fresh process: memory of the first whole run, then its time again and again."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from barchain.runs.call import Answer, CallEnd
from barchain.runs.job import Job, RunResult
from barchain.runs.limits import QUESTION_S
from barchain.runs.memory import Peak
from barchain.runs.message import message_bytes, read_message
from barchain.runs.messages import failed_run
from barchain.runs.outside_runs import one_first_run, one_run, one_turn
from barchain.runs.run import run_job
from barchain.runs.timing.bench import LEAST_S, LONG_S, MOST_RUNS, pin, turn, warmed
from barchain.runs.timing.evaluation import DIRECT, evaluation_times, loop_of
from barchain.runs.timing.statistics import median_time
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from adapters.trajectory import Trajectory

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
    limit_s: float

    @property
    def direct(self) -> bool:
        """Whether the engine's right-hand side is timed by itself."""
        return self.job.engine in DIRECT


@dataclass(frozen=True)
class TimedRuns:
    """Further runs of a point after its first."""

    again: Callable[[], RunResult]
    """A whole run"""
    turn: Callable[[], RunResult]
    """A turn of short runs; its times are the least of them"""


@dataclass(frozen=True)
class Measured(RunResult):
    """Result of a point, without the trajectory."""

    columns: dict[str, float | str] = field(default_factory=dict)
    """Of points.csv"""


def measured_message(task: ScalingTask, core: int | None) -> bytes:
    """Message with :func:`measure_point`, run on one core."""
    pin(core)
    found = measure_point(task)
    return message_bytes({"outcome": str(found.outcome), "reason": found.reason, "columns": found.columns}, {})


def measured_from(answer: Answer) -> Measured:
    """Measured point from the answer to :func:`measured_message`, or why there is none."""
    if answer.end is not CallEnd.ANSWERED:
        lost = failed_run(answer)
        return Measured(lost.outcome, lost.reason)
    header, _ = read_message(answer.content)
    return Measured(Outcome(header["outcome"]), header["reason"], columns=header["columns"])


def measure_point(task: ScalingTask) -> Measured:
    """Warm up, take the memory of one whole run, then times."""
    warm = run_job(task.warm)
    if warm.outcome is not Outcome.PASS:
        return Measured(warm.outcome, f"{warm.reason} (on three bars, to warm up)")
    peak = Peak()
    first = run_job(task.job) if task.share else RunResult(Outcome.PASS)
    if first.outcome is not Outcome.PASS:
        return Measured(first.outcome, first.reason)
    columns: dict[str, float | str] = {"memory_B": peak.beyond()} if task.share else {}
    if task.direct:
        columns |= spread("evaluation", evaluation_times(loop_of(task.job.engine, task.job.scene), task.repeats))
        columns["per"] = "right-hand side"
    if task.share:
        own = TimedRuns(lambda: run_job(task.job), lambda: turn(task.job, LEAST_S))
        warmed.add(task.job.scene.digest)  # the first run was the one that is not timed
        columns = run_columns(task, first, own) | columns
    return Measured(Outcome.PASS, columns=columns)


def measure_outside_point(task: ScalingTask) -> Measured:
    """Measure an engine of another package as :func:`measure_point` does, each run in a process of its own."""
    build_s = BUILDS * task.limit_s
    first, memory_B = one_first_run(task.job, QUESTION_S + build_s + task.limit_s, task.warm.scene)
    if first.outcome is not Outcome.PASS:
        return Measured(first.outcome, first.reason)
    turn_s = QUESTION_S + build_s + 2.0 * task.limit_s
    runs = TimedRuns(
        lambda: one_run(task.job, QUESTION_S + build_s + task.limit_s),
        lambda: one_turn(task.job, turn_s, LEAST_S, MOST_RUNS),
    )
    return Measured(Outcome.PASS, columns=run_columns(task, first, runs) | {"memory_B": memory_B})


def run_columns(task: ScalingTask, first: RunResult, runs: TimedRuns) -> dict[str, float | str]:
    """Time of a simulation, of an orbit, and of an evaluation or step."""
    seconds = np.array(simulated(task, first, runs))
    columns: dict[str, float | str] = {"share": task.share, "turns": len(seconds)}
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


def simulated(task: ScalingTask, first: RunResult, runs: TimedRuns) -> list[float]:
    """Times of `simulate`: of a long run the first and a few more if the limit leaves room, else of whole turns."""
    one = first.seconds["simulate"]
    if one >= LONG_S:
        more = min(LONG_TURNS, int(task.limit_s / one)) - 1
        return [one, *passed(runs.again() for _ in range(more))]
    return passed(runs.turn() for _ in range(task.repeats)) or [one]


def passed(results: Iterable[RunResult]) -> list[float]:
    """Times of `simulate` of the runs that passed."""
    return [r.seconds["simulate"] for r in results if r.outcome is Outcome.PASS]


def spread(name: str, times: np.ndarray) -> dict[str, float]:
    """Median with its interval, as columns."""
    found = median_time(times)
    low, high = (found.low, found.high) if len(times) > 1 else (np.nan, np.nan)
    return {f"{name}_s": found.value, f"{name}_low": low, f"{name}_high": high}
