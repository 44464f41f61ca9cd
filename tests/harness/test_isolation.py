"""A run that goes wrong costs one row with a readable reason, never the comparison."""

import dataclasses

import pandas as pd
import pytest

from adapters.engine import AccuracyParameter, Setting
from adapters.registry import ENGINES, Registration
from barchain.runs.executors import LocalProcesses
from barchain.runs.job import Job, Role
from barchain.runs.pool import LocalSession
from barchain.runs.tasks import PoolGroup, pool_group
from barchain.solutions.judging import solution_jobs
from barchain.studies.comparison.run import run_comparison
from reports.chapters.comparison.overview import summary_verdict
from reports.chapters.comparison.summary import summarise
from reports.render import render
from reports.results.comparison import read_results
from reports.results.outcome import Outcome
from scenarios import load_scene
from tests.support.faulty_engines import UNSOLVABLE
from tests.support.results import read_record
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
FURTHER = tuple(sorted(FAULTS.keys() - set(QUICK)))


def unshipped(name):
    """A shipped scene over other samples: no solution for them comes with barchain."""
    scene = load_scene(name)
    return dataclasses.replace(scene, run=dataclasses.replace(scene.run, samples=scene.run.samples - 20))


def registered(names):
    return {name: Registration(f"tests.support.faulty_engines:{name}") for name in names}


BOTH = registered(["Unmodified"]) | {"CanNot": Registration("tests.support.stability_engines:CanNot")}


@pytest.fixture(scope="module", params=[QUICK, pytest.param(FURTHER, marks=pytest.mark.exhaustive)], ids=["", "rest"])
def spoiled(request, tmp_path_factory):
    """One comparison over some faults, all but the quick ones with unmodified engines among them, and its folder."""
    folder = tmp_path_factory.mktemp("faulty")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        result = run_comparison([SCENE], out=folder / "out", time_limit_s=8.0, registered=registered(request.param))
    return request.param, folder, result


def test_each_kind_of_fault_costs_its_own_row_and_says_why_and_the_comparison_fails(spoiled):
    names, folder, result = spoiled
    assert not result.passed
    for name in names:
        outcome, words = FAULTS[name]
        assert result.outcomes[SCENE, name] is outcome
        reasons = list(result.metrics.query("engine == @name").reason)
        assert any(words in reason for reason in reasons), reasons
        assert not any("\n" in reason or "Traceback" in reason for reason in reasons)
    assert not (folder / "stray.txt").exists()


@pytest.mark.slow
def test_an_engine_that_hangs_in_every_scene_is_tried_in_two_and_late_in_all():
    scenes = ["basics/two_bars_free", "basics/free_rotation", "basics/kepler_circular", "basics/libration"]
    registrations = registered(["Hangs"]) | {"reference": ENGINES["reference"]}
    result = run_comparison(scenes, time_limit_s=3.0, registered=registrations, executor=LocalProcesses(2))
    assert {result.outcomes[scene, "reference"] for scene in scenes} == {Outcome.PASS}
    assert {result.outcomes[scene, "Hangs"] for scene in scenes} == {Outcome.TIMED_OUT}
    reasons = result.metrics.query("engine == 'Hangs'").groupby("scene")["reason"].first()
    assert sum(reason.startswith("not tried: it was late in ") for reason in reasons) >= 1


@pytest.mark.exhaustive
def test_what_an_engine_prints_does_not_come_through(capfd):
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


@pytest.mark.exhaustive
def test_a_scene_without_a_reference_solution_is_one_failure_and_none_of_its_engines(tmp_path, monkeypatch):
    """Two scenes, of which one has no reference solution, and an engine that can do neither."""
    monkeypatch.setitem(ENGINES, "faulty", registered(["LosesItsGrip"])["LosesItsGrip"])
    monkeypatch.setattr("barchain.solutions.judging.judging_engine", lambda _: "faulty")
    result = run_comparison([SCENE, unshipped(UNSOLVABLE)], out=tmp_path, registered=BOTH, need_external=True)
    assert result.outcomes == {
        (SCENE, "Unmodified"): Outcome.PASS,
        (SCENE, "CanNot"): Outcome.UNSUPPORTED,
        (UNSOLVABLE, "CanNot"): Outcome.UNSUPPORTED,
        (UNSOLVABLE, "(judging solution)"): Outcome.FAILED,
    }
    assert not result.passed
    own = result.metrics.query("scene == @UNSOLVABLE and engine == '(judging solution)'")
    assert list(own.reason) == ["the judging solution could not be run (the joint system is singular at t = 12 s)"]
    verdict = summary_verdict(summarise(read_results(tmp_path)))
    assert not verdict.good
    assert [(c.scene, c.engine) for c in verdict.failures] == [(UNSOLVABLE, "(judging solution)")]
    assert all("singular at t = 12 s" in shown.read_text() for shown in render(tmp_path))


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("scenes", "names", "passes"),
    [([SCENE], ["Unmodified", "CanNot"], False), ([SCENE], None, True), ([SCENE, "basics/free_rotation"], None, False)],
)
def test_an_engine_compared_on_no_scene_is_a_failure_if_it_was_named(scenes, names, passes, tmp_path):
    """And if it can do none of several scenes though nobody named it."""
    result = run_comparison(scenes, names, tmp_path, registered=BOTH)
    assert result.passed is passes
    lacking = {pair: outcome for pair, outcome in result.outcomes.items() if not outcome.ok}
    assert lacking == ({} if passes else {("(all scenes)", "CanNot"): Outcome.NOTHING_COMPARED})
    verdict = summary_verdict(summarise(read_results(tmp_path)))
    assert verdict.good is passes
    told = f"CanNot was compared on no scene: {CanNot.unsupported(load_scene(SCENE))}." in verdict.sentences
    assert passes or told


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
