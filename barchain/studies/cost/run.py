"""The cost study: a first pass for the errors, then rounds over all points for the times."""

from __future__ import annotations

import itertools
import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.common.equal_steps import step_s
from adapters.engine import AccuracyParameter
from barchain.runs.timing.bench import LONG_S, TimingBench
from barchain.runs.timing.left_out import failures
from barchain.runs.timing.load import OtherLoad
from barchain.runs.timing.statistics import median_time
from barchain.studies.cost.findings import equal_steps_row, front_of, orders_table, price_table, reach_table
from barchain.studies.cost.fixed_steps import ORDER, errors_at_equal_steps
from barchain.studies.cost.load_share import load_jobs, load_times
from barchain.studies.cost.measured_points import MeasuredPoints
from barchain.studies.cost.plan import sweeps
from barchain.studies.cost.points import UNITS, errors_of, under_floor
from barchain.studies.cost.reach import LONGER, SHORTENED
from reports.tables.outcome import Outcome
from reports.tables.rows import NOT_RUN

if TYPE_CHECKING:
    from collections.abc import Callable

    import pandas as pd

    from barchain.record.study_store import StudyStore
    from barchain.runs.job import Job, RunResult
    from barchain.runs.timing.left_out import LeftOut
    from barchain.studies.cost.plan import CostPlan
    from barchain.studies.cost.points import BoundedSolution
    from barchain.studies.study import Reporter
    from scenarios import Scene

FEWEST_TURNS = 3  # even where time is short: a median with its range
FEWEST_LONG_TURNS, LONG_TURNS = 1, 3  # of runs over LONG_S, the first pass counted
BRIEF_S = 0.03  # runs that take no longer get all their turns, even when time is short
BLURRED = "lie under the certified solution's own error"  # why a point is not tried
FIRST_SHARE = 0.5  # of a scene's time: then the first pass skips long runs, or the rounds would have none left
CHECK_SHARE = 0.25  # a prediction is trusted to this much over the limit before the run itself is ended


@dataclass(frozen=True)
class CostResult:
    """Findings of a study beside its tables."""

    idle: dict[str, str]
    """Engines that ran on none of the scenes, with the reason"""
    failures: tuple[str, ...] = ()
    """One line each; see :func:`barchain.runs.timing.left_out.failures`"""

    @property
    def passed(self) -> bool:
        """Whether every engine ran where it is supported."""
        return not self.failures


