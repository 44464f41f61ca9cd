"""A folder on the command line stands for its scenes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from barchain.cli.common.options import scenes_of
from barchain.cli.main import run
from scenarios import scene_names

if TYPE_CHECKING:
    from pathlib import Path

OWN = """\
title = "One bar"
source = "mine"
[orbit]
altitude_m = 500e3
[chain]
bars = 1
mass_kg = 100.0
length_m = 20.0
[run]
orbits = 0.01
samples = 3
"""


@pytest.mark.parametrize(
    ("given", "folders"), [("paper", "paper/"), ("paper/", "paper/"), ("core", ("paper/", "basics/"))]
)
def test_a_folder_or_a_suite_of_barchain_stands_for_its_scenes(given: str, folders: str | tuple[str, ...]) -> None:
    assert scenes_of(given) == [name for name in scene_names() if name.startswith(folders)]
    assert scenes_of("paper/fig05") == ["paper/fig05"]


@pytest.mark.slow
def test_a_folder_of_ones_own_stands_for_its_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("b", "a"):
        (tmp_path / f"{name}.toml").write_text(OWN)
    line = ["compare", str(tmp_path), str(tmp_path / "a.toml"), "--engine", "rebound", "--out", str(tmp_path / "out")]
    assert run(line) == 0
    assert "2 pass" in capsys.readouterr().out


def test_a_folder_without_scenes_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["compare", str(tmp_path), "--engine", "rebound", "--out", str(tmp_path / "out")]) == 2
    assert "a folder without scenes" in capsys.readouterr().err
