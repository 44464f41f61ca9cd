"""Times of runs: without the wait for a processor, and with any other wait."""

from __future__ import annotations

import os
import subprocess
import sys
import time

import pytest

from barchain.runs.phases import Stopwatch, queue_time_s, timed

WORK = "while True: pass"


def work() -> None:
    """Some 50 ms of arithmetic."""
    sum(k * k % 7 for k in range(500_000))


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="the system can't pin a process")
def test_a_run_beside_others_on_its_processor_takes_the_time_that_it_used() -> None:
    allowed = os.sched_getaffinity(0)
    core = {min(allowed)}
    os.sched_setaffinity(0, core)
    others = [subprocess.Popen([sys.executable, "-c", WORK]) for _ in range(2)]  # they inherit the core
    try:
        time.sleep(0.2)
        used, wall, clock = time.process_time(), time.perf_counter(), Stopwatch()
        for _ in range(4):
            work()
        seconds = clock.seconds()
        used, wall = time.process_time() - used, time.perf_counter() - wall
    finally:
        os.sched_setaffinity(0, allowed)
        for other in others:
            other.kill()
            other.wait()
    assert used <= wall
    assert seconds == pytest.approx(used, rel=0.2)
    if queue_time_s() > 0.0:  # the system tells the wait, and there was one
        assert seconds < 0.7 * wall


def test_a_wait_for_something_else_than_a_processor_counts() -> None:
    clock = Stopwatch()
    time.sleep(0.2)
    assert clock.seconds() >= 0.15


def test_a_failing_call_names_its_phase_and_has_no_time() -> None:
    seconds: dict[str, float] = {}
    with pytest.raises(ZeroDivisionError) as error:
        timed(seconds, "simulate", lambda: 1 / 0)
    assert error.value.__notes__ == ["simulate"]
    assert seconds == {}
