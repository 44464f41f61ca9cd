"""Supervisor of one engine process: it enforces limits, and ends every process that the engine has started.

The supervisor holds nothing of the engine. It adopts orphans (a subreaper on Linux), so that a child that detaches
itself is found and ended too. It ends by itself if the server that forked it does; the server ends with the comparing
process.
"""

from __future__ import annotations

import ctypes
import json
import os
import signal
import sys
import time
from multiprocessing import forkserver, resource_tracker
from pathlib import Path
from typing import TYPE_CHECKING, Any

import psutil

from barchain.boundary import examination, questions
from barchain.boundary.limits import FILE_B
from barchain.boundary.message import MessageError, plain_text, write_message
from barchain.boundary.phase import QUESTION, late_words
from barchain.boundary.threads import FOLDER

if TYPE_CHECKING:
    from types import ModuleType

    from barchain.boundary.limits import OutsideLimits

ANSWER, LOG, END, WORK = "answer.npz", "output.log", "end.json", "work"
MOST_FILES = 65536  # open files that are looked for
POLL_S = 0.05  # between looks at memory and output: an engine fills some 100 MB in that time
PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36
LINUX = sys.platform.startswith("linux")


def supervise(folder: str, limits: OutsideLimits, question: str, given: tuple[Any, ...]) -> None:
    """Answer a question about an engine in a child process, and write its answer and how it ended.

    Parameters
    ----------
    folder : str
        Folder for the answer, the engine's output and its working folder.
    limits : OutsideLimits
    question : str
        Name of a function in :mod:`questions` or :mod:`examination`.
    given : tuple
        Its arguments.
    """
    os.setsid()
    let_server_end()
    os.environ[FOLDER] = str(Path(folder).parent)  # the server may be older than the folder of this comparison
    process_control(PR_SET_PDEATHSIG, signal.SIGTERM)
    process_control(PR_SET_CHILD_SUBREAPER, 1)
    awaited = {signal.SIGCHLD, signal.SIGTERM, signal.SIGHUP, signal.SIGINT}
    signal.pthread_sigmask(signal.SIG_BLOCK, awaited)
    start = time.monotonic()
    engine = os.fork()
    if engine == 0:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, awaited)
        answer(Path(folder), limits, question, given)
    ended = watch(engine, Path(folder), limits, start, awaited)
    end_descendants()
    try:
        (Path(folder) / END).write_text(json.dumps(ended), encoding="ascii")
    finally:  # without a traceback where the engine has removed the folder
        os._exit(0)


def let_server_end() -> None:
    """Close this process's end of the pipe by which the server knows that the comparing process is there."""
    held = vars(forkserver)["_forkserver"]
    alive = vars(held)["_forkserver_alive_fd"]
    if alive is not None:
        os.close(alive)
        held._forkserver_alive_fd = None


def watch(
    engine: int, folder: Path, limits: OutsideLimits, start: float, awaited: set[signal.Signals]
) -> dict[str, Any]:
    """Wait for the engine's end, or the first limit that it exceeds: ``code``, or ``limit`` and words."""
    while True:
        if interrupted(awaited):
            return {"limit": "interrupted", "words": "interrupted"}
        pid, status = os.waitpid(engine, os.WNOHANG)
        if pid:
            return {"code": os.waitstatus_to_exitcode(status)}
        if (folder / ANSWER).is_file():  # threads of the engine may hold its process: the answer is there
            return {"code": 0}
        if time.monotonic() - start > limits.time_s:
            return {"limit": "time", "words": late_words(folder, limits.time_s)}
        printed = (folder / LOG).stat().st_size if (folder / LOG).exists() else 0
        if printed > limits.output_B:
            return {"limit": "output", "words": f"printed more than {limits.output_B / 2**20:.0f} MB"}
        if memory_B() > limits.memory_B:
            return {"limit": "memory", "words": f"used more than {limits.memory_B / 2**30:.3g} GB of memory"}


def interrupted(awaited: set[signal.Signals]) -> bool:
    """Wait for a signal or for the next look; whether the signal asks for the end."""
    if not hasattr(signal, "sigtimedwait"):  # macOS
        time.sleep(POLL_S)
        return bool(signal.sigpending() - {signal.SIGCHLD})
    got = signal.sigtimedwait(awaited, POLL_S)
    return got is not None and got.si_signo != signal.SIGCHLD


def memory_B() -> int:
    """Resident memory of all descendants, B."""
    total = 0
    for process in psutil.Process().children(recursive=True):
        try:
            total += process.memory_info().rss
        except psutil.Error:
            continue
    return total


def end_descendants() -> None:
    """Kill all descendants, orphans among them, until none is left."""
    while True:
        found = psutil.Process().children(recursive=True)
        for process in found:
            try:
                process.kill()
            except psutil.Error:
                continue
        try:
            while True:
                os.waitpid(-1, 0 if found else os.WNOHANG)
                found = []
        except ChildProcessError:
            return


def answer(folder: Path, limits: OutsideLimits, question: str, given: tuple[Any, ...]) -> None:
    """Answer a question in this process, which ends without running the engine's exit handlers."""
    process_control(PR_SET_PDEATHSIG, signal.SIGKILL)
    import resource  # noqa: PLC0415  # not on Windows, where no engine of another package runs

    redirect(folder / LOG)
    close_inherited()
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (FILE_B, FILE_B))
    if LINUX:
        resource.setrlimit(resource.RLIMIT_DATA, (2 * limits.memory_B, 2 * limits.memory_B))
    (folder / WORK).mkdir()
    os.chdir(folder / WORK)
    os.environ[QUESTION] = str(folder)
    path, code = folder / ANSWER, 1
    try:
        try:
            header, arrays = getattr(answering(question), question)(*given)
        except BaseException as error:  # also SystemExit, KeyboardInterrupt and GeneratorExit: all are the engine's
            header, arrays = questions.failed(error), {}
        try:
            write_message(path, header, arrays)
        except MessageError as error:
            write_message(path, questions.failed(error), {})
        code = 0
    finally:
        os._exit(code)


def answering(question: str) -> ModuleType:
    """Module whose function answers a question."""
    return questions if hasattr(questions, question) else examination


def redirect(log: Path) -> None:
    """Send the output of this process and its children to a file, and give it no input."""
    for target, path, flags in ((0, os.devnull, os.O_RDONLY), (1, log, os.O_WRONLY | os.O_CREAT | os.O_APPEND)):
        handle = os.open(path, flags, 0o600)
        os.dup2(handle, target)
        os.close(handle)
    os.dup2(1, 2)


def close_inherited() -> None:
    """Close the pipes of the server and of Python's resource tracker: they are shared with other engines."""
    import resource  # noqa: PLC0415

    os.closerange(3, min(resource.getrlimit(resource.RLIMIT_NOFILE)[0], MOST_FILES))
    tracker = vars(resource_tracker).get("_resource_tracker")
    if tracker is not None:
        tracker._fd = tracker._pid = None  # one of its own is started if the engine shares memory


def process_control(option: int, value: int) -> None:
    """Set an attribute of this process on Linux; nothing elsewhere."""
    if LINUX:
        ctypes.CDLL(None).prctl(option, int(value), 0, 0, 0)


def last_words(folder: Path) -> str:
    """Last line that an engine has printed; empty without one."""
    path = folder / LOG
    if not path.is_file():
        return ""
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - 4096))
        tail = file.read().decode("utf-8", "replace")
    said = [line for line in tail.splitlines() if line.strip()]
    return f"; last output: {plain_text(said[-1], 200)}" if said else ""
