"""Environment of worker processes: one thread each, and a temporary folder that goes with the process that compares.

A process that starts others needs standard streams, a current folder and a number of open files. Closed streams are
replaced by the null device: pipes would take their numbers. What else is missing is told before anything starts.

Threads of several workers would wait for each other, and a library whose order of summation depends on the number of
threads would change the last bits. Libraries read the number when they are loaded. The environment must therefore hold
it when a process starts, also when a process replaces another during a run.

All temporary folders of workers lie in one folder. A watchman, a process without any of barchain, removes that folder
when the comparing process ends. If it was killed, the watchman also kills the processes that it has started: they carry
the folder's name in their environment.
"""

from __future__ import annotations

import contextlib
import errno
import os
import tempfile
import threading
from pathlib import Path
from typing import TYPE_CHECKING

import psutil

from barchain.runs.watchman import Watchman

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
ONE_THREAD = dict.fromkeys(THREADS, "1")


FOLDER = "BARCHAIN_TEMPORARY"
"""Variable that holds the temporary folder of a comparing process, and marks the processes that belong to it"""


def in_worker() -> bool:
    """Whether this process is a worker, whose own workers use its temporary folder."""
    folder = os.environ.get(FOLDER)
    return bool(folder) and Path(str(folder)).is_dir()


STANDARD = range(3)
"""Descriptors of the standard streams"""
FILES_PER_PROCESS = 2
"""Open files of a worker: its pipes"""
SPARE_FILES = 20
"""Open files beside those of pools: tables, logs, and the pipes to one engine of another package"""


class NoProcessError(OSError):
    """Raised where this process can't start others: a fault of its surroundings, and of no engine."""


def fill_standard_streams() -> None:
    """Open the null device at each closed descriptor of a standard stream, for this process and those it starts."""
    for number in STANDARD:
        try:
            os.fstat(number)
        except OSError:
            null = os.open(os.devnull, os.O_RDWR)
            os.dup2(null, number)  # inheritable, also where it is the same number
            os.set_inheritable(number, True)
            if null != number:
                os.close(null)


def need_current_folder() -> None:
    """Check that there is a current folder: a process can't be started without.

    Raises
    ------
    NoProcessError
        If it was removed.
    """
    try:
        os.getcwd()  # noqa: PTH109  # `Path.cwd` says no more
    except OSError as error:
        raise NoProcessError(error.errno, "the current folder is gone; change to one that is there") from None


def need_open_files(processes: int = 0) -> None:
    """Check that this process may open the files that other processes take, and raise its own limit if it may.

    Parameters
    ----------
    processes : int
        Number of processes side by side.

    Raises
    ------
    NoProcessError
        If the limit that only an administrator may raise is too low.
    """
    try:
        import resource  # noqa: PLC0415  # not on Windows
    except ImportError:
        return
    needed = psutil.Process().num_fds() + FILES_PER_PROCESS * processes + SPARE_FILES
    usual, most = (
        float("inf") if n == resource.RLIM_INFINITY else n for n in resource.getrlimit(resource.RLIMIT_NOFILE)
    )
    if needed > most:
        fewer = " or take fewer --workers" if processes > 1 else ""
        raise NoProcessError(
            errno.EMFILE,
            f"too few open files are allowed: {most} given, needed: {needed}; raise the limit by `ulimit -n`{fewer}",
        )
    if needed > usual:
        resource.setrlimit(resource.RLIMIT_NOFILE, (needed, resource.getrlimit(resource.RLIMIT_NOFILE)[1]))


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
                fill_standard_streams()
                need_current_folder()
                need_open_files()
                self.before = {name: os.environ.get(name) for name in (*THREADS, FOLDER)}
                os.environ.update(ONE_THREAD)
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


@contextlib.contextmanager
def kept_or_temporary(out: Path | None) -> Iterator[Path]:
    """Result folder `out`; without one a temporary folder, which is removed also after a kill."""
    if out is not None:
        yield out
        return
    with one_thread_each(), tempfile.TemporaryDirectory(dir=temporary_root(), ignore_cleanup_errors=True) as scratch:
        yield Path(scratch)
