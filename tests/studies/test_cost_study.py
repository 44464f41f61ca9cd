"""The cost study itself: small real ones with certified solutions; errors and counts are asserted, never times."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from adapters.engine import AccuracyParameter, AccuracySweep, Setting
from adapters.registry import ENGINES, Registration
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
from tests.support.slow import one_in

SCENE = "paper/fig09"
LIMIT_S = 2.0


@pytest.fixture(scope="module")
def solution():
    return certified(shortened(load_scene(SCENE)))


def measured(solution, engine, values):
    """Points of an engine at some values of its accuracy parameter, run in this process."""
    registration = ENGINES[engine]
    sweep = dataclasses.replace(registration.load().sweep, values=values)
    rows = []
    jobs, _ = sweeps(solution.scene, {engine: registration})
    for value in values:
        job = dataclasses.replace(jobs[engine][0], setting=Setting(sweep.parameter, value))
        seen = registration.load()().run(solution.scene, job.setting)
        row = columns_of(job, RunResult(Outcome.PASS, "", seen, {}), solution)
        rows.append(
            {
                "scene": solution.scene.name,
                "engine": engine,
                "setting": str(job.setting),
                "parameter": str(sweep.parameter),
            }
            | row
        )
    return TABLES["points"].framed(rows)


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("engine", "values", "order", "within"),
    [
        ("exudyn", (800, 1600, 3200, 6400), 2.0, 0.1),
        ("exudyn-index3", (800, 1600, 3200, 6400), 2.0, 0.1),
        ("exudyn-tree", (40, 80, 120, 160), 6.0, 0.3),
        ("pymunk", (1000, 2000, 4000, 8000), 2.0, 0.1),
    ],
)
def test_methods_of_equal_steps_have_their_textbook_order(solution, engine, values, order, within):
    found = orders_table(measured(solution, engine, values), ENGINES, []).set_index("quantity").loc["attitude"]
    assert found.theory == order
    assert found.order == pytest.approx(order, abs=within)
    assert found.points >= 3


@pytest.mark.parametrize("scene", one_in(3, ["paper/fig05", "paper/fig09", "paper/fig13"]))
def test_dop853_is_of_order_eight_at_equal_steps(scene):
    fit = fit_order(*errors_at_equal_steps(certified(shortened(load_scene(scene)))))
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
    """The reference, and some that go wrong, each with a short accuracy sweep."""
    made = {
        name: Registration(f"tests.support.faulty_engines:{name}") for name in ("Segfault", "IgnoresJoints", "NotThere")
    }
    made["reference"] = ENGINES["reference"]
    with pytest.MonkeyPatch.context() as patch:
        for name in ("Segfault", "IgnoresJoints", "reference"):
            patch.setattr(
                made[name].load(), "sweep", AccuracySweep(AccuracyParameter.RTOL, (1e-4, 1e-6, 1e-8), default=1e-4)
            )
        yield made


@pytest.fixture(scope="module")
def study(engines, tmp_path_factory):
    """Folder of a study, and what was told of its progress."""
    folder, told = tmp_path_factory.mktemp("cost"), []
    made = study_of(engines, repeats=3)
    run_study(made, folder, reporter=Reporter(lambda *a: told.append(a)), command="barchain cost")
    assert len(told) == made.turns
    return folder


@pytest.fixture(scope="module")
def good(engines, tmp_path_factory):
    """Folder of a study of the reference alone."""
    folder = tmp_path_factory.mktemp("cost")
    run_study(study_of({"reference": engines["reference"]}), folder, command="barchain cost")
    return folder


@pytest.mark.exhaustive
def test_an_engine_that_fails_costs_its_own_points_only(study):
    tables = read_cost(study)
    by_engine = tables.points.groupby("engine").outcome.agg(set).to_dict()
    assert by_engine == {"reference": {"pass"}, "Segfault": {"failed"}, "IgnoresJoints": {"joints_ignored"}}
    assert tables.points[tables.points.engine == "IgnoresJoints"].seconds.notna().all()
    assert tables.points[tables.points.engine == "Segfault"].reason.str.contains("SIGSEGV").all()
    assert [o["engine"] for o in tables.record["left_out"]] == ["NotThere"]
    told = tables.reach.groupby("engine").reason.agg(set).to_dict()
    assert told["Segfault"] - {""} == {"failed"}
    assert told["IgnoresJoints"] - {""} == {"joints ignored"}
    page = render_study("cost", study).page.read_text()
    count = tables.points.engine.value_counts()
    failed = f"× failed: Segfault ({count['Segfault']}), IgnoresJoints ({count['IgnoresJoints']})"
    assert failed in page


@pytest.mark.slow
def test_every_good_point_is_timed_as_often_as_the_others_and_build_and_read_out_apart(good):
    points = read_cost(good).points
    times = read_table(good, "cost", "times")
    assert len(points) == 3
    assert (points.turns == 2).all()
    assert times.groupby("setting").size().to_dict() == dict.fromkeys(points.setting, 2)
    assert points[["seconds", "seconds_low", "seconds_high", "build_s", "read_s"]].notna().all().all()
    assert ((points.seconds_low <= points.seconds) & (points.seconds <= points.seconds_high)).all()


@pytest.mark.parametrize(
    ("seconds", "late", "turns"), [(1e-4, True, 3), (1e-4, False, 7), (0.1, False, 7), (1.0, False, 3), (1.0, True, 1)]
)
def test_after_the_budget_a_run_is_repeated_only_as_often_as_a_median_needs(engines, tmp_path, seconds, late, turns):
    study = study_of({"reference": engines["reference"]}, repeats=7)
    cost_run = CostRun(study, StudyStore(FILES, tmp_path), Reporter())
    job = next(iter(sweeps(study.scenes[0], study.engines)[0].values()))[0]
    cost_run.rows[name_of(job)] = {"seconds": seconds}
    for turn in range(study.repeats):
        if cost_run.wanted(job, turn, late=late):
            cost_run.times.setdefault(name_of(job), []).append(seconds)
    assert len(cost_run.times.get(name_of(job), [])) == turns


@pytest.mark.slow
def test_the_record_says_what_ran_where(good):
    record = read_cost(good).record
    assert record["finished"]
    assert record["command"] == "barchain cost"
    assert record["certified_solutions"][SCENE]["source"] == "stand-in"
    assert {"python", "cpu", "cores"} <= set(record["environment"])
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
    study, noted = study_of({"reference": engines["reference"]}), []
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
    study = study_of({"reference": engines["reference"]}, repeats=5, minutes=20.0 / 60.0)
    run_study(study, tmp_path / "whole")
    whole = [(str(call.given[0].setting), call.repetition) for call in made]
    made.clear()
    cut_off(study, tmp_path / "cut", after=3)
    run_study(study, tmp_path / "cut", resume=True)
    assert [(str(call.given[0].setting), call.repetition) for call in made] == whole
    assert len(whole) < 3 + 3 * 5, "the budget left turns out"


def sweep_of(engine, values):
    """Jobs of an accuracy sweep on the first orbit."""
    scene = shortened(load_scene(SCENE))
    jobs, _ = sweeps(scene, {engine: ENGINES[engine]})
    parameter = jobs[engine][0].setting.parameter
    return [dataclasses.replace(jobs[engine][0], setting=Setting(parameter, v)) for v in values]


def test_settings_past_the_time_limit_are_not_tried():
    coarse, fine, finer = sweep_of("exudyn", (1000, 2000, 4000))
    rows = [(coarse, {"outcome": "pass", "seconds": 0.9})]
    assert too_long(rows, fine, LIMIT_S) is None
    late = too_long(rows, finer, LIMIT_S)
    assert late["outcome"] == NotRun.LIMIT
    assert "about 3.6 s expected" in late["reason"]
    assert too_long(rows, finer, LIMIT_S, hasty=True)["outcome"] == NotRun.BUDGET
    for outcome, after in [("timed_out", NotRun.LIMIT), (NotRun.LIMIT, NotRun.LIMIT), (NotRun.BUDGET, NotRun.BUDGET)]:
        assert too_long([(coarse, {"outcome": outcome})], fine, LIMIT_S)["outcome"] == after
    assert too_long([(coarse, {"outcome": "failed"})], fine, LIMIT_S) is None


@pytest.mark.parametrize("haste_s", one_in(3, [0.35, 0.0, 0.05, 1.0, 3.0]))
def test_the_order_of_engines_does_not_decide_what_is_measured(haste_s, tmp_path):
    """Each setting costs its engine a known time on a clock of the test."""

    class Bench:
        spent_s = 0.0

        def run(self, job, time_limit_s):
            del time_limit_s
            seconds = (3e-4 if job.engine == "exudyn" else 2e-5) * job.setting.value
            self.spent_s += seconds
            return Known(RunResult(Outcome.PASS, seconds={"build": 0.0, "simulate": seconds, "read": 0.0}))

    measured = []
    for order in (("exudyn", "pymunk"), ("pymunk", "exudyn")):
        study = cost_study([SCENE], order, orbits=0.1, repeats=1, time_limit_s=5.0)
        store = StudyStore(FILES, tmp_path / order[0], study.record())
        noted = []
        run = CostRun(study, store, Reporter(note=noted.append))
        run.haste_at, run.bench = haste_s, Bench()
        case = run.first_pass(SimpleNamespace(scene=study.scenes[0]), sweeps(study.scenes[0], study.engines)[0], 1e9)
        list(run_cases([("", case)], ALL_CORES))
        found = {(r["engine"], r["setting"]) for r in run.rows.values() if r["outcome"] == "pass"}
        hasty = [r["reason"] for r in run.rows.values() if "half used" in r["reason"]]
        assert len(noted) == len(store.record["shortened_limits_s"]) >= bool(hasty), "a shortened limit is told once"
        measured.append(found)
    assert measured[0] == measured[1]
    assert {engine for engine, _ in measured[0]} == {"exudyn", "pymunk"}


def test_after_the_budget_no_setting_but_the_coarsest_is_begun(tmp_path):
    class Bench:
        spent_s = 0.0

        def run(self, job, time_limit_s):
            del job, time_limit_s
            self.spent_s += 1.0
            return Known(RunResult(Outcome.PASS, seconds={"build": 0.0, "simulate": 1e-3, "read": 0.0}))

    study = cost_study([SCENE], ["exudyn", "pymunk"], orbits=0.1, repeats=1)
    run = CostRun(study, StudyStore(FILES, tmp_path, study.record()), Reporter())
    run.bench = Bench()
    sweep = sweeps(study.scenes[0], study.engines)[0]
    list(run_cases([("", run.first_pass(SimpleNamespace(scene=study.scenes[0]), sweep, 3.5))], ALL_CORES))
    assert [r["outcome"] for r in run.rows.values()].count("pass") == 4
    assert {r["outcome"] for r in run.rows.values()} == {"pass", NotRun.BUDGET}
    assert stopped(pd.DataFrame(r for r in run.rows.values() if r["engine"] == "exudyn")) == "not run: budget"


def test_the_first_pass_leaves_time_for_the_fewest_rounds_and_rounds_that_were_not_run_say_so(tmp_path):
    """Each run takes 1 s: what the first pass measures can be measured three more times in the 60 s."""

    class Bench:
        spent_s = 0.0

        def run(self, job, time_limit_s, turn=0):
            del job, time_limit_s, turn
            self.spent_s += 1.0
            return Known(RunResult(Outcome.PASS, seconds={"build": 0.0, "simulate": 1e-3, "read": 0.0}))

    said = []
    study = cost_study([SCENE], ["reference", "scipy-dop853"], orbits=0.1, repeats=7)
    run = CostRun(study, StudyStore(FILES, tmp_path, study.record()), Reporter(step=lambda *told: said.append(told)))
    run.bench = Bench()
    sweep = sweeps(study.scenes[0], study.engines)[0]
    list(run_cases([("", run.first_pass(SimpleNamespace(scene=study.scenes[0]), sweep, 60.0))], ALL_CORES))
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
    sweeps_of = [
        sweep_of("exudyn", (100, 500, 1000)),
        sweep_of("reference", (1e-4, 1e-6)),
        sweep_of("exudyn-tree", (50, 100)),
    ]
    seconds = [(0.01, 0.05, 0.2), (0.01, 0.01), (0.3, 0.6)]
    points = {
        name_of(job): {"outcome": "pass", "seconds": s}
        for jobs, own in zip(sweeps_of, seconds, strict=True)
        for job, s in zip(jobs, own, strict=True)
    }
    found = load_jobs(sweeps_of, points)
    assert [(j.engine, j.setting.value) for j in found] == [("exudyn", 500), ("exudyn-tree", 50)]
    failed = {key: {"outcome": "failed", "seconds": np.nan} for key in points}
    assert load_jobs(sweeps_of, failed) == []


def test_the_share_of_the_loads_is_the_time_that_they_add_when_applied_once_more():
    job = sweep_of("exudyn", (100,))[0]
    spread = np.array([0.98, 0.99, 1.0, 1.0, 1.0, 1.01, 1.02])
    row = load_row(job, 0.010 * spread, 0.014 * spread)
    assert row["share"] == pytest.approx(0.4)
    assert 0.35 < row["share_low"] < 0.4 < row["share_high"] < 0.45  # 2 % in each of the two medians


def test_each_load_is_applied_twice_in_the_second_run():
    class Bench:
        def run(self, job, time_limit_s, turn):
            asked.append(job.options)
            return Known(RunResult(Outcome.PASS, "", None, {"simulate": 2.0 if job.options else 1.0}))

    asked = []
    case = load_rows(Bench(), sweep_of("exudyn", (100,))[0], LIMIT_S)
    [(_, [found])] = run_cases([("", case)], ALL_CORES)
    assert asked == [(), ("repeated_load",)] * 7
    assert found["share"] == 1.0
