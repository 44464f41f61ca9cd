"""A comparison and a study that are killed at any instant go on to the tables of an uninterrupted run."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from typing import TYPE_CHECKING

import pandas as pd
import pytest

if TYPE_CHECKING:
    from pathlib import Path

COMMANDS = {
    "comparison": ["compare", "basics/kepler_circular", "--engine", "reference", "--engine", "rebound"],
    "stability": ["stability", "hard/vertical_fall", "--engine", "rebound"],
}
TABLES = {
    "comparison": ("metrics.csv", "record.json"),
    "stability": ("stability/outcomes.csv", "stability/record.json"),
}


def started(name: str, out: Path, *options: str) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "barchain", "-q", *COMMANDS[name], "--workers", "1", "--out", str(out), *options]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True)


def ended(process: subprocess.Popen[bytes]) -> int:
    said, _ = process.communicate()
    assert b"Traceback" not in said, said.decode()
    return process.returncode


def results(name: str, out: Path) -> tuple[pd.DataFrame, list[tuple[str, str]]]:
    """Table of verdicts, and every recorded run with its outcome."""
    table, record = (out / place for place in TABLES[name])
    runs = json.loads(record.read_text())["runs"]
    return pd.read_csv(table), sorted((run["key"], run["outcome"]) for run in runs)


def killed_and_gone_on(name: str, folder: Path, kills: int) -> None:
    whole, cut = folder / "whole", folder / "cut"
    start = time.monotonic()
    code = ended(started(name, whole))
    span_s, instants = time.monotonic() - start, random.Random(7)
    passed: set[str] = set()
    for _ in range(kills):
        process = started(name, cut, "--resume")
        time.sleep(instants.uniform(0.0, span_s))
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        record = cut / TABLES[name][1]
        if record.is_file():
            found = json.loads(record.read_text())
            kept = {run["key"] for run in (*found.get("carried", []), *found["runs"]) if run["outcome"] == "pass"}
            assert passed <= kept  # nothing recorded is forgotten
            passed = kept
    assert ended(started(name, cut, "--resume")) == code
    (expected, runs), (table, again) = results(name, whole), results(name, cut)
    pd.testing.assert_frame_equal(table, expected)
    assert again == runs
    assert not list(cut.rglob("*.part"))


@pytest.mark.parametrize("name", COMMANDS)
def test_a_killed_run_goes_on_to_the_same_tables(name: str, tmp_path: Path) -> None:
    killed_and_gone_on(name, tmp_path, 2)


@pytest.mark.slow
@pytest.mark.timeout(0)
@pytest.mark.parametrize("name", COMMANDS)
def test_a_run_killed_thirty_times_goes_on_to_the_same_tables(name: str, tmp_path: Path) -> None:
    killed_and_gone_on(name, tmp_path, 30)
