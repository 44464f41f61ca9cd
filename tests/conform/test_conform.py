"""Examination of sound and of wrong engines: nothing is named without a mistake, and mistakes are named."""

from __future__ import annotations

import dataclasses
import json
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import pytest

from adapters.engine import AccuracyParameter, Setting
from adapters.registry import engines
from barchain.cli.main import run
from barchain.conform import Extent, conform, target
from barchain.conform.accuracy import accuracy, single_hint
from barchain.conform.behaviour import TIMES, behaviour
from barchain.conform.checks import Check, CheckState, ConformanceReport, Group
from barchain.conform.errors_at_settings import Compared
from barchain.conform.junit import write_junit
from barchain.conform.runs import START_S
from barchain.conform.target import extent_of
from barchain.runs import examination
from barchain.runs.asking import Reply, ask
from tests.support.kernel import needs_kernel
from tests.support.slow import one_in, rows

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path


pytestmark = needs_kernel
HERE = "tests.conform.wrong_engines"


def failed(report: ConformanceReport) -> dict[str, str]:
    """Words of the failed checks by their names."""
    return {c.name: c.words for c in report.failures}


def examined(name: str, *only: str) -> ConformanceReport:
    """Examination of a wrong engine, or a part of one: groups of checks, and scenes."""
    return conform(f"{HERE}:{name}", extent=extent_of(only))


def test_single_precision_is_a_fault_of_the_first_run_and_ends_the_examination() -> None:
    report = examined("SinglePrecision")
    assert failed(report) == {"a first run": "angle_rad holds float32, expected float64"}
    assert {c.group for c in report.checks if c.state is CheckState.NOT_RUN} == {
        Group.PHYSICS, Group.ACCURACY, Group.BEHAVIOUR,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("name", "check", "words"),
    one_in(8, rows([
        ("OrderOfChosenSteps", "order and setting", "expected None"),
        ("UnknownEffect", "effect names", "'oblatness' is no effect (did you mean oblateness?)"),
        ("FineFirst", "sweep", "not sorted from coarse to fine"),
        ("CoarserFinerRun", "sweep", "sweep.finer_rtol is 10, allowed: between 0 and 1"),
        ("OrderNotANumber", "order", "order is nan, allowed: 1 to 40, or None"),
        ("StepConstantZero", "step_constant", "step_constant is 0, allowed: greater than 0, at most 10"),
        ("NoClassMethod", "class", "unsupported is no class method; it needs @classmethod above it"),
        ("Unfinished", "class", "does not define build, read, simulate"),
        ("NoEngine", "class", "is no subclass of adapters.engine.Engine"),
        ("Missing", "import", "has no class Missing; its engines: "),
    ])),
)  # fmt: skip
def test_a_wrong_declaration_is_named_and_nothing_is_run(name: str, check: str, words: str) -> None:
    report = examined(name)
    assert words in failed(report)[check]
    assert all(c.state is CheckState.NOT_RUN for c in report.checks if c.group is not Group.LOADING)


TOLD = [
    ("SingleInside", "conventions", "double precision", ["rate_rad_s is in single precision"]),
    ("IgnoresSetting", "accuracy", "errors fall with the setting", ["all settings give the same result"]),
    ("IgnoresSetting", "accuracy", "errors inside the bound", ["times the bound at rtol=1e-"]),
    ("Noisy", "two_bars_free", "two bars free", ["declared noise of 1e+06 N is larger than the reactions"]),
    ("SingleState", "accuracy", "errors fall with the setting", ["Single precision inside an engine"]),
    ("KeepsModel", "", "one bar gradient", ["depends on the runs before it"]),
    ("Landed", "", "a first run", ["ended after 3 of 81 samples (a bar reached the surface), though no bar lands"]),
]
"""Engines that the slow tests examine, or a part of them; a check that fails, and its words"""
TOLD_LATER = [
    ("ReactionsReversed", "", "two bars free", ["Your reactions have the opposite sign"]),
    ("OtherTurns", "one_bar_free", "one bar free", ["Your angles differ by whole turns"]),
    ("FirstReactionWrong", "two_bars_free", "two bars free", ["at the first sample alone"]),
    ("RoundedAngles", "conventions", "double precision", ["angle_rad is rounded to multiples of 1e-6 of its unit"]),
    ("Untidy", "behaviour", "state of the process", ["changes the working folder", "signal handlers"]),
    ("ChangesScene", "behaviour", "state of the process", ["changes the scene that it is given"]),
    ("Seeds", "behaviour", "state of the process",
     ["seeds NumPy's global random", "seeds Python's global random", "sets MY_THREADS in later runs"]),
    ("Random", "behaviour", "same bits again", ["differ"]),
    ("OneBuffer", "", "arrays of its own", ["angle_rad"]),
    ("Empty", "", "a first run", ["returned no samples; the first, at t = 0, is always there"]),
]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "part", "check", "words"),
    [
        *(pytest.param(*told, marks=pytest.mark.slow) for told in TOLD),
        *(pytest.param(*told, marks=pytest.mark.exhaustive) for told in TOLD_LATER),
    ],
)
def test_a_mistake_is_told_by_its_check(name: str, part: str, check: str, words: list[str]) -> None:
    said = failed(examined(name, *filter(None, [part])))
    assert all(each in said[check] for each in words), said
    assert not any("gradient is missing" in each for each in said.values())


