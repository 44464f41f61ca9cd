"""Whatever an engine of another package does costs its own row, with a reason, and leaves nothing behind."""

from __future__ import annotations

import contextlib
import os
import time
from pathlib import Path
from typing import TYPE_CHECKING

import psutil
import pytest

from adapters.registry import Registration
from barchain.runs.environment import FOLDER
from barchain.runs.message import TEXT_LENGTH
from barchain.studies.comparison.run import run_comparison
from reports.render import render
from reports.results.outcome import Outcome
from tests.boundary.misbehaving import ENGINES, FINE, TRACE

if TYPE_CHECKING:
    from barchain.studies.comparison.run import ComparisonResult

SCENE = "basics/two_bars_free"
LIMIT_S = 60.0
IMPORTS = {
    "exits": "SystemExit(0)",
    "leaves": "exit code 0",
    "hangs": "ended in the import",
    "raises": "at import",
    "interrupts": "KeyboardInterrupt",
    "missing": "a_library_that_is_not_there",
    "dies": "SIGSEGV",
    "empty": "Engine",
}
QUICK = ("simulate_exits_0", "info_code", "gives_complex", "unsupported_raises", "read_kills_worker")
"""Misbehaviours that the slow tests try; the exhaustive test tries all"""


def compared(names: dict[str, str], folder: Path, limit_s: float = LIMIT_S) -> ComparisonResult:
    registered = {name: Registration(target) for name, target in names.items()}
    return run_comparison([SCENE], out=folder, time_limit_s=limit_s, registered=registered)


def targets(names: object) -> dict[str, str]:
    return {name: f"tests.boundary.misbehaving:{name}" for name in names}


def ours() -> set[int]:
    """Processes that a comparison has left: orphans or below this one, and their mark names a folder that is gone."""
    children = psutil.Process().children(recursive=True)
    below, found = {c.pid for c in children if c.ppid() != os.getpid()}, set()
    for process in psutil.process_iter():
        with contextlib.suppress(psutil.Error):
            folder = process.environ().get(FOLDER)
            if folder and not Path(folder).is_dir() and (process.ppid() == 1 or process.pid in below):
                found.add(process.pid)
    return found


def check(result: ComparisonResult, folder: Path, names: object) -> None:
    """Every engine has a row that is no pass, with a readable reason; the report is written, and nothing else."""
    for name in names:
        assert not result.outcomes[SCENE, name].ok, name
        reasons = result.metrics.query("engine == @name and outcome != 'pass' and outcome != 'reported'").reason
        assert reasons.str.len().max() > 0, name
        assert all(r.isprintable() and len(r) <= TEXT_LENGTH + 200 for r in reasons), (name, list(reasons))
        assert not reasons.str.contains("Traceback").any(), name
    assert all(path.is_file() for path in render(folder))
    assert not TRACE.exists()


@pytest.mark.slow
def test_an_engine_that_exits_dies_or_lies_costs_its_own_row(tmp_path: Path) -> None:
    result = compared(targets([*QUICK, "plain"]), tmp_path)
    check(result, tmp_path, QUICK)
    assert result.outcomes[SCENE, "plain"] is Outcome.PASS
    assert not result.passed


@pytest.mark.exhaustive
def test_a_worker_that_an_engine_has_stopped_is_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("barchain.runs.pool.START_S", 12.0)
    result = compared(targets(["simulate_stops_worker", "plain"]), tmp_path, 8.0)
    assert not result.outcomes[SCENE, "simulate_stops_worker"].ok
    assert result.outcomes[SCENE, "plain"] is Outcome.PASS


@pytest.mark.slow
def test_a_child_goes_where_the_engine_has_killed_its_worker(tmp_path: Path) -> None:
    before = ours()
    compared(targets(["read_kills_worker"]), tmp_path, 8.0)
    time.sleep(0.5)
    assert ours() <= before


@pytest.mark.exhaustive
@pytest.mark.timeout(3600)  # most of 250 engines take their whole limit
def test_every_misbehaviour_costs_its_own_row_and_leaves_no_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert len(ENGINES) >= 100
    monkeypatch.setattr("barchain.runs.asking.QUESTION_S", 4.0)
    monkeypatch.setattr("barchain.runs.pool.START_S", 12.0)
    before = ours()
    result = compared(targets(ENGINES), tmp_path, 8.0)
    check(result, tmp_path, ENGINES)
    time.sleep(1.0)
    assert ours() <= before


@pytest.mark.exhaustive
def test_harmless_engines_pass_whatever_they_start(tmp_path: Path) -> None:
    before = ours()
    result = compared(targets(FINE), tmp_path, 20.0)
    assert {name: result.outcomes[SCENE, name] for name in FINE} == dict.fromkeys(FINE, Outcome.PASS)
    time.sleep(0.5)
    assert ours() <= before
    assert not [p for p in psutil.process_iter(["cmdline"]) if p.info["cmdline"] == ["sleep", "600"]]


@pytest.mark.slow
def test_a_package_that_misbehaves_at_import_costs_its_own_row(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "bad_syntax.py").write_text("def")
    monkeypatch.setattr("barchain.runs.asking.QUESTION_S", 2.0)
    names = {name: f"tests.boundary.bad_imports.{name}:Engine" for name in IMPORTS}
    names |= {"syntax": "bad_syntax:Engine", "nowhere": "there_is_no_such_package:Engine"}
    result = compared(names | targets(["plain"]), tmp_path / "out")
    check(result, tmp_path / "out", names)
    for name, words in (IMPORTS | {"syntax": "SyntaxError", "nowhere": "there_is_no_such_package"}).items():
        reasons = list(result.metrics.query("engine == @name").reason)
        assert any(words in r for r in reasons), (name, reasons)
