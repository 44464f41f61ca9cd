"""Ends of studies: exit code 0 only if everything asked for ran; obstacles are told before the first run."""

from __future__ import annotations

import pytest

from adapters.registry import ENGINES, Registration
from barchain.cli.common.exit_codes import ExitCode
from barchain.cli.main import run
from barchain.runs.left_out import failures
from barchain.studies.ensemble.chunks import RunTally
from barchain.studies.ensemble.study import EnsembleSummary
from barchain.studies.selftest.trial import SceneRuns
from barchain.studies.stability.plan import recorded
from barchain.studies.study import StudyEnd
from reports.results.reading import DamagedResultsError
from reports.results.rows import NOT_RUN
from reports.results.schema import KEY, SCHEMA_VERSION
from tests.support.results import read_record, read_table, write_record

LONG = "x" * 250  # more than a file system takes, with an ending
QUICK = "basics/libration"
BROKEN = "the adapter nowhere:Nothing does not load: ModuleNotFoundError: No module named 'nowhere'"


def point(engine, outcome, scene="s", reason="why"):
    return {"scene": scene, "engine": engine, "outcome": outcome, "reason": reason}


@pytest.mark.parametrize(("points", "named", "said"), [
    ([point("a", "pass"), point("b", "failed"), point("b", "pass")], set(), ()),  # it ran at one of its settings
    ([point("a", "pass"), point("c", "failed"), point("c", "timed_out")], set(), ("s c: failed: why",)),
    ([point("a", "pass"), point("b", "unsupported"), point("c", "missing"), point("d", NOT_RUN)], set(), ()),
    ([point("a", "pass"), point("b", "unsupported")], {"a", "b"}, ("s b: unsupported: why",)),
    ([point("b", "unsupported"), point("b", "pass", scene="t")], {"b"}, ()),
    ([point("a", NOT_RUN)], set(), ("nothing was measured",)),
    ([], set(), ("nothing was measured",)),
])  # fmt: skip
def test_what_did_not_run_is_a_failure_unless_it_was_declared_and_nobody_named_the_engine(points, named, said):
    assert failures(points, named=named) == said


def test_a_failed_run_of_an_ensemble_and_a_failed_task_of_the_roundoff_study_do_not_pass():
    tally = RunTally()
    tally.add({"run": [1, 2], "outcome": ["finished", "failed"], "reason": ["", "diverged"], "evaluations": [3, 4]})
    ensemble = EnsembleSummary(None, None, tally, {})
    assert ensemble.failures == ("1 of 2 runs failed, the first of them run 2: diverged",)
    assert not ensemble.passed
    assert not StudyEnd(("times: x: y",)).passed
    assert StudyEnd().passed


@pytest.fixture
def broken(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(ENGINES, "broken", Registration("nowhere:Nothing"))
    return tmp_path


@pytest.mark.parametrize("command", [
    f"simulate {QUICK} --engine broken --out x.csv",
    f"compare {QUICK} --engine broken --set broken:rtol=1e-8 --out x",
    f"selftest {QUICK} --engine broken --out x",
])  # fmt: skip
def test_an_adapter_that_does_not_load_is_one_line_and_nothing_is_written(command, broken, capsys):
    assert run(command.split()) == ExitCode.FINDINGS
    assert capsys.readouterr().err == f"barchain: {BROKEN}\n"
    assert list(broken.iterdir()) == []


@pytest.mark.parametrize("command", [
    f"ensemble {QUICK} --vary angle_deg=normal(0,1) --runs 2 --out x",
    f"effects {QUICK} --engine reference-fast --out x",
])  # fmt: skip
def test_a_command_whose_own_engine_does_not_load_ends_in_one_line(command, broken, monkeypatch, capsys):
    monkeypatch.setitem(ENGINES, "reference-fast", Registration("nowhere:Nothing"))
    assert run(command.split()) == ExitCode.FINDINGS
    assert capsys.readouterr().err == f"barchain: {BROKEN}\n"


@pytest.mark.slow
def test_an_engine_that_does_not_load_costs_the_stability_study_its_own_rows(broken, capsys):
    assert run(["-q", "stability", QUICK, "--engine=broken", "--engine=rebound", "--out=x"]) == ExitCode.FINDINGS
    assert "broken: " + BROKEN in capsys.readouterr().err
    rows = read_table(broken / "x", "stability", "outcomes").set_index("engine")
    assert rows.loc["broken", "stability"] == "failed"
    assert rows.loc["rebound", "stability"] != "failed"


def test_a_scene_is_shown_beside_an_adapter_that_does_not_load(broken, capsys):
    assert run(["scenes", "show", QUICK]) == ExitCode.OK
    assert BROKEN in capsys.readouterr().out


def test_a_scaling_study_of_an_engine_that_does_not_load_exits_with_1(broken, capsys):
    assert run(["-q", "scaling", "--engine", "broken", "--bars", "2", "--out", "x"]) == ExitCode.FINDINGS
    assert f"barchain: broken: failed: {BROKEN}\n" in capsys.readouterr().err
    assert read_record(broken / "x", "scaling")["finished"]


def test_a_selftest_that_can_not_go_on_is_a_failed_run(monkeypatch, capsys, tmp_path):
    def fails(self, form):
        yield []
        return "the reference solution could not be run (diverged)"

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(SceneRuns, "established", fails)
    assert run(["selftest", QUICK, "--fault", "scale-rate", "--workers", "1"]) == ExitCode.FINDINGS
    said = f"barchain: {QUICK}: the reference solution could not be run (diverged)\n"
    assert capsys.readouterr().err.endswith(said)


@pytest.mark.parametrize(("command", "beside"), [
    (f"cost {QUICK} --engine reference", "comparison"), ("scaling --engine reference --bars 2", "comparison"),
    (f"compare {QUICK} --engine reference", "cost"),
])  # fmt: skip
def test_a_study_beside_results_that_can_not_be_rendered_ends_before_its_first_run(command, beside, tmp_path, capsys):
    write_record(tmp_path, {KEY: SCHEMA_VERSION + 1}, beside)
    assert run([*command.split(), "--out", str(tmp_path)]) == ExitCode.BAD_INPUT
    error = capsys.readouterr().err
    assert f"record/{beside}.json: schema version {SCHEMA_VERSION + 1}" in error
    assert error.count("\n") == 1


@pytest.mark.parametrize("command", [
    f"simulate {QUICK} --out {LONG}.csv", f"stability hard/whip --out x --accept {LONG}.toml",
])  # fmt: skip
def test_a_file_that_can_not_be_written_is_known_before_anything_runs(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(command.split()) == ExitCode.BAD_INPUT
    assert "no file can be written there" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("text", ["a = [", "a = 1", '[a]\nb = "odd"', "[" * 5000])
def test_recorded_outcomes_that_are_none_are_one_line_before_anything_runs(text, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "e.toml").write_text(text)
    assert run(["stability", "hard/whip", "--out", "x", "--accept", "e.toml"]) == ExitCode.BAD_INPUT
    assert capsys.readouterr().err.count("\n") == 1
    with pytest.raises(DamagedResultsError, match=r"e\.toml"):
        recorded(tmp_path / "e.toml")
