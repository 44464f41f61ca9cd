"""Answers of workers are bytes that are checked: whatever is wrong with them is one line, and nothing is unpickled."""

from __future__ import annotations

import io
import json
import pickle
from typing import Any

import numpy as np
import pytest

from barchain.runs.call import Answer, CallEnd, packed, unpacked
from barchain.runs.job import Job, Role
from barchain.runs.message import MessageError, read_message
from barchain.runs.run import shared_result, shared_run
from barchain.runs.same_code import version_of
from barchain.solutions.judging import solution_jobs
from reports.results.outcome import Outcome
from scenarios import load_scene

ANSWERS = [Answer(b"\x00" * 7), Answer(end=CallEnd.DIED, reason="signal 9"), Answer(b"", seconds=0.25, phase="read")]


@pytest.mark.parametrize("answer", ANSWERS)
def test_an_answer_comes_back_as_it_was_sent(answer: Answer) -> None:
    assert unpacked(packed(answer)) == answer


def head(*entries: Any) -> bytes:
    return json.dumps(list(entries)).encode("ascii") + b"\n"


class Trap:
    """Object whose unpickling fails the test."""

    def __reduce__(self) -> tuple[Any, ...]:
        return pytest.fail, ("an answer was unpickled",)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ({"outcome": "pass"}, "is a dict, expected bytes"),
        (None, "is a NoneType, expected bytes"),
        (b"", "its answer is damaged"),
        (b"\xff" * 64, "its answer is damaged"),
        (pickle.dumps(Trap()), "its answer is damaged"),
        (packed(ANSWERS[0])[:-1], "6 of 7 bytes"),
        (packed(ANSWERS[0]) + b"x", "8 of 7 bytes"),
        (head("answered", "", 0.0, 0), "its answer is damaged"),
        (head("no such end", "", 0.0, 0, ""), "its answer is damaged"),
    ],
)
def test_an_answer_that_is_none_is_told_in_one_line(content: object, words: str) -> None:
    with pytest.raises(MessageError, match=words):
        unpacked(content)


def solution_job() -> Job:
    return next(j for j in solution_jobs(load_scene("basics/kepler_circular")) if j.role is Role.SOLUTION)


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04", pickle.dumps(Trap())])
def test_a_result_that_is_damaged_costs_its_run(content: bytes) -> None:
    result = shared_result(solution_job(), Answer(content))
    assert result.outcome is Outcome.FAILED
    assert result.reason.startswith("its result is damaged: ")


def test_a_run_comes_back_with_every_bit_and_the_order_of_its_arrays() -> None:
    job = solution_job()
    result = shared_result(job, Answer(shared_run(job, version_of(job.registration))))
    assert result.outcome is Outcome.PASS
    assert result.trajectory is not None
    assert result.trajectory.com_m.shape == (len(result.trajectory.t_s), 2)
    assert result.seconds.keys() == {"build", "simulate", "read"}


def test_an_answer_that_would_inflate_is_damaged_and_nothing_of_it_is_unpacked(monkeypatch: pytest.MonkeyPatch) -> None:
    sink = io.BytesIO()
    np.savez_compressed(sink, header=np.frombuffer(b"{}", np.uint8), t_s=np.zeros(1_000_000))
    assert len(sink.getvalue()) < 10_000
    monkeypatch.setattr(np, "load", lambda *_, **__: pytest.fail("it was unpacked"))
    with pytest.raises(MessageError, match=r"damaged: 8000\d+ bytes in an archive of"):
        read_message(sink.getvalue())
