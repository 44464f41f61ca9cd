"""Ask an engine of another package, and get an answer or one line on why there is none."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import tempfile
import threading
import time
from dataclasses import dataclass, field
from multiprocessing import connection, forkserver
from pathlib import Path
from typing import TYPE_CHECKING, Any

import psutil

from barchain.boundary.contexts import FORK_SERVER
from barchain.boundary.limits import OutsideLimits
from barchain.boundary.message import MessageError, plain_text, read_message
from barchain.boundary.phase import QUESTION, late_words
from barchain.boundary.supervisor import ANSWER, END, last_words, supervise
from barchain.boundary.threads import one_thread_each, temporary_root

if TYPE_CHECKING:
    from collections.abc import Iterator
    from multiprocessing.context import ForkServerContext
    from multiprocessing.process import BaseProcess as Process

    from adapters.trajectory import Array

START_S = 30.0  # for the server to import barchain, once, and to fork
STARTS = 2
GRACE_S = 5.0  # for the supervisor to end its processes after a limit
LOOK_S = 0.2  # between looks whether the comparison was interrupted
PRELOADED = ["barchain.boundary.supervisor"]


class Stop:
    """Request to end all questions: a comparison that is interrupted does not wait for its engines."""

    def __init__(self) -> None:
        self.event = threading.Event()

    @contextlib.contextmanager
    def armed(self) -> Iterator[None]:
        """Questions inside this context end if :meth:`set` is called; it is cleared at the end."""
        self.event.clear()
        try:
            yield
        finally:
            self.event.clear()

    def set(self) -> None:
        """End all questions."""
        self.event.set()


STOP = Stop()


@dataclass(frozen=True)
class Reply:
    """Answer of an engine's process, or the reason why there is none."""

    header: dict[str, Any] = field(default_factory=dict)
    arrays: dict[str, Array] = field(default_factory=dict)
    problem: str = ""
    """Reason without an answer, in one line; empty with one"""
    kind: str = ""
    """``missing``, ``failed``, ``timed_out``; empty with an answer"""
    rejected: bool = False
    """Whether the engine rejected the scene before its first step"""


def ask(question: str, *given: Any, limits: OutsideLimits | None = None) -> Reply:
    """Ask an engine in a process of its own.

    Parameters
    ----------
    question : str
        Name of a function in :mod:`barchain.boundary.questions` or :mod:`barchain.boundary.examination`.
    *given : Any
        Its arguments.
    limits : OutsideLimits, optional

    Returns
    -------
    Reply
        Never raises for what the engine does.
    """
    limits = limits or OutsideLimits()
    if not hasattr(os, "fork"):
        return Reply(problem="engines of other packages need a system that forks: Linux or macOS", kind="failed")
    with one_thread_each(), tempfile.TemporaryDirectory(dir=temporary_root(), ignore_cleanup_errors=True) as folder:
        process = started(folder, limits, question, given)
        if process is None:
            return Reply(problem="no process could be started: the server of processes does not answer", kind="failed")
        waited = wait(process, limits.time_s)
        if not (waited and (Path(folder) / END).is_file()):
            end_strays(folder)
        return reply(Path(folder), limits, waited)


def started(folder: str, limits: OutsideLimits, question: str, given: tuple[Any, ...]) -> Process | None:
    """Supervisor of a question; None if the server starts none, also after the server was replaced.

    An engine may have stopped or killed the server, and starting waits for the server's answer without limit.
    """
    for _ in range(STARTS):
        process = server().Process(target=supervise, args=(folder, limits, question, given))
        failed: list[BaseException] = []
        thread = threading.Thread(target=start, args=(process, failed), daemon=True)
        thread.start()
        thread.join(START_S)
        if not thread.is_alive() and not failed:
            return process
        if thread.is_alive():
            end_server()
            thread.join(GRACE_S)
    return None


def start(process: Process, failed: list[BaseException]) -> None:
    """Start a process; a failure is added to a list."""
    try:
        process.start()
    except (OSError, EOFError) as error:
        failed.append(error)


def end_server() -> None:
    """Kill the server of processes; the next start makes another."""
    pid = vars(vars(forkserver)["_forkserver"]).get("_forkserver_pid")
    if pid is not None:
        with contextlib.suppress(OSError):
            os.kill(pid, signal.SIGKILL)


def end_strays(folder: str) -> None:
    """Kill the processes that work in a question's folder: their supervisor died before it could."""
    for process in psutil.process_iter():
        with contextlib.suppress(psutil.Error, OSError):
            if process.cwd().startswith(folder) or process.environ().get(QUESTION) == folder:
                process.kill()


def server() -> ForkServerContext:
    """Server that forks supervisors; it has loaded barchain and no engine."""
    FORK_SERVER.set_forkserver_preload(PRELOADED)
    return FORK_SERVER


def wait(process: Process, time_s: float) -> bool:
    """Wait for a supervisor's end, or end it; whether it ended by itself."""
    until = time.monotonic() + time_s + GRACE_S
    while process.is_alive() and time.monotonic() < until and not STOP.event.is_set():
        connection.wait([process.sentinel], LOOK_S)
    in_time = not process.is_alive()
    for end in (process.terminate, process.kill):
        if process.is_alive():
            end()
            process.join(GRACE_S)
    if process.is_alive():  # its end is told by the server, which an engine may have stopped
        end_server()
        process.join(GRACE_S)
    with contextlib.suppress(ValueError):
        process.close()
    return in_time


def reply(folder: Path, limits: OutsideLimits, in_time: bool) -> Reply:
    """Answer from a supervisor's folder."""
    ended = read_end(folder) if in_time else {"limit": "time", "words": late_words(folder, limits.time_s)}
    if "limit" in ended:
        kind = "timed_out" if ended["limit"] == "time" else "failed"
        return Reply(problem=str(ended["words"]), kind=kind)
    if "lost" in ended or not (folder / ANSWER).is_file():
        return Reply(problem=f"its process {ended['how']} and gave no result{last_words(folder)}", kind="failed")
    try:
        header, arrays = read_message(folder / ANSWER)
    except MessageError as error:
        return Reply(problem=str(error), kind="failed")
    return failed_reply(header) if "failed" in header else Reply(header, arrays)


def failed_reply(header: dict[str, Any]) -> Reply:
    """Reply of an engine whose code raised an exception."""
    kind = "missing" if header["failed"] == "missing" else "failed"
    rejected = bool(header.get("rejected")) and header.get("phase") == "build"
    return Reply(problem=plain_text(header.get("words", "")), kind=kind, rejected=rejected)


def read_end(folder: Path) -> dict[str, Any]:
    """End of an engine's process, as its supervisor tells it."""
    try:
        found: dict[str, Any] = json.loads((folder / END).read_text(encoding="ascii"))
    except (OSError, ValueError):
        return {"how": "died with its supervisor", "lost": True}
    return found | {"how": describe_exit(found["code"])} if "code" in found else found


def describe_exit(code: int) -> str:
    """``died (signal 11, SIGSEGV)`` or ``ended with exit code 3``."""
    if code >= 0:
        return f"ended with exit code {code}"
    try:
        return f"died (signal {-code}, {signal.Signals(-code).name})"
    except ValueError:
        return f"died (signal {-code})"
