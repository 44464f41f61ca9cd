"""Workers of this process: each is asked one request after the other, and replaced when it dies."""

from __future__ import annotations

import atexit
import contextlib
import os
import subprocess
import sys
import threading
import time
from typing import TYPE_CHECKING

from barchain.runs.call import Answer, CallEnd, WrongWorkerError, limits_of, unpacked_answers
from barchain.runs.environment import ONE_THREAD, need_current_folder, start
from barchain.runs.frames import joined, parted, read_frame, write_frame
from barchain.runs.message import MessageError, plain_text

if TYPE_CHECKING:
    from collections.abc import Iterator

COMMAND = [sys.executable, "-m", "barchain.runs.worker"]
OTHER = b"other code"
"""Head of a reply of a worker whose code differs from its sender's"""
START_S = 60.0  # for a worker to import barchain on a busy machine
END_S = 10.0  # for a worker to end its processes


class WorkerLostError(RuntimeError):
    """Raised where a worker died, or gave no answer within the limits of its calls."""


def module_paths() -> list[str]:
    """Folders in which this process finds modules, absolute."""
    need_current_folder()
    return [path or os.getcwd() for path in sys.path]  # noqa: PTH109


class Worker:
    """A worker process."""

    def __init__(self, idle_s: float | None = None) -> None:
        """Start it, with the modules that this process can import; it ends by itself after `idle_s` without a call."""
        paths = {"PYTHONPATH": os.pathsep.join(module_paths())}
        line = [*COMMAND, *([] if idle_s is None else [str(idle_s)])]
        variables = os.environ | ONE_THREAD | paths
        self.process = start(line, given=subprocess.PIPE, output=subprocess.PIPE, variables=variables)

    def ask(self, request: bytes, limit_s: float) -> bytes:
        """Content of the reply to a request; a worker that takes longer than `limit_s` is killed.

        Raises
        ------
        WrongWorkerError
            If its code differs from the sender's.
        WorkerLostError
            If it dies.
        """
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        timer = threading.Timer(limit_s, self.process.kill)
        timer.start()
        try:
            write_frame(self.process.stdin, request)
            found = read_frame(self.process.stdout)
            kind, content = parted(found) if found is not None else (b"", b"")
        except (OSError, ValueError) as error:
            raise WorkerLostError(plain_text(error)) from None
        finally:
            timer.cancel()
        if found is None:
            raise WorkerLostError("the worker died")
        if kind == OTHER:
            raise WrongWorkerError(content.decode())
        return content

    @property
    def alive(self) -> bool:
        """Whether it runs."""
        return self.process.poll() is None

    def close(self) -> None:
        """End it, and with it all that it has started, also while a call is at work."""
        assert self.process.stdin is not None
        with contextlib.suppress(OSError):
            self.process.stdin.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process.wait(END_S)
        self.process.kill()
        self.process.wait()
        assert self.process.stdout is not None
        with contextlib.suppress(OSError):
            self.process.stdout.close()


class Slot:
    """A worker that answers calls, and is replaced by another where a call has killed it."""

    def __init__(self, idle_s: float | None = None) -> None:
        """Start none yet; `idle_s` as for :class:`Worker`."""
        self.idle_s, self.closed = idle_s, False
        self.worker: Worker | None = None
        self.lock = threading.Lock()

    def run(self, call: bytes, versions: bytes = b"") -> Answer:
        """Answer to a call from :func:`barchain.runs.call.pickled`; one that kills its worker is answered as dead.

        Raises
        ------
        WrongWorkerError
            If versions of the sender's code are given, as JSON, and this machine has others.
        """
        start, wall_s = time.monotonic(), limits_of(call).wall_s
        try:
            content = self.started().ask(joined([versions, call]), wall_s + START_S)
            return unpacked_answers(content, 1)[0]
        except (WorkerLostError, MessageError) as error:
            self.close_worker()
            reason = f"its process died with the process that started it ({plain_text(error)})"
            return Answer(end=CallEnd.DIED, reason=reason, seconds=time.monotonic() - start)

    def started(self) -> Worker:
        """The worker.

        Raises
        ------
        WorkerLostError
            If the slot is closed.
        """
        with self.lock:
            if self.closed:
                raise WorkerLostError("no call is wanted any more")
            if self.worker is None or not self.worker.alive:
                self.close_worker()
                self.worker = Worker(self.idle_s)
            return self.worker

    def close_worker(self) -> None:
        """End the worker."""
        worker, self.worker = self.worker, None
        if worker is not None:
            worker.close()

    def close(self) -> None:
        """End the worker, and start none again."""
        with self.lock:
            self.closed = True
        self.close_worker()


class IdleSlots:
    """Slots that wait for a call from any thread."""

    def __init__(self, idle_s: float | None = None) -> None:
        """Start none yet; `idle_s` as for :class:`Worker`."""
        self.idle_s, self.lock, self.slots = idle_s, threading.Lock(), list[Slot]()
        atexit.register(self.close)

    @contextlib.contextmanager
    def slot(self) -> Iterator[Slot]:
        """An idle slot, or a new one; after an exception, also an interruption, it is closed."""
        with self.lock:
            found = self.slots.pop() if self.slots else Slot(self.idle_s)
        try:
            yield found
        except BaseException:
            found.close()
            raise
        with self.lock:
            self.slots.append(found)

    def close(self) -> None:
        """End all idle workers: they may have old code."""
        with self.lock:
            slots, self.slots = self.slots, []
        for slot in slots:
            slot.close()
