"""The cost study: errors against the certified solution and times, for every setting of every engine.

A first pass over all settings gives the errors, then rounds over all good points the times. Each turn of an engine is
an answer that is kept: a study that goes on finds there what was measured.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from adapters.common.equal_steps import step_s
from adapters.engine import AccuracyParameter
from adapters.registry import engines
from barchain.runs.choices import chosen_engines, unique_names
from barchain.runs.facts import engine_facts, external_versions, scene_words
from barchain.runs.kept_answers import AnswerStore
from barchain.runs.timing.bench import LONG_S, TimingBench
from barchain.runs.timing.estimate import need_runnable
from barchain.runs.timing.left_out import failures
from barchain.runs.timing.load import OtherLoad
from barchain.runs.timing.statistics import interval, median_time
from barchain.studies.cost.errors import ORDER, errors_at_equal_steps, errors_of, under_floor
from barchain.studies.cost.findings import equal_steps_row, front_of, orders_table, price_table, reach_table
from barchain.studies.cost.plan import (
    REPEATED_LOAD,
    SHORTENED,
    CostPlan,
    kind_of,
    load_jobs,
    name_of,
    shortened,
    sweeps,
    too_fine,
    too_long,
)
from barchain.studies.study import StudyEnd
from reports.tables.cost import FILES
from reports.tables.outcome import Outcome
from reports.tables.rows import NOT_RUN
from scenarios import Scene, load_scene, scene_names

if TYPE_CHECKING:
    from collections.abc import Callable

    import pandas as pd

    from adapters.trajectory import Array
    from barchain.record.study_store import StudyStore
    from barchain.runs.job import Job, RunResult
    from barchain.studies.cost.errors import BoundedSolution
    from barchain.studies.cost.plan import CostOptions, PointName, Row
    from barchain.studies.study import Reporter
    from reports.tables.files import StudyFiles

DEFAULT_SCENES = "paper/"
FEWEST_TURNS = 3  # even where time is short: a median with its range
FEWEST_LONG_TURNS, LONG_TURNS = 1, 3  # of runs over LONG_S, the first pass counted
BRIEF_S = 0.03  # runs that take no longer get all their turns, even when time is short
FIRST_SHARE = 0.5  # of a scene's time: then the first pass skips long runs, or the rounds would have none left
CHECK_SHARE = 0.25  # a prediction is trusted to this much over the limit before the run itself is ended
LOAD_TURNS = range(1000, 1007)
"""Turns of a run whose loads are timed, numbered apart from its turns in rounds"""


@dataclass(frozen=True)
class CostStudy:
    """The cost study."""

    solution_of: Callable[[Scene], BoundedSolution] | None = None
    """Reference solution of a scene; the certified solution by default"""
    files: ClassVar[StudyFiles] = FILES

    def plan(self, options: CostOptions) -> CostPlan:
        """Scenes cut to their first orbits, engines and limits.

        Raises
        ------
        SceneError, UnknownEngineError
            For a scene or an engine that does not exist.
        CertifiedSolutionError
            For a scene whose certified solution can't be had here.
        """
        paper = (name for name in scene_names() if name.startswith(DEFAULT_SCENES))
        named = paper if options.scenes is None else options.scenes
        loaded = unique_names([s if isinstance(s, Scene) else load_scene(s) for s in named])
        chosen = engines() if options.engines is None else chosen_engines(options.engines)
        scenes = [shortened(s, options.orbits) for s in loaded]
        need_runnable(scenes, options.time_limit_s)
        if self.solution_of is None:
            from barchain.solutions.certified import need_certifiable  # noqa: PLC0415  # heyoka is an extra

            for scene in scenes:
                need_certifiable(scene)
        asked_for = frozenset(() if options.engines is None else chosen)
        return CostPlan(scenes, chosen, options.repeats, options.minutes, options.time_limit_s, asked_for)

    def record(self, plan: CostPlan) -> dict[str, Any]:
        """Engines, scenes and limits."""
        return {
            "packages": external_versions(plan.engines),
            "engines": {name: engine_facts(r) | {"kind": kind_of(r)} for name, r in plan.engines.items()},
            "scenes": {s.name: scene_words(s) for s in plan.scenes},
            "certified_solutions": {},
            "left_out": [],
            "shortened_limits_s": {},
            "limits": {name: getattr(plan, name) for name in ("repeats", "minutes", "time_limit_s")},
        }

    def run(self, plan: CostPlan, store: StudyStore, reporter: Reporter) -> StudyEnd:
        """Measure every point, round after round."""
        solution_of = self.solution_of
        if solution_of is None:
            from barchain.solutions.certified import certified  # noqa: PLC0415  # heyoka is an extra

            solution_of = certified
        return CostRun(plan, store, solution_of, reporter).run()


class CostRun:
    """One run of the study over many scenes and engines."""

    def __init__(
        self, plan: CostPlan, store: StudyStore, solution_of: Callable[[Scene], BoundedSolution], reporter: Reporter
    ) -> None:
        """Prepare; `reporter` gets scene, engine and setting, and outcome after each first run."""
        self.plan, self.store, self.solution_of = plan, store, solution_of
        self.report, self.note = reporter.step, reporter.note
        self.rows: dict[PointName, Row] = {}
        self.times: dict[PointName, list[float]] = {}
        """Measured times of `simulate` of each point, s"""
        self.haste_at = math.inf
        self.equal_steps: list[Row] = []
        self.loads: list[Row] = []

    def run(self) -> StudyEnd:
        """Measure everything and write the tables; an interrupted run leaves the points measured so far."""
        start, load = time.perf_counter(), OtherLoad()
        left_out: list[Row] = self.store.record["left_out"]
        try:
            with TimingBench(AnswerStore(self.store.folder)) as bench:
                able = [set(sweeps(scene, self.plan.engines)[0]) for scene in self.plan.scenes]
                bench.start(name for name in self.plan.engines if any(name in runs for runs in able))
                for k, scene in enumerate(self.plan.scenes):
                    left_s = 60.0 * self.plan.minutes - (time.perf_counter() - start)
                    self.scene(bench, scene, time.perf_counter() + left_s / (len(self.plan.scenes) - k))
                    self.store.record["other_processors"] = load.processors()
        finally:
            self.write_tables()
        ran = {engine for _, engine, _ in self.rows}
        idle = {out["engine"]: out["reason"] for out in left_out if out["engine"] not in ran}
        return StudyEnd(failures((*self.rows.values(), *left_out), self.plan.named), idle)

    def scene(self, bench: TimingBench, scene: Scene, deadline: float) -> None:
        """First pass and rounds on one scene."""
        runs, left_out = sweeps(scene, self.plan.engines)
        for out in left_out:
            self.store.record["left_out"].append(dataclasses.asdict(out))
            self.report(out.scene, out.engine, str(out.outcome))
        solution = self.solution_of(scene)
        error = {name: float(np.max(values)) for name, values in solution.error.items()}
        words = {name: str(getattr(solution, name, "")) for name in ("precision", "source")}
        self.store.record["certified_solutions"][scene.name] = words | {"error": error}
        self.haste_at = time.perf_counter() + FIRST_SHARE * (deadline - time.perf_counter())
        self.first_pass(bench, solution, runs)
        self.rounds(bench, [job for level in by_setting(runs) for job in level], deadline)
        for job in load_jobs(runs.values(), self.rows):
            self.loads += load_rows(bench, job, 10.0 * self.plan.time_limit_s)
        self.equal_steps.append(equal_steps_row(scene.name, *errors_at_equal_steps(solution), ORDER))
        self.store.write("points", self.points())

    def first_pass(self, bench: TimingBench, solution: BoundedSolution, runs: dict[str, list[Job]]) -> None:
        """One turn of every point, setting by setting over the engines; settings past the time limit are not run.

        A setting has one limit for all engines, whatever their order.
        """
        for level in by_setting(runs):
            limit_s = self.limit_s(solution.scene)
            for job in level:
                self.first_turn(bench, solution, job, runs[job.engine], limit_s)
            self.store.write("points", self.points())

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
        """Errors of a point, and a first idea of its time; long runs are timed from here on."""
        coarser = [(c, self.rows[name_of(c)]) for c in sweep[: sweep.index(job)]]
        why = f", as {SHORTENED}" if limit_s < self.plan.time_limit_s else ""
        reason = too_long(coarser, job, limit_s, why) or too_fine([row for _, row in coarser])
        if reason:
            found: Row = {"outcome": str(Outcome.NOTHING_COMPARED), "reason": f"{NOT_RUN}: {reason}"}
        else:
            result = bench.run(job, (1.0 + CHECK_SHARE) * 2.0 * self.plan.time_limit_s)
            found = columns_of(job, result, solution)
            if result.outcome is Outcome.PASS and result.seconds["simulate"] >= LONG_S:
                self.times[name_of(job)] = [result.seconds["simulate"]]
        named = dict(zip(("scene", "engine", "setting"), name_of(job), strict=True))
        named |= {"kind": kind_of(job.registration), "parameter": str(job.setting.parameter)}
        self.rows[name_of(job)] = named | {"value": job.setting.value} | found
        self.report(job.scene.name, f"{job.engine} {job.setting}", found["outcome"])

    def rounds(self, bench: TimingBench, jobs: list[Job], deadline: float) -> None:
        """Time all good points in turn, again and again, until each is measured often enough or time is up.

        A point that can't be repeated even once is a failure.
        """
        good = [j for j in jobs if self.rows[name_of(j)]["outcome"] == Outcome.PASS.value]
        for turn in range(self.plan.repeats):
            for job in (j for j in good if self.wanted(j, turn, late=time.perf_counter() > deadline)):
                result = bench.run(job, 10.0 * self.plan.time_limit_s, turn + 1)
                times = self.times.get(name_of(job), [])
                if result.outcome is Outcome.PASS:
                    self.times[name_of(job)] = [*times, result.seconds["simulate"]]
                elif not times:
                    self.rows[name_of(job)] |= {"outcome": str(result.outcome), "reason": result.reason}
            if jobs:
                self.report(jobs[0].scene.name, f"round {turn + 1} of {self.plan.repeats}", str(Outcome.PASS))

    def wanted(self, job: Job, turn: int, *, late: bool) -> bool:
        """Whether a point lacks its time of this round; late, only the least number of times counts."""
        have = len(self.times.get(name_of(job), []))
        seconds = self.rows[name_of(job)]["seconds"]
        enough = (FEWEST_LONG_TURNS, LONG_TURNS) if seconds >= LONG_S else (FEWEST_TURNS, self.plan.repeats)
        late = late and seconds > BRIEF_S
        return have <= turn and have < min(enough[0 if late else 1], self.plan.repeats)

    def points(self) -> pd.DataFrame:
        """All points so far, in the order in which they were run, with medians and intervals of their times."""
        for name, found in self.times.items():
            spread = median_time(np.array(found))
            low, high = (spread.low, spread.high) if len(found) > 1 else (np.nan, np.nan)
            timed = {"seconds": spread.value, "seconds_low": low, "seconds_high": high, "turns": len(found)}
            self.rows[name] |= timed
        points = self.store.frame("points", self.rows.values())
        points["on_front"] = front_of(points)
        return points

    def write_tables(self) -> None:
        """Write all tables as they stand."""
        points = self.points()
        times = {name: np.array(self.times.get(name, [])) for name in self.rows}
        self.store.write("points", points)
        self.store.write("times", (
            {"scene": scene, "engine": engine, "setting": setting, "turn": turn, "seconds": seconds}
            for (scene, engine, setting), own in times.items()
            for turn, seconds in enumerate(own)
        ))  # fmt: skip
        self.store.write("orders", orders_table(points, self.plan.engines, self.equal_steps))
        self.store.write("reach", reach_table(points, times))
        self.store.write("price", price_table(points))
        self.store.write("loads", self.loads)


def by_setting(runs: dict[str, list[Job]]) -> list[list[Job]]:
    """Runs of all engines, one setting of their sweeps after the other: neighbours belong to different engines."""
    return [[job for job in level if job] for level in itertools.zip_longest(*runs.values())]


def columns_of(job: Job, result: RunResult, solution: BoundedSolution) -> Row:
    """Columns of points.csv that a first run gives; errors of failed runs too, where they have a whole trajectory."""
    found: Row = {"outcome": str(result.outcome), "reason": result.reason}
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


def load_rows(bench: TimingBench, job: Job, time_limit_s: float) -> list[Row]:
    """Row on the share of the loads in a run's time, from runs with loads applied once and twice, in turn.

    No row if a run fails.
    """
    pair = job, dataclasses.replace(job, options=(REPEATED_LOAD,))
    results = [[bench.run(each, time_limit_s, turn) for each in pair] for turn in LOAD_TURNS]
    if any(result.outcome is not Outcome.PASS for turn in results for result in turn):
        return []
    once_s, twice_s = np.array([[result.seconds["simulate"] for result in turn] for turn in results]).T
    return [load_row(job, once_s, twice_s)]


def load_row(job: Job, once_s: Array, twice_s: Array) -> Row:
    """Row of loads.csv of an engine's times with its loads applied once and twice, (n,) s."""
    once, twice = float(np.median(once_s)), float(np.median(twice_s))
    ratio = interval(twice / once, [(1.0, twice_s), (-1.0, once_s)])
    return {
        "scene": job.scene.name,
        "engine": job.engine,
        "setting": str(job.setting),
        "kind": kind_of(job.registration),
        "seconds": once,
        "seconds_twice": twice,
        "share": ratio.value - 1.0,
        "share_low": ratio.low - 1.0,
        "share_high": ratio.high - 1.0,
    }
