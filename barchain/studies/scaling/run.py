"""The scaling study: all engines at few bars, then at more, each until its time limit.

All engines go to :data:`COMMON_BARS` before any goes on, so that each has points enough for an exponent. Within that,
and beyond, what is cheap comes first: engines take turns as long as a point costs little more than its process, and
those that get expensive wait, so that a budget that runs out has been spent on as many points as it could.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from adapters.trajectory import Observable
from barchain.runs.call import Call, pickled
from barchain.runs.declared import engine_class
from barchain.runs.memory import installed
from barchain.runs.pool import PoolGroup, pool_group
from barchain.runs.timing.bench import STARTUP_S, quietest_core
from barchain.runs.timing.divided_chain import divided
from barchain.runs.timing.evaluation import DIRECT
from barchain.runs.timing.left_out import LeftOut, cannot, failures
from barchain.runs.timing.load import OtherLoad
from barchain.runs.workers import Slot
from barchain.studies.scaling.measured_points import ScalingPoints
from barchain.studies.scaling.plan import MEMORY_SHARE, SHARES, affordable, predicted
from barchain.studies.scaling.point import (
    BUILDS,
    LONG_TURNS,
    Measured,
    ScalingTask,
    measure_outside_point,
    measured_from,
    measured_message,
)
from reports.tables.outcome import Outcome
from reports.tables.rows import NOT_RUN

if TYPE_CHECKING:
    from barchain.record.study_store import StudyStore
    from barchain.runs.job import RunResult
    from barchain.studies.scaling.plan import ScalingPlan
    from barchain.studies.study import Reporter

WARM_BARS = 3  # not a number that is measured: an adapter may keep what it compiled for one
FAILURES = 2  # in succession, after which more bars are not tried
NEVER = (
    Outcome.UNSUPPORTED,
    Outcome.MISSING,
    Outcome.TIMED_OUT,
    Outcome.NOTHING_COMPARED,
)  # what more bars don't change
COMMON_BARS = 100
PROCESS_S = 4.0  # that a point takes whatever it runs: a process, imports, warming up, evaluations


@dataclass(frozen=True)
class ScalingResult:
    """Findings of a study beside its tables."""

    idle: dict[str, str]
    """Engines that could not be run at all, with the reason"""
    failures: tuple[str, ...] = ()
    """One line each; see :func:`barchain.runs.timing.left_out.failures`"""

    @property
    def passed(self) -> bool:
        """Whether every engine that supports the chain ran."""
        return not self.failures


class ScalingRun:
    """One run of the study over many engines on one chain."""

    def __init__(self, plan: ScalingPlan, store: StudyStore, reporter: Reporter) -> None:
        """Prepare; `reporter` gets scene, engine and bars, and outcome after each point."""
        self.plan, self.points, self.report = plan, ScalingPoints(store), reporter.step
        self.done: dict[str, int] = {}
        self.failed: dict[str, int] = {}
        self.deadline = math.inf
        for row in self.points.rows:
            self.count(row["engine"], Outcome(row["outcome"]))

    def run(self) -> ScalingResult:
        """Measure everything and write the tables; an interrupted run leaves the points measured so far."""
        self.deadline, load = time.perf_counter() + 60.0 * self.plan.minutes, OtherLoad()
        try:
            while ahead := {e: n for e in self.plan.engines if (n := self.next_bars(e))}:
                self.point(*min(ahead.items(), key=lambda pair: self.price(*pair)))
                self.points.store.record["other_processors"] = load.processors()
        finally:
            self.points.finish()
        return ScalingResult(self.idle, failures(self.points.rows, self.plan.named))

    @property
    def idle(self) -> dict[str, str]:
        """Engines that could not be run at all, and why."""
        out = (str(Outcome.MISSING), str(Outcome.UNSUPPORTED))
        ran = {row["engine"] for row in self.points.rows if row["outcome"] not in out}
        return {row["engine"]: row["reason"] for row in self.points.rows if row["engine"] not in ran}

    def next_bars(self, engine: str) -> int:
        """Bars of an engine's next point; 0 if there is none."""
        done = self.done.get(engine, 0)
        return 0 if done >= len(self.plan.bars) else self.plan.bars[done]

    def price(self, engine: str, bars: int) -> tuple[bool, float, int]:
        """Order of points: whether a point can wait, then its expected time, s, then its bars."""
        build_s, orbit_s = (predicted(*self.points.of(engine, name), bars) for name in ("build_s", "orbit_s"))
        run_s = affordable(orbit_s, self.plan.time_limit_s) * orbit_s
        return bars > COMMON_BARS, max(PROCESS_S, build_s + run_s), bars

    def point(self, engine: str, bars: int) -> None:
        """One engine at one number of bars; those that it can't get to are reported with it."""
        columns = self.columns(engine, bars)
        self.points.keep(engine, bars, columns)
        outcome = Outcome(columns["outcome"])
        self.report(self.plan.scene.name, f"{engine}, {bars} bars", str(outcome))
        for more in self.count(engine, outcome):
            self.report(self.plan.scene.name, f"{engine}, {more} bars", str(Outcome.NOTHING_COMPARED))

    def count(self, engine: str, outcome: Outcome) -> tuple[int, ...]:
        """Note that an engine's next point is done; bars that it is not tried at after that."""
        self.done[engine] = self.done.get(engine, 0) + 1
        if not self.hopeless(engine, outcome):
            return ()
        left = self.plan.bars[self.done[engine] :]
        self.done[engine] = len(self.plan.bars)
        return left

    def columns(self, engine: str, bars: int) -> dict[str, Any]:
        """Columns of a point, whether it can be run or not."""
        out = cannot(divided(self.plan.scene, bars), engine, self.plan.engines[engine]) or self.tracks_one(engine)
        if out is not None:
            return {"outcome": str(out.outcome), "reason": out.reason}
        share, reason = self.share(engine, bars)
        if not share and (engine not in DIRECT or time.perf_counter() > self.deadline):
            return {"outcome": str(Outcome.NOTHING_COMPARED), "reason": f"{NOT_RUN}: {reason}"}
        found = self.measured(engine, bars, share)
        columns = found.columns if isinstance(found, Measured) else {}
        said = f"orbit {NOT_RUN}: {reason}" if found.outcome is Outcome.PASS and reason else found.reason
        return {"outcome": str(found.outcome), "reason": said} | columns

    def tracks_one(self, engine: str) -> LeftOut | None:
        """Why an engine whose cost can't know of the bars is not measured."""
        if Observable.ATTITUDE in engine_class(self.plan.engines[engine]).observables:
            return None
        reason = "it follows the centre of mass alone, whatever the number of bars"
        return LeftOut(self.plan.scene.name, engine, Outcome.UNSUPPORTED, reason)

    def share(self, engine: str, bars: int) -> tuple[float, str]:
        """Share of an orbit to be run; 0 with the reason if none."""
        if time.perf_counter() > self.deadline:
            return 0.0, f"the study's {self.plan.minutes:g} minutes were over"
        build_s = predicted(*self.points.of(engine, "build_s"), bars)
        if build_s > BUILDS * self.plan.time_limit_s:
            return 0.0, f"building its model would take about {rounded(build_s)}"
        memory_B = predicted(*self.points.of(engine, "memory_B"), bars)
        if memory_B > MEMORY_SHARE * installed():
            return 0.0, f"its model would take about {memory_B / 1e9:.2g} GB of memory"
        orbit_s = predicted(*self.points.of(engine, "orbit_s"), bars)
        share = affordable(orbit_s, self.plan.time_limit_s)
        if share:
            return share, ""
        return 0.0, f"would take about {rounded(orbit_s)}, the smallest share {rounded(SHARES[-1] * orbit_s)}"

    def measured(self, engine: str, bars: int, share: float) -> RunResult:
        """Result of a point from a process of its own."""
        job, warm = self.plan.job(engine, bars, share or SHARES[-1]), self.plan.job(engine, WARM_BARS, SHARES[-1])
        task = ScalingTask(job, warm, share, self.plan.repeats, self.plan.time_limit_s)
        if pool_group(job) is PoolGroup.THIRD_PARTY:
            return measure_outside_point(task)
        allowed = STARTUP_S + (LONG_TURNS + BUILDS) * self.plan.time_limit_s
        slot = Slot()
        try:
            return measured_from(slot.run(pickled(Call(measured_message, (task, quietest_core()), allowed, pool=""))))
        finally:
            slot.close()

    def hopeless(self, engine: str, outcome: Outcome) -> bool:
        """Whether more bars are not worth a try."""
        self.failed[engine] = 0 if outcome is Outcome.PASS else self.failed.get(engine, 0) + 1
        return outcome in NEVER or self.failed[engine] >= FAILURES


def rounded(seconds: float) -> str:
    """Expected time to two digits, in the unit that suits it."""
    for unit, size_s in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * size_s:
            return f"{seconds / size_s:.2g} {unit}"
    return f"{seconds:.2g} s"
