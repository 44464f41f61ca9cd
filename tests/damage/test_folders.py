"""Damaged histories of nights and result folders: every command that reads them ends in short lines."""

from __future__ import annotations

import os
import random
import shutil
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

from barchain.cli.common.exit_codes import ExitCode
from barchain.cli.main import run
from barchain.nightly.history.acceptances import accept
from barchain.nightly.history.judging import judge
from barchain.nightly.history.news import ATTRIBUTED, keep_judgement
from barchain.nightly.history.nights import open_store
from tests.damage.mutations import damaged_bytes, damaged_json
from tests.nightly.history.synthetic import large_night
from tests.storage.small_plans import SMALL
from tests.support.command_ends import fault_of

if TYPE_CHECKING:
    from pathlib import Path

LIMIT_S = 60.0
NIGHTS = 4
RESUMED = 10
READING = (
    ["list"], ["list", "--json"], ["show", "latest"], ["show", "latest", "--json"], ["changes", "--all"], ["accepted"],
    ["series", "*"], ["tell"], ["report", "--out", "{out}"], ["export", "--parquet", "{out}.parquet"],
    ["accept", "*", "--reason", "x"], ["withdraw", "*"], ["prune", "--keep-nights", "1"],
)  # fmt: skip
"""Commands on a history; the later ones change it"""
OTHER = (b"[]", b"[" * 100_000, b"\xff", b"accepted = 1")


@pytest.fixture(scope="module")
def nights(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """History of some nights with a change, an acceptance and an attribution."""
    folder = tmp_path_factory.mktemp("sound") / "nights"
    store = open_store(str(folder), create=True)
    for k in range(NIGHTS):
        store.add(replace(large_night(k, 14, shift=float(k == NIGHTS - 1)), complete=True))
        judged = judge(store)
        keep_judgement(store, judged)
    change = next(change for change in judged.tonight if not change.irreproducible)
    accept(store, [change], "me", "on purpose")
    store.place.write(f"{ATTRIBUTED}/{change.id}.json", b'{"words": "confirmed"}')
    return folder


def damage(path: Path, draw: random.Random) -> None:
    """Damage a file: its content, or what it is."""
    kind = draw.randrange(12)
    whole = path.read_bytes()
    if kind > 2:
        make = damaged_json if path.suffix == ".json" and kind > 6 else damaged_bytes
        path.write_bytes(make(whole, draw))
        return
    path.unlink()
    if kind == 0:
        path.mkdir()
    elif kind == 1:
        path.symlink_to(draw.choice((path.name, "nowhere", "..", "/dev/zero")))
    else:
        os.mkfifo(path)


def faults_of_a_history(sound: Path, folder: Path, number: int, capsys: pytest.CaptureFixture[str]) -> list[str]:
    """Faults of all commands on a history with a damaged file."""
    draw = random.Random(number)
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(sound, folder / "nights")
    path = draw.choice(sorted(p for p in (folder / "nights").rglob("*") if p.is_file()))
    damage(path, draw)
    found = []
    for line in READING:
        words = [word.format(out=folder / "out") for word in line]
        fault = fault_of(["history", *words, "--history", str(folder / "nights")], capsys, LIMIT_S)
        found += [f"{number}: {path.relative_to(folder)}: {' '.join(line)}: {fault}"] if fault else []
    return found


@pytest.mark.parametrize("content", OTHER)
@pytest.mark.parametrize("name", ["accepted.toml", "attributed"])
def test_a_file_of_a_history_with_something_else_is_named_in_one_line(
    name: str, content: bytes, nights: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(nights, tmp_path / "nights")
    (path,) = sorted(p for p in (tmp_path / "nights").rglob("*") if name in {p.name, p.parent.name})[-1:]
    path.write_bytes(content)
    capsys.readouterr()
    code = run(["history", "report", "--out", str(tmp_path / "out"), "--history", str(tmp_path / "nights")])
    error = capsys.readouterr().err
    assert code == ExitCode.BAD_INPUT
    assert error.count("\n") == 1
    assert path.name in error


@pytest.mark.parametrize("numbers", [range(2), pytest.param(range(2, 100), marks=pytest.mark.exhaustive)])
def test_a_damaged_history_ends_no_command_in_a_traceback(
    numbers: range, nights: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = [fault for k in numbers for fault in faults_of_a_history(nights, tmp_path / "d", k, capsys)]
    assert not found, "\n".join(found)


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Result folder of a small comparison."""
    folder = tmp_path_factory.mktemp("compared") / "results"
    assert run([*SMALL["comparison"].command.split(), "--out", str(folder)]) == ExitCode.OK
    return folder


def faults_of_results(sound: Path, folder: Path, number: int, capsys: pytest.CaptureFixture[str]) -> list[str]:
    """Faults of all commands on a result folder with a damaged file; of each tenth it is resumed, too."""
    draw = random.Random(number)
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(sound, folder)
    path = draw.choice(sorted(p for p in folder.rglob("*") if p.is_file()))
    damage(path, draw)
    lines = [["show", str(folder)], ["show", str(folder), str(sound)], ["report", str(folder)]]
    lines += [] if number % RESUMED else [[*SMALL["comparison"].command.split(), "--out", str(folder), "--resume"]]
    faults = ((line, fault_of(line, capsys, LIMIT_S)) for line in lines)
    return [f"{number}: {path.relative_to(folder)}: {line[0]}: {fault}" for line, fault in faults if fault]


@pytest.mark.parametrize("numbers", [range(1, 4), pytest.param(range(4, 156), marks=pytest.mark.exhaustive)])
def test_a_damaged_result_folder_ends_no_command_in_a_traceback(
    numbers: range, results: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = [fault for k in numbers for fault in faults_of_results(results, tmp_path / "d", k, capsys)]
    assert not found, "\n".join(found)
