"""Functions that tests call in other processes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

from barchain.runs.phases import SIMULATE, enter


def echo(content: bytes) -> bytes:
    return content


def slowly(content: bytes, seconds: float) -> bytes:
    time.sleep(seconds)
    return content


def raises() -> bytes:
    raise ZeroDivisionError("inside the call")


def dies() -> bytes:
    print("so long", flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
    return b""


def hangs() -> bytes:
    enter(SIMULATE)
    time.sleep(3600.0)
    return b""


def process() -> bytes:
    return str(os.getpid()).encode()


def no_bytes() -> bytes:
    return "text"  # type: ignore[return-value]


def works() -> bytes:
    while True:
        pass


def works_beside_another(seconds: float) -> bytes:
    """Work for some seconds on a processor that another process keeps busy."""
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    other = subprocess.Popen([sys.executable, "-c", "while True: pass"])
    end = time.process_time() + seconds
    while time.process_time() < end:
        pass
    other.kill()
    return b"done"