class CostRun:
    """One run of the study over many scenes and engines."""

    def __init__(
        self, plan: CostPlan, store: StudyStore, solution_of: Callable[[Scene], BoundedSolution], reporter: Reporter
    ) -> None:
        """Prepare; `reporter` gets scene, engine and setting, and outcome after each first run."""
        self.plan, self.store, self.solution_of = plan, store, solution_of
        self.report, self.note = reporter.step, reporter.note
        self.measured = MeasuredPoints(store)
        self.haste_at = math.inf
        self.equal_steps: list[dict[str, Any]] = []
        self.loads: list[dict[str, Any]] = []

    def run(self) -> CostResult:
        """Measure everything and write the tables; an interrupted run leaves the points measured so far."""
        start = time.perf_counter()
        try:
            with TimingBench() as bench:
                bench.start(self.usable())
                load = OtherLoad()
                for k, scene in enumerate(self.plan.scenes):
                    left_s = 60.0 * self.plan.minutes - (time.perf_counter() - start)
                    self.scene(bench, scene, time.perf_counter() + left_s / (len(self.plan.scenes) - k))
                    self.store.record["other_processors"] = load.processors()
        finally:
            self.write_tables()
        left_out = {out["engine"]: out["reason"] for out in self.store.record["left_out"]}
        idle = {name: reason for name, reason in left_out.items() if name not in self.ran}
        return CostResult(
            idle, failures((*self.measured.rows.values(), *self.store.record["left_out"]), self.plan.named)
        )

    @property
    def ran(self) -> set[str]:
        """Engines that ran on at least one of the scenes."""
        return {str(row["engine"]) for row in self.measured.rows.values()}

    def usable(self) -> list[str]:
        """Engines that run at least one of the scenes."""
        found = [sweeps(scene, self.plan.engines)[0] for scene in self.plan.scenes]
        return [name for name in self.plan.engines if any(name in runs for runs in found)]

    def scene(self, bench: TimingBench, scene: Scene, deadline: float) -> None:
        """First pass and rounds on one scene."""
        runs, left_out = sweeps(scene, self.plan.engines)
        for out in left_out:
            self.leave_out(out)
        solution = self.solution_of(scene)
        self.note_solution(solution)
        self.haste_at = time.perf_counter() + FIRST_SHARE * (deadline - time.perf_counter())
        self.first_pass(bench, solution, runs)
        self.rounds(bench, [job for row in by_setting(runs) for job in row], deadline)
        self.time_loads(bench, runs)
        self.equal_steps.append(equal_steps_row(scene.name, *errors_at_equal_steps(solution), ORDER))
        self.store.write("points", self.summed_up())

    def leave_out(self, out: LeftOut) -> None:
        """Note an engine that is not run."""
        found = {"scene": out.scene, "engine": out.engine, "outcome": str(out.outcome), "reason": out.reason}
        if found not in self.store.record["left_out"]:
            self.store.record["left_out"].append(found)
        self.report(out.scene, out.engine, str(out.outcome))

    def note_solution(self, solution: BoundedSolution) -> None:
        """Add source, precision and error of the certified solution to the record."""
        error = {name: float(np.max(values)) for name, values in solution.error.items()}
        words = {name: str(getattr(solution, name, "")) for name in ("precision", "source")}
        self.store.record["certified_solutions"][solution.scene.name] = words | {"error": error}

    def first_pass(self, bench: TimingBench, solution: BoundedSolution, runs: dict[str, list[Job]]) -> None:
        """One turn of every point, setting by setting over the engines; settings past the time limit are not run.

        A setting has one limit for all engines, whatever their order.
        """
        for level in by_setting(runs):
            limit_s = self.limit_s(solution.scene)
            for job in level:
                if job.key not in self.measured.rows:
                    self.first_turn(bench, solution, job, runs[job.engine], limit_s)
            self.store.write("points", self.measured.points())

    def limit_s(self, scene: Scene) -> float:
        """Time allowed to one run; less, and told, once the first pass has had its share of the scene's time."""
        if self.plan.time_limit_s <= LONG_S or time.perf_counter() <= self.haste_at:
            return self.plan.time_limit_s
        shortened = self.store.record["shortened_limits_s"]
        if scene.name not in shortened:
            shortened[scene.name] = LONG_S
            self.note(
                f"{scene.name}: {SHORTENED}, so runs expected to take longer than {LONG_S:g} s are left out from here "
                f"on, instead of {self.plan.time_limit_s:g} s; --minutes allows more"
            )
        return LONG_S

    def first_turn(
        self, bench: TimingBench, solution: BoundedSolution, job: Job, sweep: list[Job], limit_s: float
    ) -> None:
        """Errors of a point, and a first idea of its time."""
        coarser = [(c, self.measured.rows[c.key]) for c in sweep[: sweep.index(job)]]
        why = f", as {SHORTENED}" if limit_s < self.plan.time_limit_s else ""
        reason = too_long(coarser, job, limit_s, why) or too_fine([row for _, row in coarser])
        if reason:
            outcome = str(Outcome.NOTHING_COMPARED)
            self.measured.keep_point(job, {"outcome": outcome, "reason": f"{NOT_RUN}: {reason}"})
            self.report(job.scene.name, f"{job.engine} {job.setting}", outcome)
            return
        result = bench.run(job, (1.0 + CHECK_SHARE) * 2.0 * self.plan.time_limit_s)
        self.measured.keep_point(job, columns_of(job, result, solution))
        if result.outcome is Outcome.PASS and result.seconds["simulate"] >= LONG_S:
            self.measured.keep_time(job, result.seconds["simulate"])
        self.report(job.scene.name, f"{job.engine} {job.setting}", str(result.outcome))

    def rounds(self, bench: TimingBench, jobs: list[Job], deadline: float) -> None:
        """Time all good points in turn, again and again, until each is measured often enough or time is up."""
        good = [j for j in jobs if self.measured.rows[j.key]["outcome"] == Outcome.PASS.value]
        for turn in range(self.plan.repeats):
            for job in good:
                if self.wanted(job, turn, late=time.perf_counter() > deadline):
                    self.timed_turn(bench, job)
            if jobs:
                self.report(jobs[0].scene.name, f"round {turn + 1} of {self.plan.repeats}", str(Outcome.PASS))

    def timed_turn(self, bench: TimingBench, job: Job) -> None:
        """One more time of a point; one that can't be repeated even once is a failure."""
        result = bench.run(job, 10.0 * self.plan.time_limit_s)
        if result.outcome is Outcome.PASS:
            self.measured.keep_time(job, result.seconds["simulate"])
        elif not self.measured.times.get(job.key):
            self.measured.rows[job.key] |= {"outcome": str(result.outcome), "reason": result.reason}

    def wanted(self, job: Job, turn: int, *, late: bool) -> bool:
        """Whether a point lacks its time of this round; late, only the least number of times counts."""
        have = len(self.measured.times.get(job.key, []))
        seconds = self.measured.rows[job.key]["seconds"]
        enough = (FEWEST_LONG_TURNS, LONG_TURNS) if seconds >= LONG_S else (FEWEST_TURNS, self.plan.repeats)
        late = late and seconds > BRIEF_S
        return have <= turn and have < min(enough[0 if late else 1], self.plan.repeats)

    def time_loads(self, bench: TimingBench, runs: dict[str, list[Job]]) -> None:
        """Share of barchain's loads in the time of each engine that can tell."""
        for job in load_jobs(runs.values(), self.measured.rows):
            found = load_times(bench, job, 10.0 * self.plan.time_limit_s)
            if found is not None:
                self.loads.append(found.row)

    def summed_up(self) -> pd.DataFrame:
        """Points with medians and intervals of their times."""
        for key, row in self.measured.rows.items():
            times = np.array(self.measured.times.get(key, []))
            if len(times):
                spread = median_time(times)
                low, high = (spread.low, spread.high) if len(times) > 1 else (np.nan, np.nan)
                row |= {"seconds": spread.value, "seconds_low": low, "seconds_high": high, "turns": len(times)}
        points = self.measured.points()
        points["on_front"] = front_of(points)
        return points

    def write_tables(self) -> None:
        """Write all tables as they stand."""
        points = self.summed_up()
        self.store.write("points", points)
        self.store.write("orders", orders_table(points, self.plan.engines, self.equal_steps))
        self.store.write("reach", reach_table(points, self.measured.times_by_point()))
        self.store.write("price", price_table(points))
        self.store.write("loads", self.store.frame("loads", self.loads))


