"""Process that makes runs: ``python -m barchain.runs.worker``. It loads no engine, and forks processes that do.

A worker takes requests on one pipe and answers on another, one at a time. Each call is answered by a process that the
worker forks: calls of one pool share one, a confined call has its own. The worker ends a process that exceeds a limit,
and every process that an engine has started; it adopts orphans (a subreaper on Linux), so that a child that detaches
itself is found too. The end of the pipe ends the worker and all that belongs to it. If the worker is killed, its
watchman does that.
"""

from __future__ import annotations

import contextlib
import dataclasses
import itertools
import os
import select
import shutil
import signal
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

import psutil

from barchain.runs import run  # noqa: F401  # what every forked process has loaded already
from barchain.runs.call import (
    FILE_B,
    LENGTH,
    MEMORY_B,
    OUTPUT_B,
    Answer,
    Call,
    CallEnd,
    known_of,
    packed,
    read_frame,
    unpacked,
    write_frame,
)
from barchain.runs.child import FORKS, LOG, PR_SET_CHILD_SUBREAPER, called, process_control, serve
from barchain.runs.environment import FOLDER, Watchman
from barchain.runs.message import MessageError, plain_text
from barchain.runs.phases import entered, late_words, queue_time_s
from barchain.runs.processes import descendants, last_line, tail_of
from barchain.runs.same_code import code_versions

if TYPE_CHECKING:
    from collections.abc import Callable

KEPT_POOLS = 3  # calls of several pools come mixed: solutions, other runs, verdicts
POLL_S = 0.05  # between looks at time, memory and output: an engine fills some 100 MB in that time
READ_B = 1 << 20


class SenderGoneError(Exception):
    """Raised where the process that asks has ended, or does not want the answer any more."""


class Child:
    """A forked process that answers calls."""

    def __init__(self, folder: Path, *, confined: bool) -> None:
        """Fork it."""
        folder.mkdir()
        self.folder, self.calls = folder, 0
        self.code: int | None = None
        ours, theirs = os.pipe(), os.pipe()
        self.pid = os.fork()
        if self.pid == 0:
            serve(ours[0], theirs[1], folder, confined=confined)
        os.close(ours[0])
        os.close(theirs[1])
        self.to, self.back = ours[1], theirs[0]

    def send(self, content: bytes) -> None:
        """Hand over a call; one that died meanwhile is noticed by its missing answer."""
        self.calls += 1
        with contextlib.suppress(BrokenPipeError), os.fdopen(os.dup(self.to), "wb") as file:
            write_frame(file, content)

    def exit_code(self) -> int | None:
        """Exit code, negative after a signal; None while it lives."""
        if self.code is None:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            self.code = os.waitstatus_to_exitcode(status) if pid else None
        return self.code

    def end(self) -> None:
        """Kill it, and wait for its end."""
        if self.exit_code() is None:
            os.kill(self.pid, signal.SIGKILL)
            os.waitpid(self.pid, 0)
        for handle in (self.to, self.back):
            os.close(handle)
        shutil.rmtree(self.folder, ignore_errors=True)

    def last_words(self) -> str:
        """Last line that it has printed; empty without one."""
        path = self.folder / LOG
        if not path.is_file():
            return ""
        with path.open("rb") as file:
            said = last_line(tail_of(file))
        return f"; last output: {plain_text(said, 200)}" if said else ""


class Children:
    """Forked processes of a worker: one for each of the pools that were called last."""

    def __init__(self, folder: Path, requests: int, spared: int) -> None:
        """Start none yet; `requests` is the pipe whose end ends the worker, `spared` its watchman."""
        self.folder, self.requests, self.spared, self.numbers = folder, requests, spared, itertools.count()
        self.kept: dict[str, Child] = {}

    def answer(self, call: Call, content: bytes) -> Answer:
        """Answer to a call, of which the worker knows the limits, and the process the content."""
        start = time.monotonic()
        if not FORKS:  # the sender ends this process at the limit
            return called(content)
        child = self.child(call)
        child.send(content)
        answer: Answer | None = None
        try:
            answer = self.awaited(child, call, start)
        finally:
            again = answer is not None and answer.end in {CallEnd.ANSWERED, CallEnd.RAISED}
            if not (again and call.pool and child.calls < call.calls_per_process):
                self.end(child)
        return dataclasses.replace(answer, seconds=time.monotonic() - start)

    def child(self, call: Call) -> Child:
        """Process of a call's pool, forked at the first call; a fresh one without a pool."""
        found = self.kept.pop(call.pool, None) if call.pool else None
        if found is not None and found.exit_code() is not None:  # killed while it had no call
            self.end(found)
            found = None
        found = found or Child(self.folder / str(next(self.numbers)), confined=call.confined)
        if call.pool:
            while len(self.kept) >= KEPT_POOLS:
                self.end(self.kept.pop(next(iter(self.kept))))
            self.kept[call.pool] = found  # the last one called stands last
        return found

    def end(self, child: Child) -> None:
        """End a process, and all that it has started."""
        self.kept = {pool: other for pool, other in self.kept.items() if other is not child}
        child.end()
        self.end_strays()

    def end_strays(self) -> None:
        """Kill all descendants that no kept process has started, orphans among them, until none is left."""
        kept = {self.spared, *(child.pid for child in self.kept.values())}
        while True:
            own = psutil.Process()
            found = [p for p in own.children() if p.pid not in kept]
            found += [q for p in found for q in descendants(p.pid)]
            for process in found:
                with contextlib.suppress(psutil.Error):
                    process.kill()
            if not found:
                return
            for process in found:
                with contextlib.suppress(ChildProcessError):
                    os.waitpid(process.pid, 0)

    def awaited(self, child: Child, call: Call, start: float) -> Answer:
        """Answer of a process, or the first limit that it exceeds, or how it ended."""
        queued_s, received, poll = queue_time_s(child.pid), bytearray(), select.poll()
        poll.register(child.back, select.POLLIN)
        poll.register(self.requests, select.POLLIN)
        while True:
            ready = {handle for handle, _ in poll.poll(1e3 * POLL_S)}
            if self.requests in ready:
                raise SenderGoneError
            if child.back in ready:
                more = os.read(child.back, READ_B)
                if not more:
                    poll.unregister(child.back)
                received += more
                if (answer := whole_answer(received)) is not None:
                    return answer
                if more:
                    continue
            if child.code is not None:  # it had ended before this look at its pipe
                return ended(child, child.code, call)
            if is_late(call, time.monotonic() - start, lambda: queue_time_s(child.pid) - queued_s):
                phase = entered(child.folder)
                return Answer(end=CallEnd.TIMED_OUT, reason=late_words(phase, call.limit_s), phase=phase)
            if child.exit_code() is not None:
                continue
            if call.confined and (excess := self.excess(child)):
                return Answer(end=CallEnd.DIED, reason=excess)

    def excess(self, child: Child) -> str:
        """Words on the output or memory that a confined process takes beyond its limits; empty if none."""
        log = child.folder / LOG
        if log.exists() and log.stat().st_size > OUTPUT_B:
            return f"printed more than {OUTPUT_B / 2**20:.0f} MB"
        if memory_B(child.pid) > MEMORY_B:
            return f"used more than {MEMORY_B / 2**30:.3g} GB of memory"
        return ""

    def close(self) -> None:
        """End all processes."""
        for child in list(self.kept.values()):
            self.end(child)
        if FORKS:
            self.end_strays()