@pytest.mark.slow
def test_a_slow_engine_is_tried_at_the_settings_that_fit_into_the_time() -> None:
    slow = dataclasses.replace(target.examined(f"{HERE}:Slow"), run_s=2.0)
    found = {c.name: c for c in accuracy(slow)}
    assert found["time of runs"].state is CheckState.WARNING
    assert found["time of runs"].words == "2 of 5 settings end within 5 s"
    assert found["errors inside the bound"].state is CheckState.PASSED


@pytest.mark.exhaustive
def test_a_setting_that_hangs_costs_no_other_setting(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("barchain.conform.runs.START_S", 4.0)
    found = {c.name: c for c in accuracy(dataclasses.replace(target.examined(f"{HERE}:HangsAtOneSetting"), run_s=2.0))}
    assert found["runs at several settings"].words.startswith("rtol=0.0001: no result within 5 s, ended in build")
    assert found["runs at several settings"].page.endswith("#time-limits")
    assert found["errors inside the bound"].state is CheckState.PASSED


def test_runs_without_a_result_are_told_as_that_and_not_as_runs_that_differ(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[float] = []

    def answer(question: Callable[..., Any], *asked: object, limit_s: float, **others: object) -> Reply:
        seen.append(limit_s)
        if question is examination.behaviour and asked[-1] == 1:
            return Reply(problem="no result within 90 s, ended in build", kind="timed_out")
        return ask(question, *asked, limit_s=limit_s, **others)  # type: ignore[arg-type]

    monkeypatch.setattr("barchain.conform.behaviour.ask", answer)
    found = {c.name: c for c in behaviour(dataclasses.replace(target.examined(f"{HERE}:Right"), run_s=60.0))}
    assert found["a run in another process"].words == "no result within 90 s, ended in build"
    assert found["a run in another process"].page.endswith("#time-limits")
    assert "same bits again" not in found
    assert seen == [START_S + TIMES * 60.0, START_S + 60.0]


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("name", "state", "words"),
    [
        ("Right", CheckState.PASSED, "within "),
        ("RaisesOnLongRuns", CheckState.WARNING, "the run ended by itself (the run is too long)"),
    ],
)
def test_a_long_run_is_ended_while_it_integrates(name: str, state: CheckState, words: str) -> None:
    (found,) = [c for c in behaviour(target.examined(f"{HERE}:{name}")) if c.name == "end at a time limit"]
    assert found.state is state
    assert found.words.startswith(words)


def test_a_junit_file_of_an_engine_that_passes_no_scene_has_a_failure(tmp_path: Path) -> None:
    checks = (Check("two bars free", CheckState.WARNING, "round-off limits the run", group=Group.PHYSICS),)
    write_junit(tmp_path / "junit.xml", [ConformanceReport("mine", "1.0", checks, 1.0)])
    suite = ElementTree.parse(tmp_path / "junit.xml").getroot().find("testsuite")
    assert suite is not None
    assert suite.get("failures") == "1"
    assert [case.findtext("system-out") for case in suite] == ["round-off limits the run", None]


@pytest.mark.exhaustive
def test_a_part_of_the_examination_is_run_alone_and_is_no_conformance(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["conform", f"{HERE}:Right", "--only", "thrust_body"]) == 0
    shown = capsys.readouterr()
    assert "physics: thrust body" in shown.out
    assert not any(word in shown.out for word in ("behaviour:", "accuracy:", "conventions:", "two bars"))
    assert "passes a part of the examination" in shown.out
    assert "physics: 1 scene with one effect" in shown.err
    assert run(["conform", f"{HERE}:Right", "--only", "behaviour"]) == 0
    assert "physics:" not in capsys.readouterr().out


@pytest.mark.slow
def test_a_part_that_an_engine_does_not_support_is_no_pass(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["conform", "exudyn-tree", "--only", "impulse_alone"]) == 1
    assert "exudyn-tree: supports nothing of this part of the examination" in capsys.readouterr().out
    assert run(["conform", "exudyn-tree", "--only", "loading"]) == 0


@pytest.mark.exhaustive
def test_a_run_that_is_ended_tells_its_phase_and_the_option_that_allows_more_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("barchain.conform.runs.START_S", 3.0)
    found = failed(conform(f"{HERE}:Compiles", extent=Extent(time_limit_s=1.0)))
    assert found["a first run"].startswith("no result within 4 s, ended in build")
    assert "--time-limit" in found["a first run"]


@pytest.mark.exhaustive
def test_an_engine_without_rates_is_judged_up_to_the_predictability_limit() -> None:
    report = examined("NoRates")
    assert not [c for c in report.failures if c.group is Group.PHYSICS], failed(report)
    assert any("beyond the predictability limit" in c.words for c in report.checks if c.state is CheckState.WARNING)


@pytest.mark.parametrize(("coarse", "fine", "apart", "told"), [(1e-6, 1.2e-6, 1.4e-6, True), (1e-6, 2e-6, 1e-6, False)])
def test_errors_that_double_with_the_steps_are_not_told_as_single_precision(
    coarse: float, fine: float, apart: float, told: bool
) -> None:
    """A damping in each step; two random errors differ by as much as they are."""
    settings = Setting(AccuracyParameter.STEPS_PER_ORBIT, 100.0), Setting(AccuracyParameter.STEPS_PER_ORBIT, 200.0)
    pair = Compared(coarse, fine, settings, 50, 2.0, True, True, quantity="attitude", apart=apart)
    assert ("Single precision" in single_hint(pair)) is told


@pytest.mark.parametrize(
    ("words", "nearest"), [(["mujoko"], "mujoco"), ([f"{HERE}:Right", "--only", "thrust_bod"], "thrust_body?")]
)
def test_an_unknown_engine_or_part_is_one_line_with_the_nearest_name(
    words: list[str], nearest: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["conform", *words]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert f"did you mean {nearest}" in error


def test_the_command_exits_with_1_and_gives_the_checks_as_json_and_junit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    junit = tmp_path / "junit.xml"
    assert run(["conform", f"{HERE}:Unfinished", "--json", "--junit", str(junit)]) == 1
    found = json.loads(capsys.readouterr().out)
    assert found[0]["passed"] is False
    assert {c["state"] for c in found[0]["checks"]} == {"warning", "failed", "not run"}
    suite = ElementTree.parse(junit).getroot().find("testsuite")
    assert suite is not None
    assert suite.get("failures") == "1"


@pytest.mark.exhaustive
def test_an_exception_in_a_check_is_a_failed_check_and_all_files_are_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object) -> None:
        raise ZeroDivisionError("no step")

    monkeypatch.setattr("barchain.conform.physics.agreement", broken)
    monkeypatch.setattr("barchain.conform.errors_at_settings.setting_error", broken)
    junit = tmp_path / "junit.xml"
    assert run(["conform", f"{HERE}:Right", "--json", "--junit", str(junit)]) == 1
    (found,) = json.loads(capsys.readouterr().out)
    said = {c["group"]: c["words"] for c in found["checks"] if c["state"] == "failed"}
    assert set(said) == {"physics", "accuracy"}
    assert said["physics"].startswith("ended by an exception: ZeroDivisionError: no step (tests.conform.test_conform:")
    assert said["physics"].endswith(" in broken)")
    assert {c["state"] for c in found["checks"] if c["group"] == "behaviour"} == {"passed"}
    suite = ElementTree.parse(junit).getroot().find("testsuite")
    assert suite is not None
    assert suite.get("failures") == "2"


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", [name for name, r in engines().items() if not r.missing])
def test_every_engine_of_barchain_conforms(name: str) -> None:
    report = conform(name)
    assert report.passed, failed(report)
