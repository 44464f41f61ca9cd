"""The cost study: errors against the certified solution and times, for every setting of every engine.

A first pass over all settings gives the errors, then rounds over all good points the times. Runs are made one by one.
Which of them are made follows from the results so far, times among them, so that a study that goes on makes the same.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from adapters.common.equal_steps import step_s
from adapters.engine import AccuracyParameter
from adapters.registry import engines
from barchain.record.environment import external_versions
from barchain.record.scene_description import scene_words
from barchain.runs.cases import run_cases
from barchain.runs.choices import chosen_engines, engine_facts, unique_names
from barchain.runs.estimate import need_runnable
from barchain.runs.executors import ONE_BY_ONE
from barchain.runs.left_out import failures, said
from barchain.studies.cost.errors import ORDER, errors_at_equal_steps, errors_of, under_floor
from barchain.studies.cost.findings import (
    equal_steps_row,
    front_of,
    orders_table,
    price_table,
    reach_table,
    unknown_orders,
)
from barchain.studies.cost.plan import (
    REPEATED_LOAD,
    SHORTENED,
    kind_of,
    load_jobs,
    name_of,
    shortened,
    sweeps,
    too_fine,
    too_long,
)
from barchain.studies.defaults import COST
from barchain.studies.study import StudyEnd
from barchain.studies.timing.bench import LONG_S, OtherLoad, TimingBench
from barchain.studies.timing.statistics import interval, median_time
from reports.results.cost import FILES, TABLES
from reports.results.outcome import Outcome
from reports.results.rows import NotRun
from scenarios import Scene, load_scene, scene_names

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from pathlib import Path

    import pandas as pd

    from adapters.registry import Registration
    from adapters.trajectory import Array
    from barchain.record.study_store import StudyStore
    from barchain.runs.cases import Case
    from barchain.runs.executors import Executor
    from barchain.runs.job import Job, RunResult
    from barchain.studies.cost.errors import BoundedSolution
    from barchain.studies.cost.plan import PointName
    from barchain.studies.study import Reporter
    from reports.results.files import StudyFiles
    from reports.results.rows import Row

DEFAULT_SCENES = "paper/"
FEWEST_TURNS = 3  # even after the budget: a median with its range, which nights need
FEWEST_LONG_TURNS, LONG_TURNS = 1, 3  # of runs over LONG_S, the first pass counted
FIRST_SHARE = 0.5  # of a scene's time: then the first pass skips long runs, or the rounds would have none left
CHECK_SHARE = 0.25  # a prediction is trusted to this much over the limit before the run itself is ended
LOAD_TURNS = range(1000, 1007)
"""Turns of a run whose loads are timed, numbered apart from its turns in rounds"""


@dataclass(frozen=True)
class CostStudy:
    """Scenes, engines and limits of time."""

    scenes: list[Scene]
    engines: dict[str, Registration]
    repeats: int = COST.repeats
    """Times that each point is measured, if the budget allows"""
    minutes: float = COST.minutes
    """Budget, divided among the scenes; where it runs short, first long runs, then repeats and finer
    settings are given up"""
    time_limit_s: float = COST.time_limit_s
    """Runs that are expected to take longer are skipped, with the reason in the table"""
    named: frozenset[str] = frozenset()
    """Engines that were asked for by name"""
    solution_of: Callable[[Scene], BoundedSolution] | None = None
    """Solution that errors are taken from; the certified one by default"""
    executor: Executor = ONE_BY_ONE
    files: ClassVar[StudyFiles] = FILES

    @property
    def turns(self) -> int:
        """Number of first runs and rounds to be reported, engines left out among them."""
        found = [sweeps(s, self.engines) for s in self.scenes]
        return sum(sum(map(len, runs.values())) + len(out) + self.repeats for runs, out in found)

    def record(self) -> dict[str, Any]:
        """Engines, scenes and limits."""
        return {
            "packages": external_versions(self.engines),
            "engines": {name: engine_facts(r) | {"kind": kind_of(r)} for name, r in self.engines.items()},
            "scenes": {s.name: scene_words(s) for s in self.scenes},
            "certified_solutions": {},
            "left_out": [],
            "shortened_limits_s": {},
            "limits": {name: getattr(self, name) for name in ("repeats", "minutes", "time_limit_s")},
        }

    def run(self, store: StudyStore, reporter: Reporter) -> StudyEnd:
        """Measure every point, round after round; an interrupted run leaves the points measured so far."""
        run, load, complete = CostRun(self, store, reporter), OtherLoad(), False
        try:
            for _ in run_cases([(self.files.study, run.scenes())], self.executor):
                pass
            complete = True
        finally:
            store.record["other_processors"] = load.processors()
            run.write_tables(complete=complete)
        left_out, ran = store.record["left_out"], {engine for _, engine, _ in run.rows}
        idle = {out["engine"]: out["reason"] for out in left_out if out["engine"] not in ran}
        ends = (*run.rows.values(), *left_out)
        return StudyEnd(failures(ends, self.named), idle, tuple(str(end["outcome"]) for end in ends))


def cost_study(
    scenes: Iterable[Scene | str | Path] | None = None,
    engine_names: Iterable[str] | None = None,
    orbits: float = 1.0,
    **limits: Any,
) -> CostStudy:
    """Cost study of scenes over their first orbits; further arguments are fields of the study.

    By default the scenes are the paper's, and all registered engines take part, also those that only studies run.

    Raises
    ------
    SceneError, UnknownEngineError
        For a scene or an engine that does not exist.
    CertifiedSolutionError
        For a scene whose certified solution can't be had here.
    """
    paper = (name for name in scene_names() if name.startswith(DEFAULT_SCENES))
    loaded = [s if isinstance(s, Scene) else load_scene(s) for s in (paper if scenes is None else scenes)]
    chosen = engines() if engine_names is None else chosen_engines(engine_names)
    short = [shortened(s, orbits) for s in unique_names(loaded)]
    named = frozenset(() if engine_names is None else chosen)
    study = CostStudy(short, chosen, named=named, **limits)
    need_runnable(short, study.time_limit_s)
    if study.solution_of is None:
        from barchain.solutions.certified import need_certifiable  # noqa: PLC0415  # heyoka is an extra

        for scene in short:
            need_certifiable(scene)
    return study


class CostRun:
    """One run of the study over many scenes and engines."""

    def __init__(self, study: CostStudy, store: StudyStore, reporter: Reporter) -> None:
        """Prepare; `reporter` gets scene, engine and setting, and outcome after each first run."""
        self.study, self.store, self.report, self.note = study, store, reporter.step, reporter.note
        self.bench = TimingBench()
        self.rows: dict[PointName, Row] = {}
        self.times: dict[PointName, list[float]] = {}
        """Measured times of `simulate` of each point, s"""
        self.haste_at = math.inf
        self.round_s = 0.0
        """Time of a round over the good points of the scene so far, s"""
        self.equal_steps: list[Row] = []
        self.loads: list[Row] = []

    def scenes(self) -> Case[None]:
        """All scenes, one after the other; each has its share of the time that is left."""
        scenes = self.study.scenes
        for k, scene in enumerate(scenes):
            left_s = 60.0 * self.study.minutes - self.bench.spent_s
            yield from self.scene(scene, left_s / (len(scenes) - k))

    def scene(self, scene: Scene, share_s: float) -> Case[None]:
        """First pass and rounds on one scene, within a share of the time."""
        runs, left_out = sweeps(scene, self.study.engines)
        for out in left_out:
            self.store.record["left_out"].append(dataclasses.asdict(out))
            self.report(out.scene, out.engine, str(out.outcome))
        solution = self.solution(scene)
        error = {name: float(np.max(values)) for name, values in solution.error.items()}
        words = {name: str(getattr(solution, name, "")) for name in ("precision", "source")}
        self.store.record["certified_solutions"][scene.name] = words | {"error": error}
        deadline = self.bench.spent_s + share_s
        self.haste_at = self.bench.spent_s + FIRST_SHARE * share_s
        self.round_s = 0.0
        yield from self.first_pass(solution, runs, deadline)
        yield from self.rounds([job for level in by_setting(runs) for job in level], deadline)
        for job in load_jobs(runs.values(), self.rows) if self.bench.spent_s < deadline else ():
            self.loads += yield from load_rows(self.bench, job, 10.0 * self.study.time_limit_s)
        self.equal_steps.append(equal_steps_row(scene.name, *errors_at_equal_steps(solution), ORDER))
        self.store.write("points", self.points())

    def solution(self, scene: Scene) -> BoundedSolution:
        """Solution that errors are taken from."""
        if self.study.solution_of is not None:
            return self.study.solution_of(scene)
        from barchain.solutions.certified import certified  # noqa: PLC0415  # heyoka is an extra

        return certified(scene)

    def first_pass(self, solution: BoundedSolution, runs: dict[str, list[Job]], deadline: float) -> Case[None]:
        """One turn of every point, setting by setting over the engines; settings past the time limit are not run.

        A setting has one limit for all engines, whatever their order. The coarsest is run in any case; once the
        fewest rounds over what is measured need the rest of the scene's time, no further one is begun.
        """
        for k, level in enumerate(by_setting(runs)):
            rounds_s = FEWEST_TURNS * self.round_s
            limit_s, over = self.limit_s(solution.scene), bool(k) and self.bench.spent_s + rounds_s > deadline
            for job in level:
                yield from self.first_turn(solution, job, runs[job.engine], limit_s, over=over)
            self.store.write("points", self.points())

    def limit_s(self, scene: Scene) -> float:
        """Time allowed to one run; less, and told, once the first pass has had its share of the scene's time."""
        usual_s = self.study.time_limit_s
        if usual_s <= LONG_S or self.bench.spent_s <= self.haste_at:
            return usual_s
        shortened = self.store.record["shortened_limits_s"]
        if scene.name not in shortened:
            shortened[scene.name] = LONG_S
            self.note(
                f"{scene.name}: {SHORTENED}, so runs expected to take longer than {LONG_S:g} s are left out from here "
                f"on, instead of {usual_s:g} s; --minutes allows more"
            )
        return LONG_S

    def first_turn(
        self, solution: BoundedSolution, job: Job, sweep: list[Job], limit_s: float, *, over: bool = False
    ) -> Case[None]:
        """Errors of a point, and its first time; long runs are timed from here on.

        It is not begun if the scene's time is `over`.
        """
        coarser = [(c, self.rows[name_of(c)]) for c in sweep[: sweep.index(job)]]
        hasty = limit_s < self.study.time_limit_s
        spent: Row = {"outcome": str(NotRun.BUDGET), "reason": "the time budget is used"} if over else {}
        found = spent or too_long(coarser, job, limit_s, hasty=hasty) or too_fine([row for _, row in coarser])
        if found is None:
            before_s = self.bench.spent_s
            (result,) = yield [self.bench.run(job, (1.0 + CHECK_SHARE) * 2.0 * self.study.time_limit_s)]
            found = columns_of(job, result, solution)
            if result.outcome is Outcome.PASS:
                again_s = result.seconds["simulate"]
                if again_s >= LONG_S:
                    self.times[name_of(job)] = [again_s]
                elif coarser:  # the worker had started
                    again_s = self.bench.spent_s - before_s
                self.round_s += again_s
        named = dict(zip(("scene", "engine", "setting"), name_of(job), strict=True))
        named |= {"parameter": str(job.setting.parameter)}
        self.rows[name_of(job)] = named | {"value": job.setting.value} | found
        self.report(job.scene.name, f"{job.engine} {job.setting}", said(found))

    def rounds(self, jobs: list[Job], deadline: float) -> Case[None]:
        """Time all good points in turn, again and again, until each is measured often enough or time is up.

        A point that can't be repeated even once is a failure.
        """
        good = [j for j in jobs if self.rows[name_of(j)]["outcome"] == Outcome.PASS.value]
        for turn in range(self.study.repeats):
            over, made = self.bench.spent_s > deadline, 0
            for job in (j for j in good if self.wanted(j, turn, late=self.bench.spent_s > deadline)):
                made += 1
                (result,) = yield [self.bench.run(job, 10.0 * self.study.time_limit_s, turn + 1)]
                times = self.times.get(name_of(job), [])
                if result.outcome is Outcome.PASS:
                    self.times[name_of(job)] = [*times, result.seconds["simulate"]]
                elif not times:
                    self.rows[name_of(job)] |= {"outcome": str(result.outcome), "reason": result.reason}
            if jobs:
                ended = "the time budget is used" if over else "no time is missing"
                said_of = f"{made} times" if made else f"not run: {ended}"
                self.report(jobs[0].scene.name, f"round {turn + 1} of {self.study.repeats}", said_of)

    def wanted(self, job: Job, turn: int, *, late: bool) -> bool:
        """Whether a point lacks its time of this round; late, only the least number of times counts."""
        repeats, have = self.study.repeats, len(self.times.get(name_of(job), []))
        long = self.rows[name_of(job)]["seconds"] >= LONG_S
        enough = (FEWEST_LONG_TURNS, LONG_TURNS) if long else (FEWEST_TURNS, repeats)
        return have <= turn and have < min(enough[0 if late else 1], repeats)

    def points(self) -> pd.DataFrame:
        """All points so far, in the order in which they were run, with medians and intervals of their times."""
        for name, found in self.times.items():
            self.rows[name] |= median_time(np.array(found)).columns("seconds") | {"turns": len(found)}
        points = TABLES["points"].framed(self.rows.values())
        points["kind"] = points.engine.map({name: kind_of(r) for name, r in self.study.engines.items()})
        points["on_front"] = front_of(points)
        return points

    def write_tables(self, *, complete: bool) -> None:
        """Write all tables as they stand; of an interrupted study no order is known."""
        points = self.points()
        times = {name: np.array(self.times.get(name, [])) for name in self.rows}
        self.store.write("points", points)
        self.store.write("times", (
            {"scene": scene, "engine": engine, "setting": setting, "turn": turn, "seconds": seconds}
            for (scene, engine, setting), own in times.items()
            for turn, seconds in enumerate(own)
        ))  # fmt: skip
        orders = orders_table(points, self.study.engines, self.equal_steps)
        self.store.write("orders", orders if complete else unknown_orders(orders))
        self.store.write("reach", reach_table(points, times))
        self.store.write("price", price_table(points))
        self.store.write("loads", self.loads)