def by_setting(runs: dict[str, list[Job]]) -> list[list[Job]]:
    """Runs of all engines, one setting of their sweeps after the other: neighbours belong to different engines."""
    return [[job for job in level if job] for level in itertools.zip_longest(*runs.values())]


def too_long(coarser: list[tuple[Job, dict[str, Any]]], job: Job, limit_s: float, why: str = "") -> str:
    """Reason to skip a run: a coarser run timed out, or this one is expected to; empty if there is none.

    `why` tells of a shortened limit.
    """
    past = [row for _, row in coarser if row["outcome"] == Outcome.TIMED_OUT.value or LONGER in row["reason"]]
    if past:
        hasty = f", as {SHORTENED}" * any(SHORTENED in row["reason"] for row in past)
        return f"a coarser setting is {LONGER} already{hasty}"
    timed = [(c, float(row["seconds"])) for c, row in coarser if row.get("seconds", 0.0) > 0.0]
    if not timed:
        return ""
    last, seconds = timed[-1]
    growth = 1.0
    if job.setting.parameter is AccuracyParameter.STEPS_PER_ORBIT:
        growth = step_s(job.scene, last.setting.value) / step_s(job.scene, job.setting.value)
    elif len(timed) > 1:
        growth = max(1.0, seconds / timed[-2][1])
    expected_s = seconds * growth
    if expected_s <= limit_s:
        return ""
    return f"{LONGER}, {limit_s:g} s{why}: about {expected_s:.2g} s expected"


def too_fine(coarser: list[dict[str, Any]]) -> str:
    """Reason to skip a run: both coarser runs lie below the certified solution's own error; empty if there is none."""
    if coarser and BLURRED in coarser[-1]["reason"]:
        return f"coarser settings {BLURRED}"
    return f"coarser settings {BLURRED}" if len(coarser) > 1 and all(map(blurred, coarser[-2:])) else ""


def blurred(row: dict[str, Any]) -> bool:
    """Whether all errors of a point are below the certified solution's own."""
    present = {name for name, unit in UNITS.items() if row.get(f"{name}_error_{unit}", np.nan) >= 0.0}
    return bool(present) and present <= set(str(row.get("under_floor") or "").split(","))


def columns_of(job: Job, result: RunResult, solution: BoundedSolution) -> dict[str, Any]:
    """Columns of points.csv that a first run gives; errors of failed runs too, where they have a whole trajectory."""
    found: dict[str, Any] = {"outcome": str(result.outcome), "reason": result.reason}
    if job.setting.parameter is AccuracyParameter.STEPS_PER_ORBIT:
        found["step_s"] = step_s(job.scene, job.setting.value)
    spent, seen = result.seconds, result.trajectory
    renamed = {"simulate": "seconds", "build": "build_s", "read": "read_s", "cold": "compile_s"}
    found |= {renamed[phase]: s for phase, s in spent.items() if phase in renamed}
    if seen is None or (len(seen.t_s) < len(solution.trajectory.t_s) and not seen.ended):
        return found
    found |= {name: seen.info[name] for name in ("evaluations", "steps") if name in seen.info}
    if "compile_s" in seen.info:
        found["compile_s"] = seen.info["compile_s"]
    if result.outcome in (Outcome.PASS, Outcome.JOINTS_IGNORED):
        errors = errors_of(solution, seen)
        found |= errors | {"under_floor": under_floor(errors)}
    return found
