"""Workers of this process, and calls that are under way: here in slots side by side, elsewhere by other sessions.

A slot asks its worker (:mod:`barchain.runs.worker`) one call after the other, and replaces it when it dies.
"""

from __future__ import annotations

import atexit
import contextlib
import os
import queue
import subprocess
import sys
import threading
import time
from abc import ABC, abstractmethod
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Self

from barchain.runs.call import (
    Answer,
    CallEnd,
    known_of,
    pickled,
    read_frame,
    unpacked,
    write_frame,
)
from barchain.runs.child import FORKS
from barchain.runs.environment import ONE_THREAD, need_current_folder, start
from barchain.runs.message import MessageError, plain_text

if TYPE_CHECKING:
    from collections.abc import Hashable, Iterator
    from types import TracebackType

    from barchain.runs.call import Call

WORKER = ("-P", "-m", "barchain.runs.worker")
START_S = 60.0  # for a worker to import barchain on a busy machine
END_S = 10.0  # for a worker to end its processes


class WorkerLostError(RuntimeError):
    """Raised where a worker died, or gave no answer within the limits of its calls."""


def module_paths() -> list[str]:
    """Folders in which this process finds modules, absolute; the current folder, where it has no name, is last.

    A file that lies there, as ``random.py``, takes the place of no module that barchain or an engine needs.
    """
    need_current_folder()
    here = [os.getcwd()] if "" in sys.path else []  # noqa: PTH109
    return [*filter(None, sys.path), *here]


class Slot:
    """A worker that answers calls, and is replaced by another where a call has killed it."""

    def __init__(self, idle_s: float | None = None) -> None:
        """Start none yet; a worker ends by itself after `idle_s` without a call."""
        self.idle_s, self.closed = idle_s, False
        self.process: subprocess.Popen[bytes] | None = None
        self.python = sys.executable
        """Of the worker"""
        self.lock = threading.Lock()

    def run(self, call: bytes) -> Answer:
        """Answer to a call from :func:`barchain.runs.call.pickled`; one that kills its worker is answered as dead."""
        begun = time.monotonic()
        try:
            return unpacked(self.ask(call))
        except (WorkerLostError, MessageError) as error:
            self.close_worker()
            reason = f"its process died with the process that started it ({plain_text(error)})"
            return Answer(end=CallEnd.DIED, reason=reason, seconds=time.monotonic() - begun)

    def ask(self, call: bytes) -> bytes:
        """Packed answer of the worker, which is killed if it takes longer than the call's limit and its own start.

        Raises
        ------
        WorkerLostError
            If it dies.
        """
        known, _ = known_of(call)
        process = self.started(known.python or sys.executable)
        assert process.stdin is not None
        assert process.stdout is not None
        most_s = known.most_s if FORKS else known.wall_s  # else it is the worker that looks at the limit
        timer = threading.Timer(most_s + START_S, process.kill)
        timer.start()
        try:
            write_frame(process.stdin, call)
            content = read_frame(process.stdout)
        except (OSError, ValueError) as error:
            raise WorkerLostError(plain_text(error)) from None
        finally:
            timer.cancel()
        if content is None:
            raise WorkerLostError("the worker died")
        return content

    def started(self, python: str) -> subprocess.Popen[bytes]:
        """The worker of a Python, with the modules that this process can import.

        Raises
        ------
        WorkerLostError
            If the slot is closed.
        """
        with self.lock:
            if self.closed:
                raise WorkerLostError("no call is wanted any more")
            if self.process is None or self.process.poll() is not None or self.python != python:
                self.close_worker()
                self.python = python
                variables = os.environ | ONE_THREAD | {"PYTHONPATH": os.pathsep.join(module_paths())}
                line = [python, *WORKER, *([] if self.idle_s is None else [str(self.idle_s)])]
                try:
                    self.process = start(line, given=subprocess.PIPE, output=subprocess.PIPE, variables=variables)
                except FileNotFoundError:
                    raise WorkerLostError(f"{python} is not there") from None
            return self.process

    def close_worker(self) -> None:
        """End the worker, and with it all that it has started, also while a call is at work."""
        process, self.process = self.process, None
        if process is None:
            return
        assert process.stdin is not None
        assert process.stdout is not None
        with contextlib.suppress(OSError):
            process.stdin.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(END_S)
        process.kill()
        process.wait()
        with contextlib.suppress(OSError):
            process.stdout.close()

    def close(self) -> None:
        """End the worker, and start none again."""
        with self.lock:
            self.closed = True
        self.close_worker()