def by_setting(runs: dict[str, list[Job]]) -> list[list[Job]]:
    """Runs of all engines, one setting of their sweeps after the other: neighbours belong to different engines."""
    return [[job for job in level if job] for level in itertools.zip_longest(*runs.values())]


def columns_of(job: Job, result: RunResult, solution: BoundedSolution) -> Row:
    """Columns of `points` that a first run gives; errors of failed runs too, where they have a whole trajectory."""
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


def load_rows(bench: TimingBench, job: Job, time_limit_s: float) -> Case[list[Row]]:
    """Row on the share of the loads in a run's time, from runs with loads applied once and twice, in turn.

    No row if a run fails.
    """
    pair, seconds = (job, dataclasses.replace(job, options=(REPEATED_LOAD,))), []
    for turn in LOAD_TURNS:
        for each in pair:
            (result,) = yield [bench.run(each, time_limit_s, turn)]
            if result.outcome is not Outcome.PASS:
                return []
            seconds.append(result.seconds["simulate"])
    return [load_row(job, np.array(seconds[::2]), np.array(seconds[1::2]))]


def load_row(job: Job, once_s: Array, twice_s: Array) -> Row:
    """Row of the table `loads` of an engine's times with its loads applied once and twice, (n,) s."""
    once, twice = float(np.median(once_s)), float(np.median(twice_s))
    ratio = interval(twice / once, [(1.0, twice_s), (-1.0, once_s)])
    return {
        "scene": job.scene.name,
        "engine": job.engine,
        "setting": str(job.setting),
        "seconds": once,
        "seconds_twice": twice,
        "share": ratio.value - 1.0,
        "share_low": ratio.low - 1.0,
        "share_high": ratio.high - 1.0,
    }
