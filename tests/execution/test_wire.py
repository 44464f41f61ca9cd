"""Answers of workers are bytes that are checked: whatever is wrong with them is one line, and nothing is unpickled."""

from __future__ import annotations

import json
import pickle
from typing import Any

import pytest

from barchain.runs.call import Answer, CallEnd, packed_answers, unpacked_answers
from barchain.runs.frames import joined, parted
from barchain.runs.job import Job, Role
from barchain.runs.message import MessageError
from barchain.runs.messages import shared_result, shared_run, version_of
from barchain.solutions.judging import solution_jobs
from reports.tables.outcome import Outcome
from scenarios import load_scene

ANSWERS = [Answer(b"\x00" * 7), Answer(end=CallEnd.DIED, reason="signal 9"), Answer(b"", seconds=0.25)]


def test_answers_come_back_as_they_were_sent() -> None:
    assert unpacked_answers(packed_answers(ANSWERS), 3) == ANSWERS


def head(*entries: Any) -> bytes:
    return joined([json.dumps(list(entries)).encode("ascii"), b""])


class Trap:
    """Object whose unpickling fails the test."""

    def __reduce__(self) -> tuple[Any, ...]:
        return pytest.fail, ("an answer was unpickled",)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ({"outcome": "pass"}, "is a dict, expected bytes"),
        (None, "is a NoneType, expected bytes"),
        (b"", "a wrong number of parts"),
        (b"\xff" * 64, "a wrong number of parts"),
        (pickle.dumps(Trap()), "a wrong number of parts"),
        (packed_answers(ANSWERS)[:-1], "wrong lengths of parts"),
        (packed_answers(ANSWERS) + b"x", "wrong lengths of parts"),
        (packed_answers(ANSWERS[:2]), "is to 2 calls, expected 3"),
        (joined([b"no JSON"]), "its answer is damaged"),
        (head(["answered", ""]), "its answer is damaged"),
        (head(["no such end", "", 0.0]), "its answer is damaged"),
        (head(*[["answered", "", 0.0]] * 3), "is to 1 calls, expected 3"),
    ],
)
def test_an_answer_that_is_none_is_told_in_one_line(content: object, words: str) -> None:
    with pytest.raises(MessageError, match=words):
        unpacked_answers(content, 3)


def test_parts_are_joined_and_parted() -> None:
    for parts in ([], [b""], [b"one", b"", b"three"]):
        assert parted(joined(parts)) == parts


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
