"""Results of an interrupted night belong to the installation of its start, and a damaged state loses no results."""

from __future__ import annotations

import datetime
import shutil
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from barchain.cli.main import run
from barchain.nightly.errors import HistoryError
from barchain.nightly.figures import dependencies as installed
from barchain.nightly.figures.dependencies import installation_here
from barchain.nightly.figures.figure import NightPart
from barchain.nightly.history.nights import NightStore, last_run, open_store
from barchain.nightly.running import night as running
from barchain.nightly.running.night import run_night
from barchain.nightly.running.plan import load_plan
from barchain.nightly.running.state import SET_ASIDE, read_state
from barchain.runs.processes import Finished
from reports.results.nights import STATE
from tests.nightly.history.synthetic import error, night

if TYPE_CHECKING:
    from collections.abc import Sequence

    from barchain.nightly.running.night import NightEnd
    from barchain.nightly.running.plan import NightPlan

PLAN = """
name = "two"
minutes = 2
[[comparison]]
name = "core"
scenes = ["basics/kepler_circular"]
engines = ["reference"]
[[comparison]]
name = "more"
scenes = ["basics/kepler_elliptic"]
engines = ["reference"]
"""


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results of both parts, made once."""
    folder = tmp_path_factory.mktemp("measured")
    for name, scene in (("core", "basics/kepler_circular"), ("more", "basics/kepler_elliptic")):
        assert (
            run(["-q", "compare", "--engine", "reference", scene, "--workers", "1", "--out", str(folder / name)]) == 0
        )
    return folder


@pytest.fixture(autouse=True)
def made_at_once(measured: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Jobs that copy the results instead of a run."""

    def copied(arguments: Sequence[str], *_: Any, **__: Any) -> Finished:
        out = Path(arguments[arguments.index("--out") + 1])
        shutil.copytree(measured / out.name.removesuffix("-left"), out, dirs_exist_ok=True)
        return Finished(0, 1.0)

    monkeypatch.setattr(running, "run_barchain", copied)


@pytest.fixture
def plan(tmp_path: Path) -> NightPlan:
    (tmp_path / "plan.toml").write_text(PLAN, "utf-8")
    return load_plan(tmp_path / "plan.toml")


def one_night(plan: NightPlan, folder: Path, notes: list[str] | None = None) -> NightEnd:
    """A night that begins with a second of its own: nights of one second with the same content are one night."""
    time.sleep(1.0 - time.time() % 1.0)
    progress = running.NightProgress(note=([] if notes is None else notes).append)
    store = open_store(str(folder / "history"), create=True)
    return run_night(plan, 2.0, store, folder / "nights", progress)


