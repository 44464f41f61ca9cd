"""Commands as processes of their own: with a time limit, a log, and the reason of a bad end in one line."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

import psutil

from barchain.runs.environment import one_thread_each

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from pathlib import Path

    from barchain.nightly.environments import PinnedEnvironment


PROGRAM = (sys.executable, "-m", "barchain")
GRACE_S = 20.0
"""Time in which an interrupted study ends its runs and writes its record"""
LOOK_S = 0.1
LONGEST_TAIL = 4096
"""Bytes of the end of a log that are searched for the last line"""
KNOWN = (0, 1)
"""Exit codes of a study that came to its end, without and with findings"""


@dataclass(frozen=True)
class ChildEnd:
    """End of a job's process."""

    code: int | None
    """Exit code; None if the time limit ended the process"""
    duration_s: float
    reason: str = ""
    """Last line of a process that failed"""

    @property
    def interrupted(self) -> bool:
        """Whether the time limit ended the process."""
        return self.code is None

    @property
    def failed(self) -> bool:
        """Whether the process ended by an error of its own."""
        return self.code is not None and self.code not in KNOWN


def run_barchain(
    arguments: Sequence[str],
    log: Path,
    limit_s: float,
    tick: Callable[[float], None] = lambda _: None,
    grace_s: float | None = None,
) -> ChildEnd:
    """Run a command of barchain in a process of its own.

    Parameters
    ----------
    arguments : sequence of str
        Command and options.
    log : Path
        File for what the command prints.
    limit_s : float
        Wall time after which the command is interrupted as by Ctrl-C, s: studies keep their results then.
    tick : callable
        Called with the time so far, s, several times a second.
    grace_s : float, optional
        Time in which an interrupted command has to end, s, before it is killed; default: :data:`GRACE_S`.

    Notes
    -----
    If the calling process is killed, its watchman ends the command and all of its processes.
    """
    start = time.monotonic()
    log.parent.mkdir(parents=True, exist_ok=True)
    with one_thread_each(), log.open("ab") as file:
        with interruptible():
            process = subprocess.Popen(
                [*PROGRAM, *arguments],
                stdin=subprocess.DEVNULL, stdout=file, stderr=subprocess.STDOUT, start_new_session=True,
            )  # fmt: skip
        try:
            while process.poll() is None and time.monotonic() - start < limit_s:
                tick(time.monotonic() - start)
                time.sleep(LOOK_S)
            late = process.poll() is None
        finally:
            interrupt(process, GRACE_S if grace_s is None else grace_s)
    duration_s = time.monotonic() - start
    if late:
        return ChildEnd(None, duration_s)
    said = last_line(log) if process.returncode not in KNOWN else ""
    return ChildEnd(process.returncode, duration_s, reason_of(process.returncode, said))


@contextlib.contextmanager
def interruptible() -> Iterator[None]:
    """Let processes that are started here be interrupted.

    A shell starts commands in the background so that they ignore Ctrl-C, and processes hand that on to those that they
    start: a job would not end at its limit.
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


def interrupt(process: subprocess.Popen[bytes], grace_s: float) -> None:
    """End a process that still runs: as by Ctrl-C, and by force if it does not end in time."""
    if process.poll() is not None:
        return
    own = [psutil.Process(process.pid), *descendants(process.pid)]
    process.send_signal(signal.SIGINT)
    try:
        process.wait(grace_s)
    except subprocess.TimeoutExpired:
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
    """Reason of a bad end in one line; empty of a good one."""
    if code in KNOWN:
        return ""
    if code < 0:
        return f"ended by signal {-code}" + (f": {said}" if said else "")
    return said or f"ended with exit code {code}"


def last_line(log: Path) -> str:
    """Last line of a log that is not empty, without the command's name."""
    with log.open("rb") as file:
        file.seek(max(file.seek(0, 2) - LONGEST_TAIL, 0))
        lines = file.read().decode("utf-8", "replace").splitlines()
    found = next((line.strip() for line in reversed(lines) if line.strip()), "")
    return "".join(c for c in found if c.isprintable()).removeprefix("barchain: ")[:300]


LONGEST = 300
REMOVED = ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV")


@dataclass(frozen=True)
class Finished:
    """End of a command."""

    code: int
    """Exit code; negative of a signal"""
    output: str
    reason: str = ""
    """Last line of a command that failed, or its time limit"""


def run_in(
    environment: PinnedEnvironment, tree: Path, arguments: Sequence[str], *, limit_s: float, folder: Path
) -> Finished:
    """Run Python with a tree of barchain's sources in an environment.

    Parameters
    ----------
    environment : PinnedEnvironment
    tree : Path
        Folder of barchain's packages.
    arguments : sequence of str
        Of Python, e.g. ``("-m", "barchain", "compare", ...)``.
    limit_s : float
        Wall time after which all processes of the command are killed, s.
    folder : Path
        Working folder.
    """
    variables = {name: value for name, value in os.environ.items() if name not in REMOVED}
    with one_thread_each():
        variables |= {k: v for k, v in os.environ.items() if k not in REMOVED} | {"PYTHONPATH": str(tree)}
        process = subprocess.Popen(
            [str(environment.python), *arguments], cwd=folder, env=variables, stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
        )  # fmt: skip
        try:
            output = process.communicate(timeout=limit_s)[0].decode("utf-8", "replace")
        except subprocess.TimeoutExpired:
            end(process)
            return Finished(-signal.SIGKILL, "", f"did not end within {limit_s:.0f} s")
        except BaseException:
            end(process)
            raise
    code = process.returncode
    return Finished(code, output, last_output_line(output) if code else "")


def end(process: subprocess.Popen[bytes]) -> None:
    """Kill a process and all that it has started."""
    with contextlib.suppress(psutil.Error):
        for child in psutil.Process(process.pid).children(recursive=True):
            with contextlib.suppress(psutil.Error):
                child.kill()
    process.kill()
    process.communicate()


def last_output_line(output: str) -> str:
    """Last line with text, without the command's name."""
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    return "".join(c for c in (lines[-1] if lines else "") if c.isprintable()).removeprefix("barchain: ")[:LONGEST]
