"""Damaged files that a person gives: results to judge, files of engines, and scenes, each read or rejected."""

from __future__ import annotations

import random
from typing import TYPE_CHECKING

import pytest

import barchain
from tests.damage.mutations import damaged_bytes, damaged_table
from tests.scenarios.mutations import SOURCES, of_lines, of_values, source
from tests.support.command_ends import fault_of

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

LIMIT_S = 60.0
SCENE = "basics/two_bars_free"
ACCURACIES = (["--rtol", "1e-9"], [], ["--digits", "6"])
ENTRIES = """
[[engine]]
name = "mine"
command = "true {request} {samples} {result}"
title = "My program"
effects = ["gravity.none", "gravity.point", "drag"]
observables = ["com", "attitude", "rate"]
coordinates = "absolute"
order = 4
steps_per_orbit = [100.0, 200.0]
default = 100.0
joints_in_place = true
noise = { attitude = 1e-9 }
files = ["program.py"]
licence = "MIT"
homepage = "https://example.org"
"""
READING = (
    "validate {}",
    "scenes show {}",
    "scenes show {} --json",
    "simulate {} --engine reference --time-limit 5 --overwrite --out run.csv",
)
LISTING = (
    "engines",
    "engines --json",
    "engines --engines engines.toml",
    "simulate basics/libration --engine mine --overwrite --out run.csv",
)


def sampled(quick: range, count: int) -> list[object]:
    """Numbers of damages: some that every test run tries, and all the others."""
    rest = [k for k in range(count) if k not in quick]
    return [pytest.param(quick, id="some"), pytest.param(rest, marks=pytest.mark.exhaustive, id="rest")]


@pytest.fixture(scope="module")
def tables() -> list[bytes]:
    """Right results: mostly too short for mistakes to be sought, and a longer one."""
    frame = barchain.simulate(SCENE, "reference", rtol=1e-10).to_frame()
    frame = frame[[n for n in frame if not n.startswith(("gap", "com_residual", "position"))]]
    return [frame.iloc[::every].to_csv(index=False).encode() for every in (100, 100, 100, 100, 70, 70, 70, 70, 70, 25)]


@pytest.mark.parametrize("numbers", sampled(range(20), 1000))  # of 14 and 19 enough is left to be judged
def test_a_damaged_result_is_judged_or_rejected(
    numbers: Sequence[int], tables: list[bytes], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found, path = [], tmp_path / "run.csv"
    for k in numbers:
        draw = random.Random(k)
        path.write_bytes(damaged_table(tables[k % len(tables)], draw))
        fault = fault_of(["judge", SCENE, str(path), *draw.choice(ACCURACIES)], capsys, LIMIT_S)
        found += [f"{k}: {fault}"] if fault else []
    assert not found, "\n".join(found)


def damaged_text(text: str, draw: random.Random) -> bytes:
    """TOML with one damage: of a value, a line, or bytes."""
    kind = draw.choice((of_values, of_values, of_lines, None))
    made = list(kind(text)) if kind else []
    return draw.choice(made).encode("utf-8", "surrogatepass") if made else damaged_bytes(text.encode(), draw)


@pytest.mark.parametrize("numbers", sampled(range(10), 200))
def test_a_damaged_file_of_engines_is_read_or_rejected(
    numbers: Sequence[int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    found = []
    for k in numbers:
        draw = random.Random(k)
        (tmp_path / "engines.toml").write_bytes(damaged_text(ENTRIES, draw))
        line = draw.choice(LISTING)
        fault = fault_of(line.split(), capsys, LIMIT_S)
        found += [f"{k}: {line}: {fault}"] if fault else []
    assert not found, "\n".join(found)


@pytest.mark.parametrize("numbers", sampled(range(10), 200))
def test_a_damaged_scene_is_read_or_rejected(
    numbers: Sequence[int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    found, path = [], tmp_path / "scene.toml"
    for k in numbers:
        draw = random.Random(k)
        path.write_bytes(damaged_text(source(SOURCES[k % len(SOURCES)]), draw))
        line = draw.choice(READING).format(path).split()
        fault = fault_of(line, capsys, LIMIT_S)
        found += [f"{k}: {line}: {fault}"] if fault else []
    assert not found, "\n".join(found)
