"""A program in C in two nights, between which somebody changed it: the change is told, and its file suspected."""

from __future__ import annotations

import shutil
import subprocess
from typing import TYPE_CHECKING

import pytest

from adapters.command.entries import FILES
from barchain.cli.main import run
from barchain.engine.new_program import LANGUAGES, write_program
from barchain.nightly.figures.dependencies import capture, installed_parts
from tests.support.nightly import read_nightly

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.nightly.figures.figure import NightPart

PLAN = """
name = "mine"
minutes = 60
[[comparison]]
name = "mine"
scenes = ["basics/two_bars_free"]
engines = ["mine"]
time_limit_s = 900
"""
"""A night ends with its part: limits that a busy machine reaches would make the verdict timed_out, or leave the part"""
C = LANGUAGES["c"]
RIGHT, MISTAKEN = "half[j] = 0.5 * length[j]", "half[j] = 0.501 * length[j]"


def built(folder: Path) -> None:
    subprocess.run(C.build, shell=True, cwd=folder, check=True)


ENTRY = """
[[engine]]
name = "mine"
command = "engine {{request}} {{samples}}"
effects = ["gravity.point"]
order = 4
steps_per_orbit = [500]
version = {version}
commit = {commit}
"""


def state_of(folder: Path, version: str, commit: str = '""') -> NightPart:
    """Part of a program whose entry states a version and a commit."""
    (folder / "engines.toml").write_text(ENTRY.format(version=version, commit=commit), "utf-8")
    parts = installed_parts(["mine"], [], capture())
    return next(part for part in parts if part.name.startswith("program:mine"))


@pytest.mark.parametrize(
    ("version", "commit", "words"),
    [
        ('"1.4"', '""', "1.4"),
        ("\"sh -c 'echo 1.5; echo more'\"", '"0123abc"', "1.5 (0123abc)"),
        ("\"sh -c 'echo mine 1.7'\"", '""', "1.7"),
        ('"version.sh"', '""', "2.0 from a file"),
        ('"no-such-program --version"', '""', ""),
        ("\"sh -c 'exit 1'\"", '""', ""),
    ],
)
def test_a_program_has_the_version_that_its_entry_states(
    version: str, commit: str, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(FILES, str(tmp_path / "engines.toml"))
    for name, text in (("engine", "#!/bin/sh\n"), ("version.sh", "#!/bin/sh\necho 2.0 from a file\n")):
        (tmp_path / name).write_text(text, "utf-8")
        (tmp_path / name).chmod(0o755)
    assert state_of(tmp_path, version, commit).version == words


def test_a_version_names_a_state_and_decides_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(FILES, str(tmp_path / "engines.toml"))
    (tmp_path / "engine").write_text("one", "utf-8")
    (tmp_path / "engine").chmod(0o755)
    first = state_of(tmp_path, '"1.0"')
    assert not first.differs(state_of(tmp_path, '"1.1.0"'))
    (tmp_path / "engine").write_text("two", "utf-8")
    assert first.differs(state_of(tmp_path, '"1.1"'))


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
    assert read_nightly(nights / "nightly.json").verdicts == {"pass": 1}
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
