"""Start of every process, and what it inherits: one thread, and a temporary folder that goes with who compares.

A process that starts others needs standard streams and a current folder. Closed streams are replaced by the null
device: pipes would take their numbers. A folder that is gone is told before anything starts.

Threads of several workers would wait for each other, and a library whose order of summation depends on the number of
threads would change the last bits. Libraries read the number when they are loaded: a process has it in its environment
from its start.

A watchman, a process without any of barchain, removes a temporary folder when the process that needs it ends. If it was
killed, the watchman also kills the processes that it has started: they carry the folder's name in their environment.
Where both were killed, the folder stays, and a later start removes it: its owner's lock is gone.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import stat
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from typing import IO

THREADS = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "BLIS_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
    "NUMEXPR_NUM_THREADS",
)
ONE_THREAD = dict.fromkeys(THREADS, "1")


OWN_PYTHON = (sys.executable, "-P")
"""Start of the command line of a Python of ours: it imports no module of the folder in which it is started"""


FOLDER = "BARCHAIN_TEMPORARY"
"""Variable that holds the temporary folder of a comparing process, and marks the processes that belong to it"""


PREFIX = "barchain-tmp-"
"""Begin of the name of a temporary folder"""
LEFT_S = 3600.0
"""Age from which on a folder without a lock is left: its owner takes the lock when it has made it"""


STANDARD = range(3)
"""Descriptors of the standard streams"""


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


def start(
    command: Sequence[str | Path],
    *,
    given: int | IO[bytes] = subprocess.DEVNULL,
    output: int | IO[bytes] = subprocess.DEVNULL,
    errors: int | IO[bytes] = subprocess.DEVNULL,
    folder: Path | None = None,
    variables: Mapping[str, str] | None = None,
) -> subprocess.Popen[bytes]:
    """Start a process in a session of its own; every process that barchain starts, and does not fork, begins here.

    Parameters
    ----------
    command : sequence of str or Path
    given, output, errors : int or file
        Its standard streams, as for `subprocess.Popen`; none by default.
    folder : Path, optional
        Its working folder; that of this process by default.
    variables : mapping, optional
        Its environment; that of this process by default.

    Raises
    ------
    NoProcessError
        If this process can't start others.
    OSError
        If there is no such program.
    """
    fill_standard_streams()
    need_current_folder()
    return subprocess.Popen(
        [str(word) for word in command], stdin=given, stdout=output, stderr=errors, cwd=folder, env=variables,
        start_new_session=True,
    )  # fmt: skip


DONE = b"done"
PROGRAM = r"""
import os, shutil, signal, sys, time
for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
    signal.signal(number, signal.SIG_IGN)
folder = sys.argv[1]
orderly = sys.stdin.buffer.read() == b"done"
marked = ("BARCHAIN_TEMPORARY=" + folder).encode()

def belongs(pid):
    try:
        if os.readlink(f"/proc/{pid}/cwd").startswith(folder + "/"):
            return True
        with open(f"/proc/{pid}/environ", "rb") as file:
            return marked in file.read().split(b"\0")
    except OSError:
        return False

def kill_all():
    found = [int(p) for p in os.listdir("/proc") if p.isdigit() and int(p) != os.getpid() and belongs(p)]
    for pid in found:
        try:
            os.kill(pid, signal.SIGKILL)
        except OSError:
            pass
    return found

if not orderly and os.path.isdir("/proc/self"):
    for _ in range(100):
        if not kill_all():
            break
        time.sleep(0.05)
shutil.rmtree(folder, ignore_errors=True)
"""
"""Program of the watchman; it imports nothing but the standard library, to start in some 20 ms"""


class Watchman:
    """A temporary folder, and a small process that cleans up after this one, however it ends.

    The watchman reads a pipe that only this process holds open. A word on the pipe is an orderly end: the folder is
    removed. The end of the pipe without a word means that this process was killed: the watchman first kills every
    process whose environment names the folder, or that works inside it. It runs in a session of its own, so that a
    closed terminal does not end it.
    """

    def __init__(self) -> None:
        """Make the folder and start the process."""
        sweep()
        self.folder = tempfile.mkdtemp(prefix=PREFIX)
        self.lock = None
        with contextlib.suppress(OSError):  # without locks nobody can take the folder for one that is left
            self.lock = locked(self.folder)
        self.process = start([sys.executable, "-I", "-S", "-c", PROGRAM, self.folder], given=subprocess.PIPE)

    def dismiss(self) -> None:
        """End the process in order; it removes the folder first, or was killed and leaves that to its owner."""
        assert self.process.stdin is not None
        with contextlib.suppress(OSError):
            self.process.stdin.write(DONE)
            self.process.stdin.close()
        self.process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)
        if self.lock is not None:
            os.close(self.lock)


def locked(folder: str | Path) -> int | None:
    """Descriptor that locks a folder until its process ends; None where there are no such locks.

    Raises
    ------
    OSError
        If another process has the lock, or there can be none.
    """
    try:
        import fcntl  # noqa: PLC0415  # not on Windows
    except ImportError:
        return None
    handle = os.open(folder, os.O_RDONLY | os.O_NOFOLLOW)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(handle)
        raise
    return handle


def sweep() -> None:
    """Remove own temporary folders whose owner was killed together with its watchman."""
    for folder in Path(tempfile.gettempdir()).glob(f"{PREFIX}*") if hasattr(os, "getuid") else ():
        with contextlib.suppress(OSError):  # in use, of somebody else, or gone meanwhile
            about = folder.lstat()
            private = stat.S_ISDIR(about.st_mode) and stat.S_IMODE(about.st_mode) == stat.S_IRWXU
            if private and about.st_uid == os.getuid() and time.time() - about.st_mtime > LEFT_S:
                lock = locked(folder)
                if lock is not None:
                    shutil.rmtree(folder, ignore_errors=True)
                    os.close(lock)


def temporary_root() -> str | None:
    """Folder of the worker in which this process runs, for its temporary folders; None, the system's, elsewhere."""
    folder = os.environ.get(FOLDER)
    return folder if folder and Path(folder).is_dir() else None


@contextlib.contextmanager
def scratch_folder() -> Iterator[Path]:
    """Temporary folder that is removed at the end, also where this process is killed."""
    root = temporary_root()
    if root is not None:
        with tempfile.TemporaryDirectory(dir=root, ignore_cleanup_errors=True) as inside:
            yield Path(inside)
        return
    watchman = Watchman()
    try:
        yield Path(watchman.folder)
    finally:
        watchman.dismiss()


def marked(folder: Path) -> dict[str, str]:
    """Environment of a process that shall end with this one: one thread, and the mark of a temporary folder."""
    return os.environ | ONE_THREAD | {FOLDER: temporary_root() or str(folder)}


@contextlib.contextmanager
def kept_or_temporary(out: Path | None) -> Iterator[Path]:
    """Result folder `out`; without one a temporary folder, which is removed also after a kill."""
    if out is not None:
        yield out
        return
    with scratch_folder() as scratch:
        yield scratch
