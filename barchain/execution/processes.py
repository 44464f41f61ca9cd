"""Processes that run calls one after the other, each with a limit of time.

A process is used again for further calls of its pool, and keeps the changes of an engine: a module, a rounding mode, an
environment variable. Therefore calls say which pool they may share.
"""

from __future__ import annotations

import contextlib
import itertools
import os
import signal
import sys
import threading
import time
from concurrent.futures import CancelledError
from concurrent.futures import TimeoutError as FutureTimeoutError
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

from pebble import ProcessExpired, ProcessPool

from adapters.engine import EngineError
from barchain.boundary.contexts import SPAWN
from barchain.boundary.message import plain_text
from barchain.execution.call import Answer, Call, CallEnd, WrongWorkerError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path
    from typing import Any

    from pebble import ProcessFuture

T = TypeVar("T")


class SlotClosedError(RuntimeError):
    """Raised for a call that comes after the end of its slot."""


class ProcessSlot:
    """Processes of which one works at a time: one for each of the last pools."""

    def __init__(self, folder: Path, most: int = 1) -> None:
        """Start no process yet.

        Parameters
        ----------
        folder : Path
            Takes the output of calls while they are at work.
        most : int
            Pools whose processes are kept; the oldest ends when a call of another pool comes.
        """
        self.folder, self.most, self.numbers = folder, most, itertools.count()
        self.pools: dict[tuple[str, int], ProcessPool] = {}
        self.lock, self.closed = threading.Lock(), False
        self.at_work: ProcessFuture[Answer] | None = None

    def run(self, call: Call) -> Answer:
        """Answer to a call."""
        start = time.monotonic()
        found = self.in_pool(call) if call.pool else answered(call.function, call.given)
        return replace(found, seconds=time.monotonic() - start)

    def in_pool(self, call: Call) -> Answer:
        """Answer from a process of the call's pool."""
        log = self.folder / f"{id(self)}-{next(self.numbers)}.log"
        try:
            return collected(self.scheduled(call, log), log, call.wall_s, call.limit_s)
        finally:
            log.unlink(missing_ok=True)

    def scheduled(self, call: Call, log: Path) -> ProcessFuture[Answer]:
        """Answer to come.

        Raises
        ------
        SlotClosedError
            If the slot is closed.
        OSError
            If no process can be started.
        """
        with self.lock:
            if self.closed:
                raise SlotClosedError
            given = call.function, call.given, log, call.limit_s if call.own_work else 0.0
            try:
                self.at_work = self.pool(call).schedule(quietly_answered, given, timeout=call.wall_s)
            except BrokenProcessPool as error:
                raise (error.__cause__ or error) from None  # the system starts no process, and says why
            return self.at_work

    def pool(self, call: Call) -> ProcessPool:
        """Process of the call's pool, started at the first call."""
        key = call.pool, call.calls_per_process
        if key in self.pools and not self.pools[key].active:  # its process was killed while it had no call
            end(self.pools.pop(key))
        if key not in self.pools:
            while len(self.pools) >= self.most:
                end(self.pools.pop(next(iter(self.pools))))
            self.pools[key] = ProcessPool(1, max_tasks=call.calls_per_process, context=SPAWN)
        return self.pools[key]

    def close(self) -> None:
        """End the processes, also those at work."""
        with self.lock:
            self.closed = True
            if self.at_work is not None:
                self.at_work.cancel()  # otherwise its caller would wait for ever
        for pool in self.pools.values():
            end(pool)


def end(pool: ProcessPool) -> None:
    """End a pool's process, also at work."""
    pool.stop()
    pool.join()


def quietly_answered(
    function: Callable[..., bytes], given: tuple[Any, ...], log: Path, processor_s: float = 0.0
) -> Answer:
    """Answer of a function, in its process; the output goes to a file that outlives a crash.

    The process is ended after `processor_s` of processor time, compiled code included; 0: no limit.
    """
    with quietly(log), process_ended_by_use(processor_s):
        return answered(function, given)


@contextlib.contextmanager
def process_ended_by_use(processor_s: float) -> Iterator[None]:
    """Let the system end this process after a processor time, s; 0: no limit."""
    if not processor_s or not hasattr(signal, "setitimer"):
        yield
        return
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_PROF, processor_s)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


def answered(function: Callable[..., bytes], given: tuple[Any, ...]) -> Answer:
    """Answer of a function; an exception becomes its reason."""
    try:
        content: object = function(*given)
        if not isinstance(content, bytes):
            raise TypeError(f"the call returned a {type(content).__name__}, expected bytes")
        return Answer(content)
    except WrongWorkerError as error:
        return Answer(end=CallEnd.OTHER_CODE, reason=plain_text(error))
    except EngineError as error:
        return Answer(end=CallEnd.RAISED, reason=plain_text(error))
    except Exception as error:
        return Answer(end=CallEnd.RAISED, reason=f"{type(error).__name__}: {plain_text(error)}")


def collected(future: ProcessFuture[T], log: Path, limit_s: float, processor_s: float = 0.0) -> T | Answer:
    """Result of a process with a limit of wall time and perhaps of processor time, or a description of its end."""
    try:
        found: T = future.result()
    except (FutureTimeoutError, CancelledError):
        return Answer(end=CallEnd.TIMED_OUT, reason=f"no result within {limit_s:g} s")
    except ProcessExpired as error:
        if hasattr(signal, "SIGPROF") and error.exitcode == -signal.SIGPROF:
            return Answer(end=CallEnd.TIMED_OUT, reason=f"no result within {processor_s:g} s of processor time")
        if error.exitcode == -signal.SIGALRM:
            return Answer(end=CallEnd.OWN_TIMER, reason="its own timer ended its process")
        return Answer(end=CallEnd.DIED, reason=f"its process died ({describe_exit(error.exitcode)}){last_words(log)}")
    except BaseException as error:  # an exit that a worker hands on as an exception is no request to end
        if isinstance(error, KeyboardInterrupt):
            raise
        return Answer(
            end=CallEnd.LOST,
            reason=f"its result could not be brought back: {type(error).__name__}: {plain_text(error)}",
        )
    return found


def describe_exit(code: int | None) -> str:
    """``signal 11, SIGSEGV`` or ``exit code 3``."""
    if code is not None and code < 0:
        return f"signal {-code}, {signal.Signals(-code).name}"
    return f"exit code {code}"


def last_words(log: Path) -> str:
    """Last line in the log of a dead process; empty without one."""
    lines = log.read_text(errors="replace").split("\n") if log.is_file() else []
    said = [line.strip() for line in lines if line.strip()]
    return f"; last output: {said[-1][:200]}" if said else ""


@contextlib.contextmanager
def quietly(log: Path) -> Iterator[None]:
    """Redirect the output of this process and its libraries, C code included, to `log`."""
    flush()
    kept = os.dup(1), os.dup(2)
    with log.open("wb") as sink:
        os.dup2(sink.fileno(), 1)
        os.dup2(sink.fileno(), 2)
        try:
            yield
        finally:
            flush()
            for target, copy in zip((1, 2), kept, strict=True):
                os.dup2(copy, target)
                os.close(copy)


def flush() -> None:
    """Write out what is held back; output that can't be written costs no run."""
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError, AttributeError):  # no room, closed, or none
            stream.flush()
