"""Compiling: it has a time limit of its own."""

from __future__ import annotations

import dataclasses
import time
from typing import TYPE_CHECKING

import pytest

from adapters.engine import AccuracyParameter, Setting
from adapters.registry import ENGINES
from barchain.api import compare
from barchain.runs.executors import LocalProcesses
from barchain.runs.job import COMPILE_S, Job, Role, RunResult, TimeLimit, failure
from barchain.runs.tasks import run_jobs
from barchain.solutions.judging import judging_engine, solution_jobs
from reports.render import render
from reports.results.outcome import Outcome
from scenarios import load_scene
from tests.support.kernel import skip_without_kernel
from tests.support.results import read_record

if TYPE_CHECKING:
    from pathlib import Path

SCENE = load_scene("effects/drag")


def job(engine: str, scene: str = "effects/drag") -> Job:
    return Job(load_scene(scene), engine, ENGINES[engine], Setting(AccuracyParameter.RTOL, 1e-10), Role.MAIN)


def test_only_an_engine_that_compiles_has_time_for_it() -> None:
    assert TimeLimit(120.0).allowed_s(job("reference")) == 120.0
    assert TimeLimit(120.0).allowed_s(job("reference-fast")) == 120.0
    assert TimeLimit(120.0).allowed_s(job("heyoka")) == 120.0 + COMPILE_S


def test_the_limit_still_holds_for_the_run_of_an_engine_that_compiles() -> None:
    slow = RunResult(Outcome.PASS, seconds={"build": 200.0, "simulate": 130.0, "read": 1.0})
    assert TimeLimit(120.0).judged(job("reference"), slow) is slow  # its process was ended, or the clock was
    late = TimeLimit(120.0).judged(job("heyoka"), slow)
    assert late.outcome is Outcome.TIMED_OUT
    assert late.reason == "simulate took longer than 120 s"
    built = dataclasses.replace(slow, seconds={"build": 200.0, "simulate": 1.0, "read": 1.0})
    assert TimeLimit(120.0).judged(job("heyoka"), built) is built
    ended = TimeLimit(120.0).judged(job("heyoka"), failure(Outcome.TIMED_OUT, "no result within 720 s"))
    assert "600 s of them for compiling" in ended.reason


@pytest.mark.slow
def test_simulate_of_an_engine_that_compiles_is_ended_at_its_limit_and_not_after_the_time_for_compiling() -> None:
    patient = dataclasses.replace(job("heyoka", "hard/damping_heavy"), setting=Setting(AccuracyParameter.RTOL, 1e-15))
    start = time.monotonic()
    [(_, result)] = run_jobs([patient], time_limit_s=0.5, executor=LocalProcesses(1))
    assert (result.outcome, result.reason) == (Outcome.TIMED_OUT, "simulate took longer than 0.5 s")
    assert time.monotonic() - start < COMPILE_S


def test_the_reference_solution_is_made_by_the_compiled_form_where_it_is_installed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    skip_without_kernel()
    assert {j.engine for j in solution_jobs(SCENE)} <= {"reference-fast", "reference-wide"}
    gone = dataclasses.replace(ENGINES["reference-fast"], rejected="not there")
    monkeypatch.setitem(ENGINES, "reference-fast", gone)
    assert {j.engine for j in solution_jobs(SCENE)} == {"reference"}


@pytest.mark.exhaustive
def test_the_record_says_which_form_made_a_reference_solution(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = load_scene("basics/free_rotation")
    scene = dataclasses.replace(scene, run=dataclasses.replace(scene.run, samples=41))
    for form in ("reference", judging_engine(scene)):
        for module in ("barchain.solutions.judging", "barchain.studies.comparison.suite"):
            monkeypatch.setattr(f"{module}.judging_engine", lambda _, form=form: form)
        compare([scene], ["reference"], tmp_path, overwrite=True)
        record = read_record(tmp_path)
        assert record["scenes"][scene.name]["solution_engine"] == form
        assert {r["engine"] for r in record["runs"] if r["role"] == "solution"} == {form}
        assert f"run for this comparison ({form}, rtol=1e-" in render(tmp_path)[1].read_text()
