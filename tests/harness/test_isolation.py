"""A run that goes wrong costs one row with a readable reason, never the comparison."""

import dataclasses

import pandas as pd
import pytest

from adapters.engine import AccuracyParameter, Setting
from adapters.registry import ENGINES, Registration
from barchain.record.study_store import StudyStore
from barchain.runs.executors import LocalProcesses
from barchain.runs.job import Job, Role, failure
from barchain.runs.pool import LocalSession
from barchain.runs.tasks import PoolGroup, pool_group
from barchain.solutions.judging import solution_jobs
from barchain.studies.comparison.run import Comparison, run_comparison
from barchain.studies.comparison.suite import Suite
from barchain.studies.study import Reporter
from reports.chapters.comparison.overview import summary_verdict
from reports.chapters.comparison.summary import summarise
from reports.render import render
from reports.results.comparison import FILES, read_results
from reports.results.outcome import Outcome
from scenarios import load_scene
from tests.support.faulty_engines import UNSOLVABLE
from tests.support.results import read_record, read_table
from tests.support.stability_engines import CanNot

SCENE = "basics/two_bars_free"
FAULTS = {
    "Segfault": (Outcome.FAILED, "SIGSEGV"),
    "Aborts": (Outcome.FAILED, "SIGABRT"),
    "Hangs": (Outcome.TIMED_OUT, "no result within 8 s"),
    "GivesUp": (Outcome.FAILED, "step size became zero"),
    "Raises": (Outcome.FAILED, "ZeroDivisionError: inside the engine"),
    "DoesNotImport": (Outcome.MISSING, "libmissing.so"),
    "ReturnsNan": (Outcome.NOT_FINITE, "angle_rad is not finite from sample 100"),
    "StopsEarly": (Outcome.INCOMPLETE, "returned 100 of 201 samples"),
    "DropsChannel": (Outcome.INCOMPLETE, "declares but does not return: reaction"),
    "WrongShape": (Outcome.INCOMPLETE, "rate_rad_s has shape (201, 1), expected (201, 2)"),
    "LateClock": (Outcome.INCOMPLETE, "away from the instants asked for"),
    "IgnoresJoints": (Outcome.JOINTS_IGNORED, "joint 1 is open by"),
    "IgnoresJointsInSilence": (Outcome.INCONSISTENT, "times the explained error"),
    "SwapsSign": (Outcome.INCONSISTENT, "times the explained error"),
    "WrongVelocity": (Outcome.INCONSISTENT, "times the explained error"),
    "IsSloppy": (Outcome.INCONSISTENT, "times the expected-error bound"),
    "NotThere": (Outcome.FAILED, "does not load"),
    "Unmodified": (Outcome.PASS, ""),
    "Chatters": (Outcome.PASS, ""),
}
QUICK = ("Segfault", "DoesNotImport", "NotThere")
"""Faults that every test run tries: a crash, an exception at import, no such class"""


def unshipped(name):
    """A shipped scene over other samples: no solution for them comes with barchain."""
    scene = load_scene(name)
    return dataclasses.replace(scene, run=dataclasses.replace(scene.run, samples=scene.run.samples - 20))


def registered(names):
    return {name: Registration(f"tests.support.faulty_engines:{name}") for name in names}


