"""Kills, writers side by side and a full disk: no night is lost, doubled or halved, and one line says why."""

from __future__ import annotations

import errno
import os
import random
import subprocess
import sys
import time
from typing import TYPE_CHECKING

import pytest

from barchain.cli.main import run
from barchain.nightly.history.judging import judge
from barchain.nightly.history.nights import NightStore, export_parquet, open_store
from reports.results.writing import DigestedFile
from tests.nightly.history.synthetic import error, large_night, night
from tests.support.nightly import read_nightly
from tests.support.slow import one_in

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

FIGURES = 100
WRITER = """
import sys
from barchain.nightly.history.nights import open_store
from tests.nightly.history.synthetic import large_night
nights = [large_night(int(k), int(sys.argv[2])) for k in sys.argv[3:]]
print("ready", flush=True)
sys.stdin.readline()
store = open_store(sys.argv[1], create=True)
for night in nights:
    store.add(night)
    print(night.name, flush=True)
"""


def writer(url: str, numbers: Iterable[int]) -> subprocess.Popen[str]:
    """Process that makes some nights, and adds them once it is told to."""
    line = [sys.executable, "-c", WRITER, url, str(FIGURES), *map(str, numbers)]
    process = subprocess.Popen(line, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    return process


def whole(store: NightStore, numbers: range) -> None:
    """Check that each night there is whole, and stands once."""
    expected = {each.name: each for each in (large_night(k, FIGURES) for k in numbers)}
    names = [n.name for n in store.nights()]
    assert len(set(names)) == len(names)
    for name in names:
        assert store.night(name).figures == expected[name].figures


def test_two_processes_that_add_at_once_lose_and_double_nothing(url: str) -> None:
    writers = [writer(url, numbers) for numbers in (range(4), range(2, 6))]  # two of the nights are the same
    for process in writers:
        assert process.stdin is not None
        process.stdin.write("begin\n")
        process.stdin.flush()
    for process in writers:
        process.communicate(timeout=60)
    assert [process.returncode for process in writers] == [0, 0]
    store = open_store(url)
    assert len(store.nights()) == 6
    whole(store, range(6))


@pytest.mark.parametrize("seed", one_in(10, range(10)))
def test_a_kill_at_any_instant_leaves_whole_nights_and_every_night_that_was_confirmed(url: str, seed: int) -> None:
    process = writer(url, range(8))
    assert process.stdin is not None
    process.stdin.write("begin\n")
    process.stdin.flush()
    time.sleep(random.Random(seed).uniform(0.0, 0.4))
    process.kill()
    said = process.communicate()[0].split()
    store = open_store(url, create=True)
    assert set(said) <= {n.name for n in store.nights()}
    for k in range(8):
        store.add(large_night(k, FIGURES))
    assert len(store.nights()) == 8
    whole(store, range(8))
    assert store.left_out() == {}


@pytest.mark.parametrize("damage", ["flipped", "cut", "gone", "a record's number"])
def test_a_damaged_night_is_named_and_costs_itself_alone(
    url: str, tmp_path: Path, damage: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also where it was sound when later nights were judged."""
    store = open_store(url, create=True)
    for k, value in enumerate((1e-5, 9e-5, 2e-5, 2e-5)):
        store.add(night(error(value), number=k))
        judge(store)
    names = [one.name for one in store.nights()]
    path = tmp_path / "history" / names[1] / "figures.parquet"
    content = path.read_bytes()
    path.write_bytes(content[:40] + bytes([content[40] ^ 1]) + content[41:] if damage == "flipped" else content[:-9])
    if damage == "gone":
        path.unlink()
    if damage == "a record's number":
        path.write_bytes(content)
        record = path.with_name("record.json")
        text = record.read_text("utf-8")
        record.write_text(text.replace('"duration_s": 6', '"duration_s": 7'), "utf-8")
        assert record.read_text("utf-8") != text
    out = tmp_path / "out"
    assert run(["history", "report", "--history", url, "--out", str(out)]) == 1
    facts = read_nightly(out / "nightly.json")
    assert list(facts.left_out) == [names[1]]
    assert [(c.since, c.factor) for c in facts.standing] == [(names[2], pytest.approx(2.0))]
    told = next(line for line in capsys.readouterr().out.splitlines() if f"left out: {names[1]}: it " in line)
    assert ("record.json" if damage == "a record's number" else "figures.parquet") in told
    assert names[1] in (out / "nightly.html").read_text("utf-8")
    assert names[1] in (out / "summary.md").read_text("utf-8")
    assert run(["history", "list", "--history", url]) == 0
    shown = capsys.readouterr()
    assert names[1] in shown.err
    assert names[1] not in shown.out


FILLER = """
import resource, signal, sys
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
from barchain.nightly.history.nights import open_store
from barchain.nightly.errors import HistoryError
from tests.nightly.history.synthetic import large_night
try:
    open_store(sys.argv[1], create=True).add(large_night(1, 5000))
except HistoryError as error:
    print(error)
    sys.exit(2)
"""


def test_a_file_that_can_not_grow_is_one_line_and_changes_nothing(url: str) -> None:
    store = open_store(url, create=True)
    store.add(night(error()))
    made = subprocess.run([sys.executable, "-c", FILLER, url], capture_output=True, text=True, check=False)
    assert made.returncode == 2, made.stderr
    assert made.stdout.count("\n") == 1
    assert "the disk is full" in made.stdout
    assert [n.name for n in store.nights()] == [night(error()).name]
    assert store.add(large_night(1, 5000))


def test_a_table_that_can_not_be_exported_whole_leaves_the_earlier_file(
    store: NightStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "all.parquet"
    path.write_bytes(b"earlier")
    for k in range(3):
        store.add(large_night(k, 1000))
    monkeypatch.setattr(DigestedFile, "write", full)
    with pytest.raises(OSError, match="No space left"):
        export_parquet(store, path)
    assert path.read_bytes() == b"earlier"
    assert list(tmp_path.glob("*.part")) == []


def full(*_: object) -> int:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
