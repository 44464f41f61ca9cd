"""A program in C in two nights, between which somebody changed it: the change is told, and its file suspected."""

from __future__ import annotations

import shutil
import subprocess
from typing import TYPE_CHECKING

import pytest

from adapters.command.entries import FILES
from barchain.cli.main import run
from barchain.engine.new_program import LANGUAGES, write_program
from reports.tables.nights.facts import read_nightly

if TYPE_CHECKING:
    from pathlib import Path

PLAN = """
name = "mine"
minutes = 2
[[comparison]]
name = "mine"
scenes = ["basics/two_bars_free"]
engines = ["mine"]
"""
C = LANGUAGES["c"]
RIGHT, MISTAKEN = "half[j] = 0.5 * length[j]", "half[j] = 0.501 * length[j]"


def built(folder: Path) -> None:
    subprocess.run(C.build, shell=True, cwd=folder, check=True)


@pytest.mark.exhaustive
@pytest.mark.skipif(shutil.which(C.build.split()[0]) is None, reason="no C compiler is here")
def test_a_changed_program_is_told_by_a_night_with_its_files_as_the_suspect(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "mine"
    write_program("mine", "c", folder)
    built(folder)
    monkeypatch.setenv(FILES, str(folder / "engines.toml"))
    (tmp_path / "plan.toml").write_text(PLAN, "utf-8")
    nights = tmp_path / "nights"
    words = ["-q", "nightly", "--plan", str(tmp_path / "plan.toml"), "--out", str(nights)]
    assert run(words) == 0
    text = (folder / C.source).read_text("utf-8")
    assert RIGHT in text
    (folder / C.source).write_text(text.replace(RIGHT, MISTAKEN), "utf-8")
    built(folder)
    assert run(words) == 1
    found = read_nightly(nights / "nightly.json")
    assert found.verdicts == {"inconsistent": 1}
    worse = [change for change in found.changes if change.engine == "mine"]
    assert worse
    for change in worse:
        assert [suspect.name for suspect in change.suspects] == ["program:mine (its entry, engine)"], change.words
