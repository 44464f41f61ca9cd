"""Worker processes that compute in one thread each.

Side by side, threads of several workers only wait for each other; and a library that sums in another order with another
number of threads gives other bits. Libraries read the number when they are loaded, so that it has to be in the
environment that a process is started with, also one that replaces another during a run.
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
    """How many contexts want one thread each, and what the environment was before the first of them."""

    def __init__(self) -> None:
        self.lock, self.users = threading.Lock(), 0
        self.before: dict[str, str | None] = {}

    def enter(self) -> None:
        """Set the environment for the first."""
        with self.lock:
            if not self.users:
                self.before = {name: os.environ.get(name) for name in THREADS}
                os.environ.update(dict.fromkeys(THREADS, "1"))
            self.users += 1

    def leave(self) -> None:
        """Put the environment back after the last."""
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
    """Processes started meanwhile compute in one thread; contexts may overlap, and end in any order."""
    PINNED.enter()
    try:
        yield
    finally:
        PINNED.leave()
