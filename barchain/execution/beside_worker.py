"""Functions that a Dask worker calls: they hand calls to a process beside the worker, and replace it if it dies."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import subprocess
import sys
import threading
from typing import TYPE_CHECKING

from barchain.execution.call import Answer, CallEnd, WrongWorkerError
from barchain.execution.host import OTHER
from barchain.execution.wire import joined, packed_answers, parted, read_frame, unpacked_answers, write_frame

if TYPE_CHECKING:
    from collections.abc import Mapping

COMMAND = [sys.executable, "-m", "barchain.execution.host"]
ATTEMPTS = 2
END_S = 5.0  # for a process to end in order


class HostLostError(RuntimeError):
    """Raised where the process beside a worker died, or has other code."""


class Host:
    """A process beside this worker."""

    def __init__(self) -> None:
        """Start it, with the modules that this process can import."""
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
        self.process = subprocess.Popen(
            COMMAND, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment,
            start_new_session=True,
        )  # fmt: skip

    def ask(self, request: bytes) -> bytes:
        """Reply to a request.

        Raises
        ------
        HostLostError
            If the process dies.
        """
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        try:
            write_frame(self.process.stdin, request)
            found = read_frame(self.process.stdout)
        except OSError as error:
            raise HostLostError(str(error)) from None
        if found is None:
            raise HostLostError("the process beside the worker died")
        return found

    @property
    def alive(self) -> bool:
        """Whether it runs."""
        return self.process.poll() is None

    def close(self) -> None:
        """End it."""
        assert self.process.stdin is not None
        with contextlib.suppress(OSError):
            self.process.stdin.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process.wait(END_S)
        self.process.kill()
        self.process.wait()


class IdleHosts:
    """Processes that wait for a request; a worker has one for each of its threads."""

    def __init__(self) -> None:
        self.lock, self.hosts = threading.Lock(), list[Host]()

    def take(self) -> Host:
        """An idle process, or a new one."""
        with self.lock:
            while self.hosts:
                host = self.hosts.pop()
                if host.alive:
                    return host
        return Host()

    def give_back(self, host: Host) -> None:
        """Keep a process for the next request."""
        with self.lock:
            self.hosts.append(host)

    def close(self) -> None:
        """End all idle processes: they may have old code."""
        with self.lock:
            hosts, self.hosts = self.hosts, []
        for host in hosts:
            host.close()


IDLE = IdleHosts()


def answer_calls(versions: bytes, content: bytes) -> bytes:
    """Answers to calls, on a worker.

    Parameters
    ----------
    versions : bytes
        :func:`barchain.execution.code_versions.code_versions` of the sender, as JSON.
    content : bytes
        Calls from :func:`barchain.execution.call.pickled`, joined.

    Returns
    -------
    bytes
        From :func:`barchain.execution.wire.packed_answers`. Calls that killed the process beside the worker twice are
        answered as dead.

    Raises
    ------
    WrongWorkerError
        If the worker has other code than the sender.
    """
    calls = parted(content)
    try:
        return replied(joined([versions, *calls]))
    except HostLostError as error:
        if len(calls) > 1:  # one of them is to blame
            alone = [unpacked_answers(answer_calls(versions, joined([call])), 1) for call in calls]
            return packed_answers([answer for (answer,) in alone])
        reason = f"its process died with the process that started it, {ATTEMPTS} times ({error})"
        return packed_answers([Answer(end=CallEnd.DIED, reason=reason)])


async def worker_versions() -> dict[str, str]:
    """Versions that decide results, in a fresh process beside this worker, whose event loop goes on meanwhile."""
    return await asyncio.to_thread(fresh_versions)


def fresh_versions() -> dict[str, str]:
    """Versions that decide results, in a fresh process."""
    IDLE.close()
    found: dict[str, str] = json.loads(replied(joined([b""])))
    return found


def replied(request: bytes) -> bytes:
    """Reply to a request; a process that dies, or has old code in memory, is replaced once."""
    failure: Exception = HostLostError("no process could be started")
    for _ in range(ATTEMPTS):
        host = IDLE.take()
        try:
            kind, content = parted(host.ask(request))
        except HostLostError as error:
            failure = error
            host.close()
            continue
        if kind != OTHER:
            IDLE.give_back(host)
            return content
        failure = WrongWorkerError(content.decode())
        host.close()
        IDLE.close()
    raise failure


def versions_text(versions: Mapping[str, str]) -> bytes:
    """Versions as they are sent."""
    return json.dumps(dict(versions)).encode("ascii")
