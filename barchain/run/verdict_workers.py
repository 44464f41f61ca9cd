"""Verdicts in worker processes.

Beyond the predictability limit a verdict takes as long as the engine's own runs: the reference is restarted from the
engine's states again and again (`barchain.judge.checks.restart`). A verdict whose process dies or times out costs its
own row, like a run.
"""

from __future__ import annotations

import multiprocessing
import os
import queue
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from pebble import ProcessPool

from barchain.boundary.threads import one_thread_each

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Iterator

    from pebble import ProcessFuture

JUDGING_S = 300.0  # a verdict on the longest shipped scene takes some twenty seconds in NumPy
Key = TypeVar("Key", bound="Hashable")


class Judges(Generic[Key]):
    """Worker processes for verdicts; the first submitted verdict starts them."""

    def __init__(self, workers: int | None = None, time_limit_s: float = JUDGING_S) -> None:
        """Prepare.

        Parameters
        ----------
        workers : int, optional
            Number of processes side by side; all cores by default.
        time_limit_s : float
            Wall time after which a verdict's process is ended, s.
        """
        self.workers, self.time_limit_s = workers or os.cpu_count() or 1, time_limit_s
        self.pool: ProcessPool | None = None
        self.threads = ExitStack()
        self.done: queue.SimpleQueue[tuple[Key, ProcessFuture]] = queue.SimpleQueue()
        self.waiting: set[Key] = set()
        """Keys of verdicts that are still to come"""

    def submit(self, key: Key, function: Callable[..., Any], *given: Any) -> None:
        """Call `function` with the given arguments in a worker; :meth:`collected` yields its result with `key`."""
        if self.pool is None:
            self.threads.enter_context(one_thread_each())
            self.pool = ProcessPool(self.workers, context=multiprocessing.get_context("spawn"))
        future = self.pool.schedule(function, given, timeout=self.time_limit_s)
        self.waiting.add(key)
        future.add_done_callback(lambda f: self.done.put((key, f)))

    def collected(self, *, wait: bool) -> Iterator[tuple[Key, Any]]:
        """Results by their keys, an exception for a failure: the finished results, or with `wait` all."""
        while self.waiting and (wait or not self.done.empty()):
            key, future = self.done.get()
            self.waiting.discard(key)
            yield key, future.exception() or future.result()

    def close(self) -> None:
        """End the processes."""
        if self.pool is not None:
            self.pool.stop()
            self.pool.join()
            self.pool = None
        self.threads.close()