class Slots:
    """Slots for calls from any thread: as many as are at work at once."""

    def __init__(self, idle_s: float | None = None) -> None:
        """Start none yet; `idle_s` as for :class:`Slot`."""
        self.idle_s, self.lock = idle_s, threading.Lock()
        self.idle: list[Slot] = []
        self.busy: set[Slot] = set()
        self.closed = False

    @contextlib.contextmanager
    def slot(self) -> Iterator[Slot]:
        """An idle slot, or a new one; after an exception, also an interruption, it is closed."""
        with self.lock:
            found = self.idle.pop() if self.idle else Slot(self.idle_s)
            found.closed = self.closed
            self.busy.add(found)
        try:
            yield found
        except BaseException:
            found.close()
            raise
        finally:
            with self.lock:
                self.busy.discard(found)
                if not found.closed:
                    self.idle.append(found)

    def close_idle(self) -> None:
        """End idle workers: they may have old code."""
        with self.lock:
            idle, self.idle = self.idle, []
        for slot in idle:
            slot.close()

    def close(self) -> None:
        """End all workers, and with them the calls at work; those that come later are answered as dead."""
        with self.lock:
            self.closed, busy = True, list(self.busy)
        for slot in busy:
            slot.close()
        self.close_idle()


SLOTS = Slots()
"""Slots for single questions, which end with this process"""
atexit.register(SLOTS.close_idle)


class Session(ABC):
    """A place while it runs calls; a context, at whose end calls at work are ended."""

    def __init__(self) -> None:
        self.done: queue.SimpleQueue[tuple[Hashable, Answer] | Exception] = queue.SimpleQueue()
        self.left: int = 0
        """Calls whose answer has not been taken"""

    @abstractmethod
    def start(self, key: Hashable, call: Call) -> None:
        """Begin a call, or queue it; its answer goes to `done`."""

    @abstractmethod
    def close(self) -> None:
        """End everything."""

    def side_by_side(self) -> int:
        """Calls that run at the same time, as far as is known."""
        return 1

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def submit(self, key: Hashable, call: Call) -> None:
        """Take a call; calls begin in the order in which they are submitted."""
        self.left += 1
        self.start(key, call)

    def answers(self, *, wait: bool = True) -> Iterator[tuple[Any, Answer]]:
        """Answers with the keys of their calls: those that are there, or with `wait` all.

        Raises
        ------
        ClusterLostError
            If the place fails; answers so far have been given.
        """
        while self.left and (wait or not self.done.empty()):
            found = self.done.get()
            if isinstance(found, Exception):
                raise found
            self.left -= 1
            yield found


class LocalSession(Session):
    """Calls in slots of this machine, side by side, each asked by a thread."""

    def __init__(self, workers: int | None = None) -> None:
        """Prepare; `workers` is the number of calls side by side, as many as there are cores by default."""
        super().__init__()
        self.workers = workers or os.cpu_count() or 1
        self.slots, self.threads = Slots(), ThreadPoolExecutor(self.workers)

    def start(self, key: Hashable, call: Call) -> None:
        """Queue a call."""
        self.threads.submit(self.serve, key, call)

    def serve(self, key: Hashable, call: Call) -> None:
        """Answer a call, in a thread; a fault of barchain's own ends the command with its traceback."""
        try:
            with self.slots.slot() as slot:
                self.done.put((key, slot.run(pickled(call))))
        except Exception as error:
            self.done.put(error)

    def side_by_side(self) -> int:
        """Slots."""
        return self.workers

    def close(self) -> None:
        """End the calls at work, and all processes."""
        self.threads.shutdown(wait=False, cancel_futures=True)
        self.slots.close()
        self.threads.shutdown()


class OneByOneSession(Session):
    """Calls one after the other: each pool has a worker of its own, and only one of them works at a time."""

    def __init__(self) -> None:
        super().__init__()
        self.slots: dict[str, Slot] = {}

    def start(self, key: Hashable, call: Call) -> None:
        """Make a call; its answer is there when this returns."""
        begun = time.monotonic()
        answer = self.slots.setdefault(call.pool, Slot()).run(pickled(call))
        self.done.put((key, replace(answer, seconds=time.monotonic() - begun)))

    def close(self) -> None:
        """End all processes."""
        for slot in self.slots.values():
            slot.close()
