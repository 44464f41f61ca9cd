"""Functions that tests call in other processes."""

from __future__ import annotations

import os
import signal
import time


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
    time.sleep(3600.0)
    return b""


def process() -> bytes:
    return str(os.getpid()).encode()


def no_bytes() -> bytes:
    return "text"  # type: ignore[return-value]


def works() -> bytes:
    while True:
        pass