def is_late(call: Call, spent_s: float, queued_s: Callable[[], float]) -> bool:
    """Whether a call is beyond its limit; the time in which its process waited for a processor does not count.

    On a machine that other programs keep busy a sound engine would else be late. Where the system does not tell this
    time, the limit is wall time.
    """
    return spent_s > call.wall_s and (spent_s > call.most_s or spent_s - queued_s() > call.wall_s)


def memory_B(pid: int) -> int:
    """Resident memory of a process and its descendants, B."""
    total = 0
    with contextlib.suppress(psutil.Error):
        own = psutil.Process(pid)
        for process in (own, *descendants(pid)):
            with contextlib.suppress(psutil.Error):
                total += process.memory_info().rss
    return total


def whole_answer(received: bytearray) -> Answer | None:
    """Answer, once all of its bytes are there; a damaged one is a failure of its own."""
    if len(received) < LENGTH.size:
        return None
    (length,) = LENGTH.unpack_from(received)
    if length > FILE_B:
        return Answer(end=CallEnd.LOST, reason=f"its result claims {length / 2**30:.3g} GB")
    if len(received) < LENGTH.size + length:
        return None
    try:
        return unpacked(bytes(received[LENGTH.size : LENGTH.size + length]))
    except MessageError as error:
        return Answer(end=CallEnd.LOST, reason=f"its result could not be brought back: {error}")


def ended(child: Child, code: int, call: Call) -> Answer:
    """Answer for a process that ended without one."""
    if hasattr(signal, "SIGPROF") and code == -signal.SIGPROF:
        return Answer(end=CallEnd.TIMED_OUT, reason=f"no result within {call.limit_s:g} s of processor time")
    if hasattr(signal, "SIGALRM") and code == -signal.SIGALRM:
        return Answer(end=CallEnd.OWN_TIMER, reason="its own timer ended its process")
    reason = f"its process {describe_exit(code)} and gave no result{child.last_words()}"
    return Answer(end=CallEnd.DIED, reason=reason)


def describe_exit(code: int) -> str:
    """``died (signal 11, SIGSEGV)`` or ``ended with exit code 3``."""
    if code >= 0:
        return f"ended with exit code {code}"
    try:
        return f"died (signal {-code}, {signal.Signals(-code).name})"
    except ValueError:
        return f"died (signal {-code})"


def main(idle_s: float | None = None) -> None:
    """Answer requests until the pipe ends, or, where a time is given, none comes for so long."""
    requests, replies = protocol_files()
    if FORKS:
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)  # where it is ignored, as below a nanny, no end could be told
    process_control(PR_SET_CHILD_SUBREAPER, 1)
    watchman = Watchman()
    os.environ[FOLDER] = watchman.folder
    if idle_s is not None:  # beside a Dask worker: versions of the code that is loaded now, before a source changes
        code_versions()
    children = Children(Path(watchman.folder), requests.fileno(), watchman.process.pid)
    try:
        while (call := next_call(requests, idle_s)) is not None:
            write_frame(replies, packed(children.answer(*known_of(call))))
    except (SenderGoneError, BrokenPipeError):
        pass
    finally:
        children.close()
        watchman.dismiss()


def protocol_files() -> tuple[BinaryIO, BinaryIO]:
    """Pipes to the sender; all else that is printed here is dropped."""
    found = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    for target, flags in ((0, os.O_RDONLY), (1, os.O_WRONLY)):
        handle = os.open(os.devnull, flags)
        os.dup2(handle, target)
        os.close(handle)
    return found


def next_call(requests: BinaryIO, idle_s: float | None) -> bytes | None:
    """Next call; None at the end."""
    if idle_s is not None and not select.select([requests], [], [], idle_s)[0]:
        return None
    return read_frame(requests)


if __name__ == "__main__":
    main(*map(float, sys.argv[1:]))
