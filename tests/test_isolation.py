"""A run that goes wrong costs one row with a readable reason, never the comparison."""

import dataclasses
import json

import pandas as pd
import pytest

from adapters.engine import Knob, Setting
from adapters.registry import ENGINES, Registration
from barchain import api
from barchain.job import TRUTH_ROLES, Job, Role, failure
from barchain.pool import Room, room
from barchain.suite import SceneProgress, Suite
from barchain.truth_runs import truth_jobs
from reports.outcome import Outcome
from scenarios import load_scene

SCENE = "basics/two_bars_free"
FAULTS = {
    "Segfault": (Outcome.FAILED, "SIGSEGV"),
    "Aborts": (Outcome.FAILED, "SIGABRT"),
    "Hangs": (Outcome.TIMED_OUT, "no result within 8 s"),
    "GivesUp": (Outcome.FAILED, "step size became zero"),
    "Raises": (Outcome.FAILED, "ZeroDivisionError: inside the engine"),
    "DoesNotImport": (Outcome.MISSING, "libmissing.so"),
    "ReturnsNan": (Outcome.NOT_FINITE, "angle_rad is not finite from sample 7"),
    "StopsEarly": (Outcome.INCOMPLETE, "returned 100 of 201 samples"),
    "DropsChannel": (Outcome.INCOMPLETE, "declares but does not return: reaction"),
    "WrongShape": (Outcome.INCOMPLETE, "rate_rad_s has shape (201, 1), wanted (201, 2)"),
    "LateClock": (Outcome.INCOMPLETE, "away from the instants asked for"),
    "IgnoresJoints": (Outcome.JOINTS_IGNORED, "joint 1 is open by"),
    "IgnoresJointsInSilence": (Outcome.INCONSISTENT, "times what is explained"),
    "SwapsSign": (Outcome.INCONSISTENT, "times what is explained"),
    "WrongVelocity": (Outcome.INCONSISTENT, "times what is explained"),
    "IsSloppy": (Outcome.INCONSISTENT, "times the band"),
    "NotThere": (Outcome.FAILED, "its adapter does not load"),
    "Sound": (Outcome.PASS, ""),
    "Chatters": (Outcome.PASS, ""),
}


def registered(names):
    return {name: Registration(f"tests.faulty_engines:{name}") for name in names}


@pytest.fixture(scope="module")
def spoiled(tmp_path_factory):
    """One comparison over every fault, with sound engines among them."""
    folder = tmp_path_factory.mktemp("spoiled")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        result = api.compare([SCENE], out=folder / "out", time_limit_s=8.0, registered=registered(FAULTS))
    return folder, result


@pytest.mark.parametrize(("name", "expected"), FAULTS.items())
def test_each_fault_costs_its_own_row_and_says_why(spoiled, name, expected):
    _, result = spoiled
    outcome, words = expected
    assert result.outcomes[SCENE, name] is outcome
    rows = result.metrics.query("engine == @name")
    assert any(words in reason for reason in rows.reason), list(rows.reason)
    assert not any("\n" in reason or "Traceback" in reason for reason in rows.reason)


def test_faults_make_the_comparison_fail(spoiled):
    assert not spoiled[1].passed


def test_what_an_engine_prints_or_leaves_behind_does_not_come_through(spoiled, capfd):
    folder, _ = spoiled
    assert not (folder / "stray.txt").exists()
    api.compare([SCENE], registered=registered(["Chatters"]))
    printed = capfd.readouterr()
    assert "hello" not in printed.out + printed.err


def test_what_an_engine_changes_in_its_process_is_gone_for_the_next():
    found = api.compare([SCENE], registered=registered(["LeavesTraces", "SeesTraces"]), workers=1)
    assert found.outcomes[SCENE, "SeesTraces"] is Outcome.PASS


def test_the_truth_is_run_where_no_engine_was():
    scene = load_scene(SCENE)
    ours = Job(scene, "exudyn", ENGINES["exudyn"], Setting(Knob.STEPS_PER_ORBIT, 100.0), Role.MAIN)
    theirs = dataclasses.replace(ours, engine="Sound", registration=registered(["Sound"])["Sound"])
    assert {room(job) for job in truth_jobs(scene)} == {Room.TRUTH}
    assert (room(ours), room(theirs)) == (Room.OURS, Room.THIRD_PARTY)
    assert Room.THIRD_PARTY.runs_per_worker == 1


def test_why_a_truth_failed_is_said_once():
    progress = SceneProgress(load_scene(SCENE))
    progress.truths = {role: failure(Outcome.FAILED, "no steps left") for role in TRUTH_ROLES}
    Suite.found_truth(object.__new__(Suite), progress)
    assert progress.truth_failed == "the truth could not be run (no steps left)"


def test_results_so_far_are_kept_and_resumed(tmp_path, monkeypatch):
    first = api.compare([SCENE], out=tmp_path, registered=registered(["Sound", "GivesUp"]))
    record = json.loads((tmp_path / "run.json").read_text())
    assert record["finished"]
    made = []
    monkeypatch.setattr("barchain.suite.run_jobs", lambda jobs, **_: made.extend(jobs) or iter(()))
    second = api.compare([SCENE], out=tmp_path, resume=True, registered=registered(["Sound", "GivesUp"]))
    assert [job.engine for job in made] == ["GivesUp", "GivesUp"]  # only what failed is tried again
    kept = first.metrics.query("engine == 'Sound'")
    pd.testing.assert_frame_equal(second.metrics.query("engine == 'Sound'"), kept)


def test_a_comparison_cut_off_leaves_the_tables_it_had(tmp_path):
    def stop(scene, engine, outcome):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        api.compare([SCENE], out=tmp_path, registered=registered(["Sound"]), progress=stop)
    record = json.loads((tmp_path / "run.json").read_text())
    assert not record["finished"]
    assert set(pd.read_csv(tmp_path / "metrics.csv").engine) == {"Sound"}


def test_a_scene_that_no_external_engine_passes_is_a_failure():
    result = api.compare([SCENE], registered=registered(["GivesUp"]), need_external=True)
    assert result.outcomes[SCENE, "(any external)"] is Outcome.NOTHING_COMPARED
