"""Process that a worker forks: it answers calls, one after the other, and keeps what it has loaded.

Its output goes to a file, so that the last words of a process that dies are known. A confined process runs an engine of
another package: it has limits that the system enforces, a working folder of its own, and answers one call.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import pickle
import signal
import sys
from typing import TYPE_CHECKING, Any

from adapters.engine import EngineError
from barchain.runs.call import FILE_B, MEMORY_B, Answer, CallEnd, WrongWorkerError, packed, read_frame, write_frame
from barchain.runs.message import plain_text
from barchain.runs.phases import PHASE, QUESTION, process_ended_after
from barchain.runs.same_code import code_versions, difference

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

LOG, WORK = "output.log", "work"
MOST_FILES = 65536  # open files that are looked for
HIGH = 512  # descriptors from here on: an engine that writes to or closes all low ones meets none of the pipes
PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36
LINUX = sys.platform.startswith("linux")
FORKS = hasattr(os, "fork")


def serve(requests: int, answers: int, folder: Path, *, confined: bool) -> None:
    """Answer calls from a descriptor on another, until it ends; this process ends without any exit handler."""
    code = 1
    try:
        os.setsid()  # a signal to its group does not reach the worker
        process_control(PR_SET_PDEATHSIG, signal.SIGKILL)
        redirect(folder / LOG)
        requests, answers = raised(requests), raised(answers)
        close_others(requests, answers)
        os.environ[QUESTION] = str(folder)
        if confined:
            confine(folder)
        with os.fdopen(requests, "rb") as source, os.fdopen(answers, "wb") as sink:
            while (content := read_frame(source)) is not None:
                os.truncate(folder / LOG, 0)
                (folder / PHASE).unlink(missing_ok=True)
                write_frame(sink, packed(called(content)))
        code = 0
    finally:
        os._exit(code)


def redirect(log: Path) -> None:
    """Send the output of this process and its children to a file, and give it no input."""
    for target, path, flags in ((0, os.devnull, os.O_RDONLY), (1, log, os.O_WRONLY | os.O_CREAT | os.O_APPEND)):
        handle = os.open(path, flags, 0o600)
        os.dup2(handle, target)
        os.close(handle)
    os.dup2(1, 2)


def raised(handle: int) -> int:
    """Descriptor of the same file with a high number; the same where so many are not allowed."""
    import fcntl  # noqa: PLC0415  # not on Windows, where nothing forks

    try:
        return fcntl.fcntl(handle, fcntl.F_DUPFD, HIGH)
    except OSError:
        return handle


def close_others(*kept: int) -> None:
    """Close what a fork inherits beside the standard streams: the pipes of the worker and of its other processes."""
    last = 2
    for handle in sorted(kept):
        os.closerange(last + 1, handle)
        last = handle
    os.closerange(last + 1, MOST_FILES)


def confine(folder: Path) -> None:
    """Let the system enforce limits of memory and of file sizes, and begin in an empty folder."""
    import resource  # noqa: PLC0415  # not on Windows, where no engine of another package runs

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (FILE_B, FILE_B))
    if LINUX:
        resource.setrlimit(resource.RLIMIT_DATA, (2 * MEMORY_B, 2 * MEMORY_B))
    (folder / WORK).mkdir()
    os.chdir(folder / WORK)


def process_control(option: int, value: int) -> None:
    """Linux: signal to this process at its parent's death, or adoption of orphans; nothing elsewhere."""
    if LINUX:
        ctypes.CDLL(None).prctl(option, int(value), 0, 0, 0)


def called(content: bytes) -> Answer:
    """Answer to a call of a trusted sender: versions, function, arguments, and a limit of processor time, pickled."""
    try:
        versions, function, given, processor_s = pickle.loads(content)
    except Exception as error:
        reason = f"can't load a call ({type(error).__name__}: {plain_text(error, 160)})"
        return Answer(end=CallEnd.OTHER_CODE, reason=reason)
    if versions is not None and (differs := difference(code_versions(), versions)):
        return Answer(end=CallEnd.OTHER_CODE, reason=differs)
    with process_ended_after(processor_s, processor=True):
        return answered(function, given)


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
    finally:
        flush()


def flush() -> None:
    """Write out what is held back; output that can't be written costs no run."""
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError, AttributeError):  # no room, closed, or none
            stream.flush()