def spoiled_by(names, folder):
    """One comparison over some faults, and its folder."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        return folder, run_comparison([SCENE], out=folder / "out", time_limit_s=8.0, registered=registered(names))


@pytest.fixture(scope="module")
def spoiled(tmp_path_factory):
    """One comparison over the quick faults."""
    return spoiled_by(QUICK, tmp_path_factory.mktemp("faulty"))


@pytest.fixture(scope="module")
def spoiled_further(tmp_path_factory):
    """One comparison over all other faults, with unmodified engines among them."""
    return spoiled_by(sorted(FAULTS.keys() - set(QUICK)), tmp_path_factory.mktemp("faulty"))


def check_row(result, name):
    outcome, words = FAULTS[name]
    assert result.outcomes[SCENE, name] is outcome
    rows = result.metrics.query("engine == @name")
    assert any(words in reason for reason in rows.reason), list(rows.reason)
    assert not any("\n" in reason or "Traceback" in reason for reason in rows.reason)


@pytest.mark.parametrize("name", QUICK)
def test_each_kind_of_fault_costs_its_own_row_and_says_why(spoiled, name):
    check_row(spoiled[1], name)


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", sorted(FAULTS.keys() - set(QUICK)))
def test_each_fault_costs_its_own_row_and_says_why(spoiled_further, name):
    check_row(spoiled_further[1], name)


@pytest.mark.slow
def test_an_engine_that_hangs_in_every_scene_is_tried_in_two_and_late_in_all():
    scenes = ["basics/two_bars_free", "basics/free_rotation", "basics/kepler_circular", "basics/libration"]
    registrations = registered(["Hangs"]) | {"reference": ENGINES["reference"]}
    result = run_comparison(scenes, time_limit_s=3.0, registered=registrations, executor=LocalProcesses(2))
    assert {result.outcomes[scene, "reference"] for scene in scenes} == {Outcome.PASS}
    assert {result.outcomes[scene, "Hangs"] for scene in scenes} == {Outcome.TIMED_OUT}
    reasons = result.metrics.query("engine == 'Hangs'").groupby("scene")["reason"].first()
    assert sum(reason.startswith("not tried: it was late in ") for reason in reasons) >= 1


def test_faults_make_the_comparison_fail(spoiled):
    assert not spoiled[1].passed


@pytest.mark.exhaustive
def test_what_an_engine_prints_or_leaves_behind_does_not_come_through(spoiled_further, capfd):
    folder, _ = spoiled_further
    assert not (folder / "stray.txt").exists()
    run_comparison([SCENE], registered=registered(["Chatters"]))
    printed = capfd.readouterr()
    assert "hello" not in printed.out + printed.err


@pytest.mark.exhaustive
def test_what_an_engine_changes_in_its_process_is_gone_for_the_next():
    found = run_comparison([SCENE], registered=registered(["LeavesTraces", "SeesTraces"]), executor=LocalProcesses(1))
    assert found.outcomes[SCENE, "SeesTraces"] is Outcome.PASS


def test_reference_solutions_run_in_processes_without_other_engines():
    scene = load_scene(SCENE)
    ours = Job(scene, "exudyn", ENGINES["exudyn"], Setting(AccuracyParameter.STEPS_PER_ORBIT, 100.0), Role.MAIN)
    theirs = dataclasses.replace(ours, engine="Unmodified", registration=registered(["Unmodified"])["Unmodified"])
    assert {pool_group(job) for job in solution_jobs(scene)} == {PoolGroup.SOLUTION}
    assert (pool_group(ours), pool_group(theirs)) == (PoolGroup.REGISTERED, PoolGroup.THIRD_PARTY)


def test_why_a_reference_solution_failed_is_said_once(tmp_path):
    comparison = Comparison([unshipped(SCENE)], {})
    suite = Suite(comparison, StudyStore(FILES, tmp_path, comparison.record()), Reporter())
    progress = suite.progress[SCENE]
    case = suite.solution(progress)
    asked = next(case)
    with pytest.raises(StopIteration):
        case.send([failure(Outcome.FAILED, "no steps left") for _ in asked])
    assert progress.solution_failed == "the judging solution could not be run (no steps left)"


@pytest.fixture(scope="module")
def unsolved(tmp_path_factory):
    """Two scenes, of which one has no reference solution, and an engine that can do neither."""
    folder = tmp_path_factory.mktemp("unsolved")
    names = {
        "Unmodified": "tests.support.faulty_engines:Unmodified",
        "CanNot": "tests.support.stability_engines:CanNot",
    }
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(ENGINES, "faulty", registered(["LosesItsGrip"])["LosesItsGrip"])
        patch.setattr("barchain.solutions.judging.judging_engine", lambda _: "faulty")
        both = {name: Registration(target) for name, target in names.items()}
        result = run_comparison([SCENE, unshipped(UNSOLVABLE)], out=folder, registered=both, need_external=True)
    return folder, result


@pytest.mark.exhaustive
def test_a_scene_without_a_reference_solution_is_one_failure_and_none_of_its_engines(unsolved):
    _, result = unsolved
    assert result.outcomes == {
        (SCENE, "Unmodified"): Outcome.PASS,
        (SCENE, "CanNot"): Outcome.UNSUPPORTED,
        (UNSOLVABLE, "CanNot"): Outcome.UNSUPPORTED,
        (UNSOLVABLE, "(judging solution)"): Outcome.FAILED,
    }
    assert not result.passed
    own = result.metrics.query("scene == @UNSOLVABLE and engine == '(judging solution)'")
    assert list(own.reason) == ["the judging solution could not be run (the joint system is singular at t = 12 s)"]


@pytest.mark.exhaustive
def test_the_report_tells_of_a_scene_without_a_reference_solution_once(unsolved):
    folder, _ = unsolved
    verdict = summary_verdict(summarise(read_results(folder)))
    assert not verdict.good
    could_not = "the judging solution of scene basics/libration could not be run"
    assert verdict.headline == f"The one comparison passed, but {could_not}."
    assert [(c.scene, c.engine) for c in verdict.failures] == [(UNSOLVABLE, "(judging solution)")]
    assert "1 passed" in verdict.sentences[0]
    assert "0 failed, 2 unsupported, 1 not run" in verdict.sentences[0]
    page, text = render(folder)
    for shown in (page.read_text(), text.read_text()):
        assert "singular at t = 12 s" in shown
    assert "| not run |" in text.read_text().split("## Matrix")[1]
    assert "No engine was compared on" not in text.read_text()


@pytest.mark.exhaustive
@pytest.mark.parametrize("names", [["Unmodified", "CanNot"], None])
def test_an_engine_compared_on_no_scene_is_a_failure_if_it_was_named(names, tmp_path):
    both = registered(["Unmodified"]) | {"CanNot": Registration("tests.support.stability_engines:CanNot")}
    result = run_comparison([SCENE], names, tmp_path, registered=both)
    assert result.passed is (names is None)
    verdict = summary_verdict(summarise(read_results(tmp_path)))
    assert verdict.good is result.passed
    reason = CanNot.unsupported(load_scene(SCENE))
    if names:
        assert result.outcomes["(all scenes)", "CanNot"] is Outcome.NOTHING_COMPARED
        assert verdict.headline == "The one comparison passed, but nothing was compared with CanNot."
        assert f"CanNot was compared on no scene: {reason}." in verdict.sentences
    assert all("(all scenes)" not in path.read_text() for path in render(tmp_path))


@pytest.mark.exhaustive
def test_an_engine_that_can_do_none_of_several_scenes_is_a_failure_though_nobody_named_it(tmp_path):
    both = registered(["Unmodified"]) | {"CanNot": Registration("tests.support.stability_engines:CanNot")}
    result = run_comparison([SCENE, "basics/free_rotation"], out=tmp_path, registered=both)
    assert not result.passed
    assert {pair for pair, o in result.outcomes.items() if not o.ok} == {("(all scenes)", "CanNot")}
    assert not summary_verdict(summarise(read_results(tmp_path))).good


@pytest.mark.slow
def test_results_so_far_are_kept_and_resumed(tmp_path, monkeypatch):
    first = run_comparison([SCENE], out=tmp_path, registered=registered(["Unmodified", "GivesUp"]))
    record = read_record(tmp_path)
    assert record["finished"]
    made, start = [], LocalSession.start
    monkeypatch.setattr(LocalSession, "start", lambda *given: made.append(given[2]) or start(*given))
    second = run_comparison([SCENE], out=tmp_path, resume=True, registered=registered(["Unmodified", "GivesUp"]))
    targets = [call.given[2][0].target for call in made]
    assert targets == ["tests.support.faulty_engines:GivesUp"] * 2  # only what failed is tried again
    kept = first.metrics.query("engine == 'Unmodified'")
    pd.testing.assert_frame_equal(second.metrics.query("engine == 'Unmodified'"), kept)


@pytest.mark.slow
def test_a_comparison_cut_off_leaves_the_tables_it_had(tmp_path):
    def stop(scene, engine, outcome):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_comparison([SCENE], out=tmp_path, registered=registered(["Unmodified"]), reporter=Reporter(stop))
    record = read_record(tmp_path)
    assert not record["finished"]
    assert set(read_table(tmp_path).engine) == {"Unmodified"}


@pytest.mark.slow
def test_a_scene_that_no_external_engine_passes_is_a_failure():
    result = run_comparison([SCENE], registered=registered(["GivesUp"]), need_external=True)
    assert result.outcomes[SCENE, "(any independent engine)"] is Outcome.NOTHING_COMPARED


@pytest.mark.exhaustive
def test_a_verdict_that_takes_too_long_is_no_failure_of_the_engine(monkeypatch):
    monkeypatch.setattr("barchain.studies.verdict_tasks.JUDGING_S", 0.01)
    result = run_comparison(["paper/fig05"], ["rebound"])
    assert result.outcomes["paper/fig05", "rebound"] is Outcome.NOTHING_COMPARED
    assert not result.passed
    assert any("no verdict: no result within" in reason for reason in result.metrics.reason)
