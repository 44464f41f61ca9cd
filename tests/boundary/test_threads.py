"""Worker processes compute in one thread each, and the process that started them keeps its environment."""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING

import pytest

from adapters.engine import AccuracyParameter, Setting
from adapters.registry import ENGINES, Registration
from barchain.runs import tasks
from barchain.runs.cases import run_tasks
from barchain.runs.environment import FOLDER, THREADS, marked, scratch_folder
from barchain.runs.executors import ONE_BY_ONE, LocalProcesses
from barchain.runs.job import Job, Role
from barchain.runs.processes import run
from barchain.runs.tasks import PoolGroup, pool_group, run_jobs
from barchain.studies.timing.bench import TimingBench
from reports.results.outcome import Outcome
from scenarios import load_scene
from tests.support.slow import one_in

if TYPE_CHECKING:
    from collections.abc import Iterator

FAULTY = Registration("tests.support.faulty_engines:NeedsOneThread")


def job(role: Role = Role.MAIN, rtol: float = 1e-6) -> Job:
    return Job(load_scene("basics/two_bars_free"), "faulty", FAULTY, Setting(AccuracyParameter.RTOL, rtol), role)


@pytest.fixture(autouse=True)
def environment(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """One variable that the user has set, the others not; the same afterwards."""
    for name in THREADS:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    yield
    assert {name: os.environ.get(name) for name in THREADS} == dict.fromkeys(THREADS) | {"OMP_NUM_THREADS": "3"}


@pytest.mark.parametrize("group", one_in(3, PoolGroup))
def test_a_worker_computes_in_one_thread(group: PoolGroup, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = job(Role.SOLUTION if group is PoolGroup.SOLUTION else Role.MAIN)
    if group is PoolGroup.REGISTERED:
        monkeypatch.setitem(ENGINES, "faulty", FAULTY)
    assert pool_group(asked) is group
    [(_, result)] = run_jobs([asked], time_limit_s=60.0)
    assert result.outcome is Outcome.PASS, result.reason


@pytest.mark.slow
def test_a_worker_that_replaces_another_computes_in_one_thread_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(ENGINES, "faulty", FAULTY)
    monkeypatch.setattr(tasks, "RUNS_PER_WORKER", 1)
    results = [
        r for _, r in run_jobs([job(), job(rtol=1e-7), job(rtol=1e-8)], time_limit_s=60.0, executor=LocalProcesses(1))
    ]
    assert [r.outcome for r in results] == 3 * [Outcome.PASS], results


def test_runs_that_are_timed_compute_in_one_thread() -> None:
    (result,) = run_tasks([TimingBench().run(job(), 60.0)], ONE_BY_ONE)
    assert result.outcome is Outcome.PASS, result.reason


def test_a_command_computes_in_one_thread_and_carries_the_mark_of_its_folder() -> None:
    code = f"import os; print(*(os.environ.get(name) for name in {(*THREADS, FOLDER)!r}))"
    with scratch_folder() as folder:
        done = run([sys.executable, "-c", code], limit_s=30.0, variables=marked(folder))
    assert done.output.split() == [*("1",) * len(THREADS), str(folder)]
    assert not folder.exists()
