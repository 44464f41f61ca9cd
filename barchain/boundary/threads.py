"""Environment of worker processes: one thread each, and a temporary folder that goes with the process that compares.

Threads of several workers would wait for each other, and a library whose order of summation depends on the number of
threads would change the last bits. Libraries read the number when they are loaded. The environment must therefore hold
it when a process starts, also when a process replaces another during a run.

All temporary folders of workers lie in one folder. A watchman, a process without any of barchain, removes that folder
when the comparing process ends. If it was killed, the watchman also kills the processes that it has started: they carry
the folder's name in their environment.
"""

from __future__ import annotations

import contextlib
import os
import threading
from pathlib import Path
from typing import TYPE_CHECKING

from barchain.boundary.watchman import Watchman

if TYPE_CHECKING:
    from collections.abc import Iterator

THREADS = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "BLIS_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
    "NUMEXPR_NUM_THREADS",
)


FOLDER = "BARCHAIN_TEMPORARY"
"""Variable that holds the temporary folder of a comparing process, and marks the processes that belong to it"""


def in_worker() -> bool:
    """Whether this process is a worker, whose own workers use its temporary folder."""
    folder = os.environ.get(FOLDER)
    return bool(folder) and Path(str(folder)).is_dir()


class WorkerEnvironment:
    """Count of active contexts, the environment before the first of them, and their temporary folder."""

    def __init__(self) -> None:
        self.lock, self.users = threading.Lock(), 0
        self.before: dict[str, str | None] = {}
        self.watchman: Watchman | None = None

    def enter(self) -> None:
        """Set the environment if this context is the first."""
        with self.lock:
            if not self.users:
                self.before = {name: os.environ.get(name) for name in (*THREADS, FOLDER)}
                os.environ.update(dict.fromkeys(THREADS, "1"))
                if not in_worker():
                    self.watchman = Watchman()
                    os.environ[FOLDER] = self.watchman.folder
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
            if self.watchman is not None:
                self.watchman.dismiss()
                self.watchman = None


ENVIRONMENT = WorkerEnvironment()


@contextlib.contextmanager
def one_thread_each() -> Iterator[None]:
    """Start processes with one thread each inside this context; contexts may overlap and end in any order."""
    ENVIRONMENT.enter()
    try:
        yield
    finally:
        ENVIRONMENT.leave()


def temporary_root() -> str | None:
    """Folder for temporary folders of runs; None, the system's, outside :func:`one_thread_each`."""
    return os.environ.get(FOLDER)
