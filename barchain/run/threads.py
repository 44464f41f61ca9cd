"""Limit of one thread in each worker process.

Threads of several workers would wait for each other, and a library whose order of summation depends on the number of
threads would change the last bits. Libraries read the number when they are loaded. The environment must therefore hold
it when a process starts, also when a process replaces another during a run.
"""

from __future__ import annotations

import contextlib
import os
import threading
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

THREADS = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "BLIS_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
    "NUMEXPR_NUM_THREADS",
    "NUMBA_NUM_THREADS",
)


class Pinned:
    """Count of active contexts, and the environment before the first of them."""

    def __init__(self) -> None:
        self.lock, self.users = threading.Lock(), 0
        self.before: dict[str, str | None] = {}

    def enter(self) -> None:
        """Set the environment if this context is the first."""
        with self.lock:
            if not self.users:
                self.before = {name: os.environ.get(name) for name in THREADS}
                os.environ.update(dict.fromkeys(THREADS, "1"))
            self.users += 1

    def leave(self) -> None:
        """Restore the environment if this context is the last."""
        with self.lock:
            self.users -= 1
            if self.users:
                return
            for name, value in self.before.items():
                if value is None:
                    os.environ.pop(name, None)
                else:
                    os.environ[name] = value


PINNED = Pinned()


@contextlib.contextmanager
def one_thread_each() -> Iterator[None]:
    """Start processes with one thread each inside this context; contexts may overlap and end in any order."""
    PINNED.enter()
    try:
        yield
    finally:
        PINNED.leave()
