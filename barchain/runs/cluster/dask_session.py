"""Calls on the workers of a Dask cluster: sent one by one, watched, and answered in bytes that this process checks.

A call that was lost with its worker runs again on another; answers that have come are kept.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections import deque
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from barchain.runs.call import Answer, CallEnd, pickled, unpacked
from barchain.runs.cluster.beside_worker import answer_call
from barchain.runs.cluster.connection import (
    CLOSE_S,
    ClusterError,
    ClusterLostError,
    connected,
    quiet,
    run_bounded,
    watched,
)
from barchain.runs.message import MessageError
from barchain.runs.pool import Session
from barchain.runs.versions import REMEDY, code_versions, task_fault

if TYPE_CHECKING:
    from collections.abc import Hashable

    from barchain.runs.call import Call
    from barchain.runs.cluster import DaskCluster

CALLS_PER_THREAD = 2  # at the cluster: a worker has the next one when it ends one


class DaskSession(Session):
    """A client in a thread with an event loop of its own."""

    def __init__(self, cluster: DaskCluster) -> None:
        """Prepare; the thread starts when the session is entered."""
        super().__init__()
        self.cluster = cluster
        self.waiting: deque[tuple[Hashable, bytes]] = deque()
        self.threads = 1
        """Of all workers"""
        self.sent = self.answered = 0
        self.closed = False
        self.loop = asyncio.new_event_loop()
        self.events: asyncio.Queue[asyncio.Task[Any] | None] = asyncio.Queue()
        self.context = ExitStack()
        self.context.enter_context(quiet())
        self.thread = threading.Thread(target=self.serve, daemon=True)
        self.thread.start()

    def start(self, key: Hashable, call: Call) -> None:
        """Queue a call."""
        self.sent += 1
        self.waiting.append((key, pickled(call, code_versions())))
        self.wake()

    def close(self) -> None:
        """Forget the calls that are left, and end the connection."""
        self.closed = True
        self.wake()
        self.thread.join(3.0 * CLOSE_S)
        self.context.close()

    def side_by_side(self) -> int:
        """Threads of all workers."""
        return self.threads

    def wake(self) -> None:
        """Let the loop look what there is to do."""
        with contextlib.suppress(RuntimeError):  # the loop has ended with an error, which the next answer tells
            self.loop.call_soon_threadsafe(self.events.put_nowait, None)

    def serve(self) -> None:
        """Body of the thread: an error is handed to the reader of answers."""
        try:
            run_bounded(self.connection(), self.loop)
        except ClusterError as error:
            said = f"{error}; {self.answered} of {self.sent} tasks sent were done"
            self.done.put(ClusterLostError(said))
        except Exception as error:  # a fault of barchain's own
            self.done.put(error)

    async def connection(self) -> None:
        """Connect, and send calls until the session is closed."""
        async with connected(self.cluster) as client:
            at_work: dict[asyncio.Task[Any], Hashable] = {}
            watch = self.followed(watched(client, self.cluster, self.note_threads))
            try:
                while not self.closed:
                    self.fill(client, at_work)
                    ended = await self.events.get()
                    if ended is watch:
                        watch.result()
                    elif ended is not None:
                        self.deliver(at_work.pop(ended), ended, client)
            finally:
                for task in (watch, *at_work):
                    task.cancel()
                await asyncio.wait({watch, *at_work}, timeout=CLOSE_S)

    def note_threads(self, threads: int) -> None:
        """Take the number of threads of all workers; more of them get more calls."""
        if threads > self.threads:
            self.events.put_nowait(None)
        self.threads = threads

    def followed(self, work: Any) -> asyncio.Task[Any]:
        """Task that is an event when it ends."""
        task: asyncio.Task[Any] = asyncio.ensure_future(work)
        task.add_done_callback(self.events.put_nowait)
        return task

    def fill(self, client: Any, at_work: dict[asyncio.Task[Any], Hashable]) -> None:
        """Send calls, as long as workers have less than they can take."""
        while self.waiting and len(at_work) < CALLS_PER_THREAD * self.threads:
            key, call = self.waiting.popleft()
            future = client.submit(answer_call, call, pure=False)
            at_work[self.followed(result_of(future))] = key

    def deliver(self, key: Hashable, task: asyncio.Task[Any], client: Any) -> None:
        """Hand out the answer to a call.

        Raises
        ------
        ClusterError
            If there is none, if it is damaged, or if the worker has other code.
        """
        try:
            answer = unpacked(self.value_of(task, client))
        except MessageError as error:
            raise ClusterError(f"{self.cluster}: a worker gave no answer: {error}") from None
        self.need_same_code(answer)
        self.answered += 1
        self.done.put((key, answer))

    def need_same_code(self, answer: Answer) -> None:
        """Check that a call found the packages that its sender has."""
        if answer.end is CallEnd.OTHER_CODE:
            raise ClusterError(f"{self.cluster}: a worker {answer.reason}; {REMEDY}")

    def value_of(self, task: asyncio.Task[Any], client: Any) -> object:
        """Result of a call, or an error with one line."""
        error = asyncio.CancelledError("cancelled") if task.cancelled() else task.exception()
        if error is None:
            return task.result()
        if isinstance(error, asyncio.CancelledError) or client.status != "running":
            raise ClusterError(f"{self.cluster}: the scheduler was lost")
        raise ClusterError(f"{self.cluster}: {task_fault(error)}")


async def result_of(future: Any) -> Any:
    """Result of a call; the cluster forgets it then."""
    try:
        return await future
    finally:
        with contextlib.suppress(Exception):
            future.release()
