"""Programs that run to their end in a process of their own: Git, installers, other Pythons, commands of barchain."""

from __future__ import annotations

import contextlib
import signal
import subprocess
import tempfile
import threading
import time
from contextlib import ExitStack
from dataclasses import dataclass
from typing import TYPE_CHECKING

import psutil

from barchain.runs.environment import OWN_PYTHON, NoProcessError, marked, scratch_folder, start

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence
    from pathlib import Path
    from typing import IO

PROGRAM = (*OWN_PYTHON, "-m", "barchain")
GRACE_S = 20.0
"""Time in which an interrupted study ends its runs and writes its record"""
LOOK_S = 0.1
GIT_S = 120.0
LONGEST_TAIL = 4096
"""Bytes of the end of an output that are searched for the last line"""
LONGEST = 300
STUDY_ENDS = (0, 1)
"""Exit codes of a study that came to its end, without and with findings"""
NOT_STARTED = 127
"""Exit code of a program that is not there, as shells have it"""


@dataclass(frozen=True)
class Finished:
    """End of a program."""

    code: int | None
    """Exit code, negative of a signal; None if the time limit ended the program"""
    duration_s: float
    reason: str = ""
    """One line on a bad end: the limit, or the last line that the program said; empty of a good end"""
    content: bytes = b""
    """Standard output; empty where a log has it"""
    said: str = ""
    """End of the text on standard error, or of the output where that is empty"""

    @property
    def output(self) -> str:
        """Standard output as text."""
        return self.content.decode("utf-8", "replace")

    @property
    def interrupted(self) -> bool:
        """Whether the time limit ended the program."""
        return self.code is None

    @property
    def failed(self) -> bool:
        """Whether a command of barchain ended by an error of its own."""
        return self.code is not None and self.code not in STUDY_ENDS


def run(
    command: Sequence[str | Path],
    *,
    limit_s: float,
    given: str = "",
    folder: Path | None = None,
    variables: Mapping[str, str] | None = None,
    log: Path | None = None,
    grace_s: float = 0.0,
    tick: Callable[[float], None] = lambda _: None,
    good: Sequence[int] = (0,),
) -> Finished:
    """Run a program; what it does is never an exception here.

    Parameters
    ----------
    command : sequence of str or Path
    limit_s : float
        Wall time after which the program is ended with all that it has started, s.
    given : str
        Text on its standard input.
    folder : Path, optional
        Its working folder.
    variables : mapping, optional
        Its environment.
    log : Path, optional
        File to which its output is added.
    grace_s : float
        Time that the program has after an interruption as by Ctrl-C, s; 0 kills it at once.
    tick : callable
        Called with the time so far, s, several times a second.
    good : sequence of int
        Exit codes of a good end.

    Notes
    -----
    Output goes to files, so that children which the program leaves behind delay nothing. An exception in `tick`, and
    Ctrl-C, end the program too.
    """
    begun = time.monotonic()
    with ExitStack() as files:
        source, sink, errors = (files.enter_context(tempfile.TemporaryFile()) for _ in range(3))
        if log is not None:
            log.parent.mkdir(parents=True, exist_ok=True)
            sink = errors = files.enter_context(log.open("a+b"))
        source.write(given.encode())
        source.seek(0)
        try:
            with interruptible():
                process = start(
                    command, given=source, output=sink, errors=errors, folder=folder, variables=variables
                )  # fmt: skip
        except NoProcessError:
            raise
        except OSError as error:
            return Finished(NOT_STARTED, 0.0, f"{command[0]} does not start: {error.strerror}")
        try:
            while process.poll() is None and (spent_s := time.monotonic() - begun) < limit_s:
                tick(spent_s)
                with contextlib.suppress(subprocess.TimeoutExpired):
                    process.wait(min(LOOK_S, limit_s - spent_s))
            late = process.poll() is None
        finally:
            end(process, grace_s)
        duration_s = time.monotonic() - begun
        said = tail_of(errors).strip() or tail_of(sink).strip()
        sink.seek(0)
        content = b"" if log is not None else sink.read()
    if late:
        return Finished(None, duration_s, f"did not end within {limit_s:.0f} s", content, said)
    code = process.returncode
    return Finished(code, duration_s, "" if code in good else reason_of(code, last_line(said)), content, said)


def run_barchain(
    arguments: Sequence[str],
    log: Path,
    limit_s: float,
    tick: Callable[[float], None] = lambda _: None,
    grace_s: float | None = None,
) -> Finished:
    """Run a command of barchain, which is interrupted at its limit: studies keep their results then.

    Parameters are those of :func:`run`; `grace_s` is :data:`GRACE_S` by default. If this process is killed, its
    watchman ends the command and all of its processes.
    """
    grace_s = GRACE_S if grace_s is None else grace_s
    with scratch_folder() as folder:
        return run(
            [*PROGRAM, *arguments], limit_s=limit_s, variables=marked(folder), log=log, grace_s=grace_s, tick=tick,
            good=STUDY_ENDS,
        )  # fmt: skip


class GitError(RuntimeError):
    """Raised where Git gives no answer; the message is one line."""


def git(folder: Path, *arguments: str) -> bytes:
    """Output of a command of Git in the repository that holds a folder.

    Raises
    ------
    GitError
        With its last words.
    """
    done = run(["git", "-C", folder, *arguments], limit_s=GIT_S)
    if done.code == NOT_STARTED:
        raise GitError("Git is not installed")
    if done.reason:
        raise GitError(done.reason)
    return done.content


@contextlib.contextmanager
def interruptible() -> Iterator[None]:
    """Let processes that are started here be interrupted.

    A shell starts commands in the background so that they ignore Ctrl-C, and processes hand that on to those that they
    start: a study would not end at its limit.
    """
    ignored = signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    if not ignored or threading.current_thread() is not threading.main_thread():
        yield
        return
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def end(process: subprocess.Popen[bytes], grace_s: float = 0.0) -> None:
    """End a process that still runs, and all that it has started; with `grace_s` it is interrupted first."""
    if process.poll() is not None:
        return
    own = [psutil.Process(process.pid), *descendants(process.pid)]
    if grace_s:
        process.send_signal(signal.SIGINT)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(grace_s)
            return
    for one in own:
        with contextlib.suppress(psutil.Error):
            one.kill()
    process.wait()


def descendants(pid: int) -> list[psutil.Process]:
    """Processes that a process has started, and those that they have started."""
    with contextlib.suppress(psutil.Error):
        return psutil.Process(pid).children(recursive=True)
    return []


def reason_of(code: int, said: str) -> str:
    """Reason of a bad end in one line."""
    if code < 0:
        return f"ended by signal {-code}" + (f": {said}" if said else "")
    return said or f"ended with exit code {code}"


def tail_of(file: IO[bytes]) -> str:
    """End of a file as text."""
    file.seek(max(file.seek(0, 2) - LONGEST_TAIL, 0))
    return file.read().decode("utf-8", "replace")


def last_line(text: str) -> str:
    """Last line that is not empty, without the command's name."""
    found = next((line.strip() for line in reversed(text.splitlines()) if line.strip()), "")
    return "".join(c for c in found if c.isprintable()).removeprefix("barchain: ")[:LONGEST]
