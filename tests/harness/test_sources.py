"""What an earlier comparison left is taken over only from the same code."""

from __future__ import annotations

import os
import sys
from types import ModuleType
from typing import TYPE_CHECKING

import pytest

from adapters.registry import Registration
from barchain.record.sources import digest_of
from barchain.runs.pool import LocalSession
from barchain.studies.comparison.run import run_comparison
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Hashable
    from pathlib import Path

    from barchain.runs.call import Call


SCENE = "basics/two_bars_free"
PLUG_IN = """
from tests.support.faulty_engines import Faulty

class Plugged(Faulty):
    def change(self, seen):
        return seen.replace(reaction_N=+seen.reaction_N)
"""


@pytest.fixture
def plug_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Source of somebody's own engine, in one file."""
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    path = folder / "plugged_in.py"
    path.write_text(PLUG_IN)
    monkeypatch.syspath_prepend(str(folder))
    monkeypatch.setitem(sys.modules, "plugged_in", None)  # put back, which here is: forgotten, after the test
    del sys.modules["plugged_in"]
    return path


@pytest.mark.exhaustive
def test_a_changed_byte_of_a_plug_in_makes_a_comparison_run_it_anew(
    plug_in: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[str] = []
    start = LocalSession.start

    def noted(session: LocalSession, key: Hashable, call: Call) -> None:
        made.append(str(key))
        start(session, key, call)

    monkeypatch.setattr(LocalSession, "start", noted)
    registered = {"plugged": Registration("plugged_in:Plugged")}
    out = tmp_path / "out"
    assert run_comparison([SCENE], out=out, registered=registered).outcomes[SCENE, "plugged"] is Outcome.PASS
    made.clear()
    assert run_comparison([SCENE], out=out, registered=registered, resume=True).passed
    assert not made
    plug_in.write_text(PLUG_IN.replace("+seen", "-seen"))
    again = run_comparison([SCENE], out=out, registered=registered, resume=True)
    assert again.outcomes[SCENE, "plugged"] is Outcome.INCONSISTENT


def test_a_digest_is_of_a_whole_package_and_imports_none_of_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    inner = tmp_path / "somebodys" / "inner"
    inner.mkdir(parents=True)
    for folder in (inner, inner.parent):
        (folder / "__init__.py").write_text("raise RuntimeError('imported')\n")
    compiled = inner / "core.so"
    compiled.write_bytes(b"\x7fELF")
    monkeypatch.syspath_prepend(str(tmp_path))
    seen = [digest_of("somebodys")]
    (inner / "engine.py").write_text("a = 1\n")
    seen.append(digest_of("somebodys"))
    (inner / "engine.py").write_text("a = 2\n")
    seen.append(digest_of("somebodys"))
    os.utime(compiled, ns=(1, 1))
    seen.append(digest_of("somebodys"))
    assert len(set(seen)) == len(seen)
    (inner / "notes.txt").write_text("nothing that runs")
    assert digest_of("somebodys") == seen[-1]


def test_a_digest_of_what_is_not_there_is_that_of_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "__main__", ModuleType("__main__"))  # as where somebody types
    assert digest_of("nobodys_package") == digest_of("__main__") == digest_of()
    (tmp_path / "one_file.py").write_text("a = 1\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    assert digest_of("one_file") != digest_of()
