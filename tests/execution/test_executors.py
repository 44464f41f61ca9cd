"""Calls end the same way on this machine and on a cluster: an answer, or one line on why there is none."""

from __future__ import annotations

import itertools
import os
import signal
import threading
import time
from typing import TYPE_CHECKING

import pytest

from barchain.runs.call import Call, CallEnd, pickled
from barchain.runs.executors import DaskCluster, LocalProcesses
from barchain.runs.phases import queue_time_s
from barchain.runs.pool import Slots
from tests.execution import calls
from tests.support.local_cluster import LocalCluster

if TYPE_CHECKING:
    from collections.abc import Iterator

    from barchain.runs.call import Answer
    from barchain.runs.executors import Executor

PATIENT_S = 120.0  # a busy machine starts processes slowly


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LocalCluster]:
    pytest.importorskip("distributed")
    made = LocalCluster(tmp_path_factory.mktemp("cluster"))
    made.worker()
    yield made
    made.close()


@pytest.fixture(params=["local", pytest.param("cluster", marks=pytest.mark.slow)])
def executor(request: pytest.FixtureRequest) -> Executor:
    if request.param == "local":
        return LocalProcesses(1)
    return DaskCluster(request.getfixturevalue("cluster").address, PATIENT_S)


def answers(executor: Executor, *asked: Call) -> list[Answer]:
    """Answers in the order of their calls."""
    with executor.session() as session:
        for k, call in enumerate(asked):
            session.submit(k, call)
        found = dict(session.answers())
    return [found[k] for k in range(len(asked))]


def test_a_call_that_raises_dies_or_hangs_costs_its_own_answer(executor: Executor) -> None:
    echo = Call(calls.echo, (b"here",), PATIENT_S)
    bad = Call(calls.raises, (), PATIENT_S), Call(calls.dies, (), PATIENT_S), Call(calls.hangs, (), 2.0)
    first, raised, died, late, last = answers(executor, echo, *bad, echo)
    assert (first.content, last.content) == (b"here", b"here")
    assert (raised.end, raised.reason) == (CallEnd.RAISED, "ZeroDivisionError: inside the call")
    assert (died.end, died.reason) == (
        CallEnd.DIED,
        "its process died (signal 9, SIGKILL) and gave no result; last output: so long",
    )
    assert (late.end, late.reason) == (CallEnd.TIMED_OUT, "no result within 2 s, ended in simulate")
    assert late.phase == "simulate"


@pytest.mark.skipif(not queue_time_s(), reason="the system does not tell a wait for a processor")
def test_a_run_is_not_late_because_other_programs_keep_the_processor_busy() -> None:
    (answer,) = answers(LocalProcesses(1), Call(calls.works_beside_another, (0.8,), 1.2, pool=""))
    assert answer.content == b"done"
    assert answer.seconds > 1.2


@pytest.mark.exhaustive
def test_own_work_is_limited_by_processor_time_and_not_by_the_clock(executor: Executor) -> None:
    waiting = Call(calls.slowly, (b"late", 2.5), 2.0, own_work=True)
    waited, late = answers(executor, waiting, Call(calls.works, (), 1.0, own_work=True))
    assert waited.content == b"late"
    assert (late.end, late.reason) == (CallEnd.TIMED_OUT, "no result within 1 s of processor time")


def test_calls_of_one_pool_share_a_process_for_their_number_of_calls_and_those_of_another_do_not(
    executor: Executor,
) -> None:
    pools = ("solutions", "solutions", "others")
    short = [Call(calls.process, (), PATIENT_S, "short", calls_per_process=1)] * 2
    asked = [*(Call(calls.process, (), PATIENT_S, pool) for pool in pools), *short]
    first, second, other, once, again = (found.content for found in answers(executor, *asked))
    assert first == second != other
    assert once != again
    assert first != str(os.getpid()).encode()


@pytest.mark.slow
def test_a_process_that_is_killed_between_two_calls_is_replaced() -> None:
    with LocalProcesses(1).session() as session:
        session.submit(0, Call(calls.process, (), PATIENT_S))
        ((_, first),) = session.answers()
        os.kill(int(first.content), signal.SIGKILL)
        time.sleep(2.0)  # until the pool has seen it
        session.submit(1, Call(calls.process, (), PATIENT_S))
        ((_, second),) = session.answers()
    assert second.content not in {b"", first.content}


def test_a_call_that_comes_after_the_end_of_its_place_starts_no_worker() -> None:
    slots = Slots()
    slots.close()
    with slots.slot() as slot:
        found = slot.run(pickled(Call(calls.echo, (b"late",), PATIENT_S)))
    assert (found.end, slot.process) == (CallEnd.DIED, None)


@pytest.mark.slow
def test_an_answer_that_is_no_bytes_never_reaches_the_sender_of_the_call(cluster: LocalCluster) -> None:
    (found,) = answers(DaskCluster(cluster.address, PATIENT_S), Call(calls.no_bytes, (), PATIENT_S))
    assert (found.end, found.reason) == (CallEnd.RAISED, "TypeError: the call returned a str, expected bytes")


def test_a_session_that_is_left_ends_its_calls_and_leaves_no_thread(executor: Executor) -> None:
    before = set(threading.enumerate())
    with executor.session() as session:
        session.submit(0, Call(calls.hangs, (), PATIENT_S))
        session.submit(1, Call(calls.echo, (b"",), PATIENT_S))
    assert not {t for t in threading.enumerate() if not t.daemon} - before


@pytest.mark.slow
def test_a_worker_that_is_killed_half_way_loses_no_call(tmp_path_factory: pytest.TempPathFactory) -> None:
    pytest.importorskip("distributed")
    pair = LocalCluster(tmp_path_factory.mktemp("pair"))
    try:
        victim, _ = pair.worker(), pair.worker()
        with DaskCluster(pair.address, PATIENT_S).session() as session:
            for k in range(40):
                session.submit(k, Call(calls.slowly, (str(k).encode(), 0.1), PATIENT_S))
            coming = session.answers()
            found = dict(itertools.islice(coming, 10))
            os.killpg(victim.pid, signal.SIGKILL)
            found |= dict(coming)
    finally:
        pair.close()
    assert {key: answer.content for key, answer in found.items()} == {k: str(k).encode() for k in range(40)}