@pytest.fixture
def killed(plan: NightPlan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Folder of a night that was killed after its first part."""
    jobs: list[str] = []
    copied = running.run_barchain

    def second_dies(arguments: Sequence[str], *given: Any) -> Finished:
        jobs.append(arguments[0])
        if len(jobs) > 1:
            raise SystemError("killed")  # nothing after a kill is run
        return copied(arguments, *given)

    with monkeypatch.context() as patched:
        patched.setattr(running, "run_barchain", second_dies)
        with pytest.raises(SystemError):
            one_night(plan, tmp_path)
    (folder,) = (tmp_path / "nights").iterdir()
    return folder


def with_digest(monkeypatch: pytest.MonkeyPatch, name: str, version: str) -> None:
    """Let a part have another version and digest, as an edit or an installation between two calls gives it."""
    real = installed.installed_parts

    def changed(*given: Any) -> tuple[NightPart, ...]:
        return tuple(NightPart(name, version, "other") if p.name == name else p for p in real(*given))

    monkeypatch.setattr(installed, "installed_parts", changed)


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", ["adapter:reference", "library:scipy"])
def test_a_night_under_other_sources_or_libraries_does_not_go_on_and_keeps_the_digests_of_its_start(
    plan: NightPlan, tmp_path: Path, killed: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    started_with = installation_here(["reference"], [])
    with_digest(monkeypatch, name, "0.0.1")
    notes: list[str] = []
    second = one_night(plan, tmp_path, notes)
    assert second.folder != killed
    store = open_store(str(tmp_path / "history"))
    old, new = store.nights()
    assert (old.complete, new.complete) == (False, True)
    assert old.part_named[name] == {part.name: part for part in started_with.parts}[name]
    assert new.part_named[name].digest == "other"
    assert old.commit == started_with.commit
    assert [note for note in notes if "kept as incomplete" in note]


@pytest.mark.exhaustive
@pytest.mark.parametrize("content", ["", '{"plan": "x"}'])
def test_a_damaged_state_is_told_once_and_the_results_beside_it_stay(
    plan: NightPlan, tmp_path: Path, killed: Path, content: str
) -> None:
    (killed / STATE).write_text(content, "utf-8")
    with pytest.raises(ValueError, match=r"."):
        read_state(killed)
    notes: list[str] = []
    one_night(plan, tmp_path, notes)
    (note,) = [each for each in notes if "damaged" in each]
    assert str(killed / STATE) in note
    assert "\n" not in note
    assert (killed / SET_ASIDE).read_text("utf-8") == content
    again: list[str] = []
    one_night(plan, tmp_path, again)
    assert again == []
    assert run(["history", "add", str(killed / "core"), "--history", str(tmp_path / "history")]) == 0
    store = open_store(str(tmp_path / "history"))
    assert sorted(each.complete for each in store.nights()) == [True, True, True]


@pytest.mark.exhaustive
def test_a_clock_that_was_in_the_future_once_stops_no_turns_and_is_told(plan: NightPlan, tmp_path: Path) -> None:
    ahead = datetime.datetime.now(datetime.UTC) + datetime.timedelta(days=5000)
    store = open_store(str(tmp_path / "history"), create=True)
    future = replace(night(error()), started=ahead, plan=plan.identity)
    store.add(future, run=running.NightRun(plan.identity, 2.0, turn=7))
    notes: list[str] = []
    turns = [one_night(plan, tmp_path, notes).run.turn for _ in range(2)]
    assert turns == [8, 9]
    said = f"history: a night starts later than now, e.g. {future.name}; a clock was or is wrong"
    assert notes == [said, said]
    store = open_store(str(tmp_path / "history"))
    found = last_run(store, plan.identity)
    latest = store.nights()[1]
    assert found is not None
    assert found.turn == 9
    assert store.summary("latest") == latest
    assert len(store.prune(keep=1)) == 2
    assert [kept.name for kept in store.nights()] == [latest.name]


@pytest.mark.slow
def test_a_history_that_can_not_be_written_at_the_end_says_where_the_results_are(
    tmp_path: Path, plan: NightPlan, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(*_: Any, **__: Any) -> bool:
        raise HistoryError("history.sqlite: the disk is full; nothing was changed")

    words = ["-q", "nightly", "--plan", str(tmp_path / "plan.toml"), "--out", str(tmp_path / "nights")]
    words += ["--history", str(tmp_path / "history")]
    with monkeypatch.context() as patched:
        patched.setattr(NightStore, "add", full)
        assert run(words) == 2
    (folder,) = (each for each in (tmp_path / "nights").iterdir() if each.is_dir())
    said = capsys.readouterr().err.splitlines()[-1]
    assert said.endswith(f"nothing was changed; the night's results stay in {folder}, and the next call adds them")
    with_digest(monkeypatch, "library:scipy", "0.0.1")  # also if the night does not go on then, it is whole
    one_night(plan, tmp_path)
    store = open_store(str(tmp_path / "history"))
    assert [(each.complete, each.figures > 20) for each in store.nights()] == [(True, True)] * 2


@pytest.mark.slow
def test_a_disk_that_is_full_during_a_night_says_that_the_next_call_goes_on(
    tmp_path: Path, plan: NightPlan, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: Any, **__: Any) -> Finished:
        raise OSError(28, "No space left on device", "logs/core.txt")

    said = r"logs/core.txt: No space left on device; results so far stay in .*, and the next call goes on"
    with monkeypatch.context() as patched:
        patched.setattr(running, "run_barchain", full)
        with pytest.raises(HistoryError, match=said):
            one_night(plan, tmp_path)
    assert one_night(plan, tmp_path).run.complete
