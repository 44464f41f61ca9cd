"""The cost study itself: small real ones with certified solutions; errors and counts are asserted, never times."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from adapters.engine import AccuracyParameter, AccuracySweep, Setting
from adapters.registry import ENGINES
from barchain.record.study_store import StudyStore
from barchain.runs.cases import Known, run_cases
from barchain.runs.executors import ALL_CORES
from barchain.runs.job import RunResult
from barchain.runs.pool import OneByOneSession
from barchain.solutions.certified import certified
from barchain.studies.cost.errors import errors_at_equal_steps, errors_of, under_floor
from barchain.studies.cost.findings import orders_table, stopped
from barchain.studies.cost.plan import load_jobs, name_of, shortened, sweeps, too_fine, too_long
from barchain.studies.cost.study import CostRun, by_setting, columns_of, cost_study, load_row, load_rows
from barchain.studies.study import Reporter, run_study
from barchain.studies.timing.statistics import fit_order
from reports.render import render_study
from reports.results.cost import FILES, TABLES, read_cost
from reports.results.outcome import Outcome
from reports.results.rows import NOT_RUN, NotRun
from scenarios import load_scene
from tests.support.certified_stand_in import certified_stand_in
from tests.support.results import read_table

SCENE = "paper/fig09"
LIMIT_S = 2.0


@pytest.fixture(scope="module")
def solution():
    return certified(shortened(load_scene(SCENE)))


def measured(solution, engine, values):
    """Points of an engine at some values of its accuracy parameter, run in this process."""
    rows = []
    for job in sweep_of(engine, values, solution.scene):
        seen = ENGINES[engine].load()().run(solution.scene, job.setting)
        row = columns_of(job, RunResult(Outcome.PASS, "", seen, {}), solution)
        named = {"scene": solution.scene.name, "engine": engine, "setting": str(job.setting)}
        rows.append(named | {"parameter": str(job.setting.parameter)} | row)
    return TABLES["points"].framed(rows)


def sweep_of(engine, values, scene=None):
    """Jobs of an accuracy sweep, by default on the first orbit of a scene of the paper."""
    jobs, _ = sweeps(scene or shortened(load_scene(SCENE)), {engine: ENGINES[engine]})
    parameter = jobs[engine][0].setting.parameter
    return [dataclasses.replace(jobs[engine][0], setting=Setting(parameter, v)) for v in values]


def test_dop853_is_of_order_eight_at_equal_steps():
    fit = fit_order(*errors_at_equal_steps(certified(shortened(load_scene("paper/fig05")))))
    assert fit.order.value == pytest.approx(8.0, abs=0.5)
    assert fit.points >= 4


def test_the_reference_pays_for_accuracy_in_evaluations_as_order_eight_does(solution):
    points = measured(solution, "reference", (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)).set_index("setting")
    assert (np.diff(points.attitude_error_rad) < 0).all()
    assert points.evaluations["rtol=1e-10"] < 1000  # 62 steps of 15 and the start: 960
    growth = points.evaluations["rtol=1e-12"] / points.evaluations["rtol=1e-08"]
    assert 1.0 < growth <= 10 ** (4 / 8)  # four digits, at order 8 or better


def test_rebounds_floor_is_that_of_the_particles_track():
    scene = certified(shortened(load_scene("basics/kepler_elliptic")))
    points = measured(scene, "rebound", (1e-8, 1e-10, 1e-12))
    found = orders_table(points, ENGINES, []).iloc[0]
    assert found.quantity == "com"
    assert found.least_error < 1e-6  # m: some rounded steps of the radius' own 1e-9 m
    assert math.isnan(found.order)


def study_of(engines, repeats=2, minutes=10.0):
    """Study of a tenth of an orbit; in ten minutes nothing is ever late."""
    made = cost_study(
        [SCENE], ["reference"], orbits=0.1, repeats=repeats, minutes=minutes, time_limit_s=LIMIT_S,
        solution_of=certified_stand_in,
    )  # fmt: skip
    return dataclasses.replace(made, engines=engines)


@pytest.fixture(scope="module")
def engines():
    """The reference with a short accuracy sweep."""
    with pytest.MonkeyPatch.context() as patch:
        few = AccuracySweep(AccuracyParameter.RTOL, (1e-4, 1e-6, 1e-8), default=1e-4)
        patch.setattr(ENGINES["reference"].load(), "sweep", few)
        yield {"reference": ENGINES["reference"]}


@pytest.mark.parametrize(
    ("seconds", "late", "turns"), [(1e-4, True, 3), (1e-4, False, 7), (0.1, False, 7), (1.0, False, 3), (1.0, True, 1)]
)
def test_after_the_budget_a_run_is_repeated_only_as_often_as_a_median_needs(engines, tmp_path, seconds, late, turns):
    study = study_of(engines, repeats=7)
    cost_run = CostRun(study, StudyStore(FILES, tmp_path), Reporter())
    job = next(iter(sweeps(study.scenes[0], study.engines)[0].values()))[0]
    cost_run.rows[name_of(job)] = {"seconds": seconds}
    for turn in range(study.repeats):
        if cost_run.wanted(job, turn, late=late):
            cost_run.times.setdefault(name_of(job), []).append(seconds)
    assert len(cost_run.times.get(name_of(job), [])) == turns


@pytest.mark.slow
def test_every_good_point_is_timed_as_often_as_the_others_and_the_record_says_what_ran_where(engines, tmp_path):
    run_study(study_of(engines), tmp_path, command="barchain cost")
    found = read_cost(tmp_path)
    points, record = found.points, found.record
    times = read_table(tmp_path, "cost", "times")
    assert len(points) == 3
    assert (points.turns == 2).all()
    assert times.groupby("setting").size().to_dict() == dict.fromkeys(points.setting, 2)
    assert points[["seconds", "build_s", "read_s"]].notna().all().all()
    assert ((points.seconds_low <= points.seconds) & (points.seconds <= points.seconds_high)).all()
    assert record["finished"]
    assert record["certified_solutions"][SCENE]["source"] == "stand-in"
    assert record["limits"] == {"repeats": 2, "minutes": 10.0, "time_limit_s": LIMIT_S}


@pytest.fixture
def made(monkeypatch):
    """Calls that are made, and not taken from kept answers."""
    found, start = [], OneByOneSession.start
    monkeypatch.setattr(OneByOneSession, "start", lambda self, key, call: (found.append(call), start(self, key, call)))
    return found


def cut_off(study, out, after):
    """Run a study, and interrupt it after some steps."""
    ran = []

    def cut(scene, what, outcome):
        ran.append(what)
        if len(ran) == after:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_study(study, out, reporter=Reporter(cut))


@pytest.mark.slow
def test_a_study_that_was_cut_off_measures_only_what_is_missing(tmp_path, engines, made):
    study, noted = study_of(engines), []
    cut_off(study, tmp_path, after=2)
    assert not read_cost(tmp_path).record["finished"]
    assert "cut off" in render_study("cost", tmp_path)[0].read_text()
    assert set(read_cost(tmp_path).orders.outcome) == {NOT_RUN}
    kept = read_cost(tmp_path).points.set_index("setting")
    assert len(kept) == 2
    made.clear()
    run_study(study, tmp_path, resume=True, reporter=Reporter(note=noted.append))
    first = [str(call.given[0].setting) for call in made if not call.repetition]
    assert first == ["rtol=1e-08"]
    assert len(made) == 1 + 3 * study.repeats
    assert noted == [f"kept 2 of {2 + len(made)} answers"]
    assert set(read_cost(tmp_path).orders.outcome) == {""}
    points = read_cost(tmp_path).points.set_index("setting")
    assert (points.outcome == "pass").all()
    columns = ["attitude_error_rad", "evaluations", "build_s"]
    pd.testing.assert_frame_equal(points.loc[kept.index, columns], kept[columns])
    made.clear()
    run_study(study, tmp_path, resume=True)
    assert made == []
    pd.testing.assert_frame_equal(read_cost(tmp_path).points.set_index("setting"), points)


@pytest.mark.exhaustive
def test_a_study_that_goes_on_makes_the_runs_that_its_budget_allowed_when_it_began(
    tmp_path, engines, made, monkeypatch
):
    """Each run takes 3 s by the clock of the workers."""
    answer = OneByOneSession.start

    def slow(session, key, call):
        answer(session, key, call)
        key, found = session.done.get()
        session.done.put((key, dataclasses.replace(found, seconds=3.0)))

    monkeypatch.setattr(OneByOneSession, "start", slow)
    study = study_of(engines, repeats=5, minutes=20.0 / 60.0)
    run_study(study, tmp_path / "whole")
    whole = [(str(call.given[0].setting), call.repetition) for call in made]
    made.clear()
    cut_off(study, tmp_path / "cut", after=3)
    run_study(study, tmp_path / "cut", resume=True)
    assert [(str(call.given[0].setting), call.repetition) for call in made] == whole
    assert len(whole) < 3 + 3 * 5, "the budget left turns out"


def test_settings_past_the_time_limit_are_not_tried():
    coarse, fine, finer = sweep_of("exudyn", (1000, 2000, 4000))
    rows = [(coarse, {"outcome": "pass", "seconds": 0.9})]
    assert too_long(rows, fine, LIMIT_S) is None
    assert too_long(rows, finer, LIMIT_S)["outcome"] == NotRun.LIMIT
    assert too_long(rows, finer, LIMIT_S, hasty=True)["outcome"] == NotRun.BUDGET
    for outcome, after in [("timed_out", NotRun.LIMIT), (NotRun.LIMIT, NotRun.LIMIT), (NotRun.BUDGET, NotRun.BUDGET)]:
        assert too_long([(coarse, {"outcome": outcome})], fine, LIMIT_S)["outcome"] == after
    assert too_long([(coarse, {"outcome": "failed"})], fine, LIMIT_S) is None


class Bench:
    """Every run takes a known time on a clock of the test, with starting and reading in `each_s`."""

    def __init__(self, seconds_of, each_s=None):
        self.spent_s, self.seconds_of, self.each_s, self.ran = 0.0, seconds_of, each_s, []

    def run(self, job, time_limit_s, turn=0):
        self.ran.append(job)
        seconds = self.seconds_of(job)
        self.spent_s += self.each_s or seconds
        return Known(RunResult(Outcome.PASS, seconds={"build": 0.0, "simulate": seconds, "read": 0.0}))


def begun(study, folder, bench, **reporter):
    """Run of a study on a bench, and its accuracy sweep."""
    run = CostRun(study, StudyStore(FILES, folder, study.record()), Reporter(**reporter))
    run.bench = bench
    return run, sweeps(study.scenes[0], study.engines)[0]


def first_pass(run, sweep, until_s):
    """Make the first pass of a run."""
    case = run.first_pass(SimpleNamespace(scene=run.study.scenes[0]), sweep, until_s)
    list(run_cases([("", case)], ALL_CORES))


@pytest.mark.parametrize("haste_s", [0.35, 1.0])
def test_the_order_of_engines_does_not_decide_what_is_measured(haste_s, tmp_path):
    measured = []
    for order in (("exudyn", "pymunk"), ("pymunk", "exudyn")):
        study, noted = cost_study([SCENE], order, orbits=0.1, repeats=1, time_limit_s=5.0), []
        bench = Bench(lambda job: (3e-4 if job.engine == "exudyn" else 2e-5) * job.setting.value)
        run, sweep = begun(study, tmp_path / order[0], bench, note=noted.append)
        run.haste_at = haste_s
        first_pass(run, sweep, 1e9)
        found = {(r["engine"], r["setting"]) for r in run.rows.values() if r["outcome"] == "pass"}
        hasty = [r["reason"] for r in run.rows.values() if "half used" in r["reason"]]
        assert len(noted) == len(run.store.record["shortened_limits_s"]) >= bool(hasty), "each limit is told once"
        measured.append(found)
    assert measured[0] == measured[1]
    assert {engine for engine, _ in measured[0]} == {"exudyn", "pymunk"}


def test_after_the_budget_no_setting_but_the_coarsest_is_begun(tmp_path):
    study = cost_study([SCENE], ["exudyn", "pymunk"], orbits=0.1, repeats=1)
    run, sweep = begun(study, tmp_path, Bench(lambda _: 1e-3, each_s=1.0))
    first_pass(run, sweep, 3.5)
    assert [r["outcome"] for r in run.rows.values()].count("pass") == 4
    assert {r["outcome"] for r in run.rows.values()} == {"pass", NotRun.BUDGET}
    assert stopped(pd.DataFrame(r for r in run.rows.values() if r["engine"] == "exudyn")) == "not run: budget"


def test_the_first_pass_leaves_time_for_the_fewest_rounds_and_rounds_that_were_not_run_say_so(tmp_path):
    """Each run takes 1 s: what the first pass measures can be measured three more times in the 60 s."""
    said = []
    study = cost_study([SCENE], ["reference", "scipy-dop853"], orbits=0.1, repeats=7)
    run, sweep = begun(study, tmp_path, Bench(lambda _: 1e-3, each_s=1.0), step=lambda *told: said.append(told))
    first_pass(run, sweep, 60.0)
    list(run_cases([("", run.rounds([job for level in by_setting(sweep) for job in level], 60.0))], ALL_CORES))
    assert 50.0 <= run.bench.spent_s <= 70.0
    ends = [told[-1] for told in said if told[1].startswith("round")]
    assert len(ends) == 7
    assert ends[-1] == "not run: the time budget is used"
    assert not any(end == "pass" for end in ends)


def test_settings_finer_than_the_oracle_can_tell_are_not_tried():
    told = {"outcome": "pass", "attitude_error_rad": 1e-9, "com_error_m": 1e-3, "under_floor": "com"}
    blurred = told | {"under_floor": "attitude,com"}
    assert too_fine([told, blurred]) is None
    assert too_fine([blurred, told]) is None
    left = too_fine([blurred, blurred])
    assert left["outcome"] == NotRun.BLURRED
    assert too_fine([blurred, left]) == left
    assert too_fine([{"outcome": "failed"}, {"outcome": "failed"}]) is None


def test_runs_that_succeed_but_are_wrong_are_points_with_large_errors(solution):
    seen = ENGINES["reference"].load()().run(solution.scene)
    wrong = errors_of(solution, seen.replace(reaction_N=-seen.reaction_N))
    assert wrong["reaction_relative"] == pytest.approx(2.0, abs=1e-4)
    assert under_floor(wrong) == ""


def test_the_loads_of_an_engine_with_the_option_are_timed_at_its_finest_brief_setting():
    seconds_of = {
        "exudyn": {100: 0.01, 500: 0.05, 1000: 0.2}, "reference": {1e-4: 0.01, 1e-6: 0.01},
        "exudyn-tree": {50: 0.3, 100: 0.6},
    }  # fmt: skip
    jobs = [sweep_of(engine, tuple(seconds)) for engine, seconds in seconds_of.items()]
    points = {
        name_of(job): {"outcome": "pass", "seconds": seconds_of[job.engine][job.setting.value]}
        for own in jobs
        for job in own
    }
    assert [(j.engine, j.setting.value) for j in load_jobs(jobs, points)] == [("exudyn", 500), ("exudyn-tree", 50)]
    assert load_jobs(jobs, {key: {"outcome": "failed", "seconds": np.nan} for key in points}) == []


def test_the_share_of_the_loads_is_the_time_that_they_add_when_applied_once_more():
    job = sweep_of("exudyn", (100,))[0]
    spread = np.array([0.98, 0.99, 1.0, 1.0, 1.0, 1.01, 1.02])
    row = load_row(job, 0.010 * spread, 0.014 * spread)
    assert row["share"] == pytest.approx(0.4)
    assert 0.35 < row["share_low"] < 0.4 < row["share_high"] < 0.45  # 2 % in each of the two medians
    bench = Bench(lambda asked: 2.0 if asked.options else 1.0)
    [(_, [found])] = run_cases([("", load_rows(bench, job, LIMIT_S))], ALL_CORES)
    assert [asked.options for asked in bench.ran] == [(), ("repeated_load",)] * 7
    assert found["share"] == 1.0
