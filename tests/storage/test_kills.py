"""A comparison or a study that is killed at any instant ends in the tables of an uninterrupted run."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
import pytest

from tests.storage.small_plans import SMALL, SmallPlan
from tests.support.results import answers_folder, read_record, record_file

GONE_S = 10.0
"""Time after a kill in which every process and every temporary file must be gone"""
MARK = "BARCHAIN_KILLED_RUN"
VICTIMS = ("parent", "worker", "group")


def started(command: str, out: Path, temporary: Path, *options: str) -> subprocess.Popen[bytes]:
    temporary.mkdir(exist_ok=True)
    line = [sys.executable, "-m", "barchain", "-q", *command.split(), "--out", str(out), *options]
    environment = os.environ | {"TMPDIR": str(temporary), MARK: str(temporary)}
    return subprocess.Popen(
        line, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True, env=environment
    )


def ended(process: subprocess.Popen[bytes]) -> int:
    _, said = process.communicate()
    assert b"Traceback" not in said, said.decode()
    return process.returncode


def processes_of(temporary: Path) -> dict[int, str]:
    """Processes of a run, its parent among them, with their command lines."""
    found, wanted = {}, f"{MARK}={temporary}".encode()
    for place in Path("/proc").glob("[0-9]*"):
        try:
            if wanted in (place / "environ").read_bytes().split(b"\0"):
                found[int(place.name)] = (place / "cmdline").read_bytes().replace(b"\0", b" ").decode()
        except OSError:  # ended meanwhile, or somebody else's
            continue
    return found


def kill(victim: str, process: subprocess.Popen[bytes], temporary: Path, chance: random.Random) -> None:
    if victim == "group":
        os.killpg(process.pid, signal.SIGKILL)
    elif victim == "parent":
        process.kill()
    else:
        workers = sorted(set(processes_of(temporary)) - {process.pid})
        if workers:
            os.kill(chance.choice(workers), signal.SIGKILL)


def left_over(temporary: Path) -> list[str]:
    """Processes and files of a run that are still there after the time allowed."""
    until, found = time.monotonic() + GONE_S, [""]
    while found and time.monotonic() < until:
        time.sleep(0.2)
        found = [*processes_of(temporary).values(), *map(str, temporary.iterdir())]
    return found


def table(small: SmallPlan, out: Path) -> pd.DataFrame:
    wanted = small.read(out)
    assert not wanted.duplicated().any()
    return wanted.sort_values(list(wanted.columns), ignore_index=True)


def runs_kept(small: SmallPlan, out: Path) -> set[str]:
    """Names of the kept answers; the record, if there is one, is whole."""
    if record_file(out, small.study).is_file():
        read_record(out, small.study)
    return {file.name for file in answers_folder(out, small.study).glob("*") if file.suffix != ".part"}


@dataclass(frozen=True)
class Uninterrupted:
    """A run that was not killed."""

    table: pd.DataFrame
    code: int
    span_s: float


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Uninterrupted]:
    """Uninterrupted runs, made as they are asked for."""
    del tmp_path_factory
    return {}


def uninterrupted(name: str, known: dict[str, Uninterrupted], folder: Path) -> Uninterrupted:
    if name not in known:
        start, out = time.monotonic(), folder / "whole"
        code = ended(started(SMALL[name].command, out, folder / "tmp-whole"))
        assert not left_over(folder / "tmp-whole")
        known[name] = Uninterrupted(table(SMALL[name], out), code, time.monotonic() - start)
    return known[name]


def check_kill_and_going_on(name: str, number: int, known: dict[str, Uninterrupted], folder: Path) -> None:
    small, chance, expected = SMALL[name], random.Random(number), uninterrupted(name, known, folder)
    victim, out, temporary = VICTIMS[number % len(VICTIMS)], folder / "cut", folder / "tmp-cut"
    process = started(small.command, out, temporary)
    time.sleep(chance.uniform(0.0, expected.span_s))
    kill(victim, process, temporary, chance)
    process.communicate()
    assert not left_over(temporary), victim
    kept, there = runs_kept(small, out), out.is_dir() and any(p.name != ".barchain.lock" for p in out.iterdir())
    assert ended(started(small.command, out, folder / "tmp-again")) == (2 if there else expected.code)
    assert ended(started(small.command, out, folder / "tmp-on", "--resume")) == expected.code
    pd.testing.assert_frame_equal(table(small, out), expected.table)
    if name != "ensemble":  # whose answers may take gigabytes, and go at its end
        assert kept <= runs_kept(small, out)
    assert read_record(out, small.study)["finished"]
    assert not list(out.rglob("*.part"))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["comparison"])
def test_a_killed_run_goes_on_to_the_same_tables(name: str, whole: dict[str, Uninterrupted], tmp_path: Path) -> None:
    check_kill_and_going_on(name, 2, whole, tmp_path)


@pytest.mark.exhaustive
@pytest.mark.timeout(0)
@pytest.mark.parametrize("number", range(30))
def test_thirty_random_kills_over_all_studies(number: int, whole: dict[str, Uninterrupted], tmp_path: Path) -> None:
    check_kill_and_going_on(list(SMALL)[number % len(SMALL)], number, whole, tmp_path)
