"""A command that goes on after an interruption takes kept answers, and asks for the rest only."""

from __future__ import annotations

import dataclasses
import os
import subprocess
import sys
from typing import TYPE_CHECKING, Any

import pytest

from adapters.registry import Registration
from barchain.runs.call import Call, CallEnd
from barchain.runs.executors import KeptAnswers, LocalProcesses
from barchain.runs.job import Job, Role, TimeLimit
from barchain.runs.run import shared_call, shared_result
from reports.results.outcome import Outcome
from scenarios import load_scene
from tests.execution import calls
from tests.support.here import HERE
from tests.support.results import answers_folder

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.runs.call import Answer

PATIENT_S = 120.0


def run_command(command: str, out: Path, seed: str) -> None:
    line = [sys.executable, "-m", "barchain", "-q", *command.split(), "--out", str(out)]
    made = subprocess.run(line, env=os.environ | {"PYTHONHASHSEED": seed}, capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr


def times_of(folder: Path) -> dict[Path, int]:
    return {file: file.stat().st_mtime_ns for file in folder.iterdir()}


def answers(folder: Path, *asked: Call, executor: Any = None) -> list[Answer]:
    """Answers of one session, in the order of their calls."""
    with KeptAnswers(folder, executor or LocalProcesses(1)).session() as session:
        for k, call in enumerate(asked):
            session.submit(k, call)
        found = dict(session.answers())
    return [found[k] for k in range(len(asked))]


def files(folder: Path) -> list[Path]:
    return sorted(folder.iterdir())


def test_a_call_whose_answer_is_kept_is_not_made_again_whatever_its_limit_is(tmp_path: Path) -> None:
    call = Call(calls.process, (), PATIENT_S)
    (first,) = answers(tmp_path, call)
    assert answers(tmp_path, dataclasses.replace(call, limit_s=2.0 * PATIENT_S))[0].content == first.content


def test_other_arguments_are_asked_for_and_a_failure_is_not_kept(tmp_path: Path) -> None:
    asked = [Call(calls.echo, (content,), PATIENT_S) for content in (b"one", b"two")]
    one, two, failed = answers(tmp_path, *asked, Call(calls.raises, (), PATIENT_S))
    assert (one.content, two.content, failed.end) == (b"one", b"two", CallEnd.RAISED)
    assert len(files(tmp_path)) == 2


def test_a_run_that_fails_is_made_again(tmp_path: Path) -> None:
    registration = Registration("tests.support.faulty_engines:GivesUp")
    scene = load_scene("basics/two_bars_free")
    job = Job(scene, "GivesUp", registration, registration.load().sweep.setting(), Role.MAIN)
    (found,) = answers(tmp_path, shared_call(job, TimeLimit(PATIENT_S), "runs", 1))
    assert shared_result(job, found).outcome is Outcome.FAILED
    assert files(tmp_path) == []


@pytest.mark.parametrize("damage", [b"\0" * 4096, b"", b"half of it"])
def test_a_damaged_answer_is_asked_for_again(damage: bytes, tmp_path: Path) -> None:
    call = Call(calls.echo, (b"whole",), PATIENT_S)
    answers(tmp_path, call, executor=HERE)
    (file,) = files(tmp_path)
    file.write_bytes(damage)
    assert answers(tmp_path, call, executor=HERE)[0].content == b"whole"
    assert file.read_bytes().endswith(b"whole")


EFFECTS = "effects basics/two_bars_free --engine reference --repeats 1 --minutes 0.01"


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("command", "study"),
    [
        pytest.param("compare paper/fig13 --engine pymunk --engine reference --workers 2", "comparison",
                     marks=pytest.mark.slow),
        pytest.param("selftest basics/kepler_circular --fault scale-rate", "selftest", marks=pytest.mark.exhaustive),
        pytest.param("stability hard/vertical_fall --engine rebound", "stability", marks=pytest.mark.exhaustive),
        pytest.param(EFFECTS, "effects", marks=pytest.mark.exhaustive),
        pytest.param("roundoff --part engines", "roundoff", marks=pytest.mark.exhaustive),
    ],
)  # fmt: skip
def test_another_process_asks_for_nothing_that_is_there(command: str, study: str, tmp_path: Path) -> None:
    """Keys of calls do not depend on the process that makes them, nor on its seed of hashes."""
    out = tmp_path / "out"
    run_command(command, out, seed="1")
    first = times_of(answers_folder(out, study))
    run_command(f"{command} --resume", out, seed="2")
    assert first
    assert times_of(answers_folder(out, study)) == first
