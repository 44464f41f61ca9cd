"""Nights as they run: kept whatever happens, resumed, and what was left goes first."""

from __future__ import annotations

import dataclasses
import os
import random
import signal
import subprocess
import sys
import time
from typing import TYPE_CHECKING

import pytest

from barchain.cli.main import run
from barchain.nightly.history.judging import judge
from barchain.nightly.history.nights import open_store
from barchain.nightly.running import night as running
from barchain.nightly.running.night import run_night
from barchain.nightly.running.plan import load_plan
from barchain.nightly.running.state import read_state, write_state
from reports.results.nights.document import NightRun, PartResult, PartState
from tests.support.nightly import read_nightly

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.nightly.running.jobs import NightJob
    from barchain.nightly.running.night import NightEnd
    from barchain.nightly.running.plan import NightPlan

PLAN = """
name = "small"
minutes = 2
[[comparison]]
name = "core"
scenes = ["basics/kepler_circular", "basics/kepler_elliptic"]
engines = ["reference"]
"""

SCENES = ("basics/kepler_circular", "basics/kepler_elliptic")


@pytest.fixture
def plan(tmp_path: Path) -> NightPlan:
    (tmp_path / "plan.toml").write_text(PLAN, "utf-8")
    return load_plan(tmp_path / "plan.toml")


def one_night(plan: NightPlan, folder: Path, url: str | None = None) -> NightEnd:
    store = open_store(url or str(folder / "history"), create=True)
    return run_night(plan, 2.0, store, folder / "nights")


def test_scenes_that_a_slow_night_before_left_no_room_for_are_tried_in_the_time_that_is_left(
    plan: NightPlan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    slow = NightRun(plan.identity, 2.0, (PartResult("core", PartState.DONE, 110.0, 100.0, done=1),))
    taken: list[tuple[str, tuple[str, ...]]] = []

    def quick(night: object, job: NightJob, own: NightJob, time_s: float) -> PartResult:
        taken.append((job.name, own.scenes))
        return PartResult(job.part, PartState.DONE, time_s, 1.0, done=len(own.scenes))

    monkeypatch.setattr(running, "last_run", lambda *_: slow)
    monkeypatch.setattr(running, "run_job", quick)
    ended = one_night(plan, tmp_path)
    assert taken == [("core", SCENES[:1]), ("core-more", SCENES[1:])]
    (part,) = ended.run.parts
    assert (part.state, part.done, part.left) == (PartState.DONE, 2, ())


@pytest.mark.slow
def test_two_nights_of_the_same_code_agree_in_every_bit(tmp_path: Path) -> None:
    (tmp_path / "plan.toml").write_text(PLAN.replace(f', "{SCENES[1]}"', ""), "utf-8")
    plan = load_plan(tmp_path / "plan.toml")
    first, second = one_night(plan, tmp_path), one_night(plan, tmp_path)
    assert first.run.complete
    assert (first.run.turn, second.run.turn) == (0, 1)
    assert second.run.parts[0].done == 1
    store = open_store(str(tmp_path / "history"))
    judged = judge(store, second.name)
    assert store.summary(first.name).run == first.run
    assert judged.tonight == ()
    assert judged.judged > 10


@pytest.mark.exhaustive
def test_a_kill_after_a_night_is_in_the_history_does_not_double_it(plan: NightPlan, tmp_path: Path) -> None:
    first = one_night(plan, tmp_path)
    state = read_state(first.folder)
    assert state is not None
    for changed in (
        dataclasses.replace(state, finished=False),
        dataclasses.replace(state, finished=False, code="other"),
    ):
        write_state(first.folder, changed)
        one_night(plan, tmp_path)
    store = open_store(str(tmp_path / "history"))
    nights = store.nights()
    assert [night.complete for night in nights] == [True, True]  # the same night, and the new one of other code
    assert nights[0].name == first.name


@pytest.mark.exhaustive
def test_a_part_or_a_scene_that_can_not_be_read_costs_itself_alone_and_the_night_ends_as_bad_input(
    tmp_path: Path,
) -> None:
    text = PLAN.replace('"basics/kepler_elliptic"', '"broken.toml"')
    text += '[[comparison]]\nname = "broken"\nscenes = ["broken.toml"]\n'
    (tmp_path / "plan.toml").write_text(text, "utf-8")
    (tmp_path / "broken.toml").write_text("nothing = 1\n", "utf-8")
    words = ["-q", "nightly", "--plan", str(tmp_path / "plan.toml"), "--out", str(tmp_path / "nights")]
    assert run(words) == 2
    facts = read_nightly(tmp_path / "nights" / "nightly.json")
    assert facts.verdicts == {"pass": 1}
    assert facts.run is not None
    core, broken = facts.run.parts
    assert (core.state, broken.state) == (PartState.DONE, PartState.FAILED)
    assert "broken.toml" in core.missing
    assert "broken.toml" in broken.reason


def test_a_job_without_time_is_left_and_named(plan: NightPlan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(running, "working_time_s", lambda _: 1.0)
    ended = one_night(plan, tmp_path)
    assert ended.run.parts[0].reason == "no time was left"
    store = open_store(str(tmp_path / "history"))
    (night,) = store.nights()
    assert (night.complete, night.figures) == (False, 0)


COMMAND = [sys.executable, "-m", "barchain", "-q", "nightly", "--fail-on", "never"]


def started(folder: Path, url: str) -> subprocess.Popen[bytes]:
    line = [*COMMAND, "--plan", str(folder / "plan.toml"), "--history", url, "--out", str(folder / "nights")]
    return subprocess.Popen(line, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


@pytest.mark.exhaustive
def test_nothing_is_lost_or_doubled_by_ten_kills_at_random_instants(plan: NightPlan, tmp_path: Path) -> None:
    url, draw = str(tmp_path / "history"), random.Random(7)
    before: set[str] = set()
    for _ in range(10):
        process = started(tmp_path, url)
        time.sleep(draw.uniform(0.5, 9.0))
        os.kill(process.pid, signal.SIGKILL)
        process.communicate()
        if (tmp_path / "history").exists():
            store = open_store(url, create=True)
            names = [night.name for night in store.nights() if night.complete]
            assert before <= set(names)
            assert len({night.started for night in store.nights()}) == len(store.nights())
            before = set(names)
    process = started(tmp_path, url)
    told = process.communicate(timeout=120)[1].decode().splitlines()
    assert [line for line in told if not line.startswith("history: begins in ")] == []  # all kills may come before it
    assert process.returncode == 0
    store = open_store(url)
    assert store.nights()[-1].complete
    assert judge(store).tonight == ()
    assert plan.identity


@pytest.mark.exhaustive
def test_two_nights_at_once_are_two_nights(plan: NightPlan, tmp_path: Path, url: str) -> None:
    both = [started(tmp_path, url) for _ in range(2)]
    told = [line for process in both for line in process.communicate(timeout=200)[1].decode().splitlines()]
    assert [line for line in told if not line.startswith("history: begins in ")] == []
    store = open_store(url)
    nights = store.nights()
    assert [night.complete for night in nights] == [True, True]
    assert len({night.name for night in nights}) == 2
    assert plan.identity
