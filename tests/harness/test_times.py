"""Times of runs: limits, with one of its own for compiling; without the wait for a processor, and with any other."""

from __future__ import annotations

import dataclasses
import os
import subprocess
import sys
import time
from typing import TYPE_CHECKING

import pytest

from adapters.engine import AccuracyParameter, Setting
from adapters.registry import ENGINES
from barchain.api import compare
from barchain.runs.executors import LocalProcesses
from barchain.runs.job import COMPILE_S, Job, Role, RunResult, TimeLimit, failure
from barchain.runs.phases import Stopwatch, queue_time_s, timed
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
WORK = "while True: pass"


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


def work() -> None:
    """Some 50 ms of arithmetic."""
    sum(k * k % 7 for k in range(500_000))


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="the system can't pin a process")
def test_a_run_beside_others_on_its_processor_takes_the_time_that_it_used() -> None:
    allowed = os.sched_getaffinity(0)
    core = {min(allowed)}
    os.sched_setaffinity(0, core)
    others = [subprocess.Popen([sys.executable, "-c", WORK]) for _ in range(2)]  # they inherit the core
    try:
        time.sleep(0.2)
        used, wall, clock = time.process_time(), time.perf_counter(), Stopwatch()
        for _ in range(4):
            work()
        seconds = clock.seconds()
        used, wall = time.process_time() - used, time.perf_counter() - wall
    finally:
        os.sched_setaffinity(0, allowed)
        for other in others:
            other.kill()
            other.wait()
    assert used <= wall
    assert seconds == pytest.approx(used, rel=0.2)
    if queue_time_s() > 0.0:  # the system tells the wait, and there was one
        assert seconds < 0.7 * wall


def test_a_wait_for_something_else_than_a_processor_counts() -> None:
    clock = Stopwatch()
    time.sleep(0.2)
    assert clock.seconds() >= 0.15


def test_a_failing_call_names_its_phase_and_has_no_time() -> None:
    seconds: dict[str, float] = {}
    with pytest.raises(ZeroDivisionError) as error:
        timed(seconds, "simulate", lambda: 1 / 0)
    assert error.value.__notes__ == ["simulate"]
    assert seconds == {}
