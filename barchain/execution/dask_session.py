"""Calls on the workers of a Dask cluster: sent in batches, watched, and answered in bytes that this process checks.

A batch that was lost with its worker runs again on another; answers that have come are kept.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections import deque
from contextlib import ExitStack
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from barchain.boundary.message import MessageError
from barchain.execution.beside_worker import answer_calls, versions_text
from barchain.execution.call import Answer, CallEnd, pickled
from barchain.execution.code_versions import REMEDY, code_versions, task_fault
from barchain.execution.connection import ClusterError, ClusterLostError, connected, quiet, run_bounded, watched
from barchain.execution.limits import CLOSE_S
from barchain.execution.pace import MOST_BYTES, Pace
from barchain.execution.session import Session
from barchain.execution.wire import joined, unpacked_answers

if TYPE_CHECKING:
    from collections.abc import Hashable

    from barchain.execution.address import DaskAddress
    from barchain.execution.call import Call

BATCHES_PER_THREAD = 2  # at the cluster: a worker has the next one when it ends one


@dataclass(frozen=True)
class CallBatch:
    """Calls that are sent together."""

    keys: tuple[Hashable, ...]
    calls: tuple[bytes, ...]


class DaskSession(Session):
    """A client in a thread with an event loop of its own."""

    def __init__(self, cluster: DaskAddress) -> None:
        """Prepare; the thread starts when the session is entered."""
        super().__init__()
        self.cluster, self.pace = cluster, Pace()
        self.versions = versions_text(code_versions())
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
        self.waiting.append((key, pickled(call)))
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
            at_work: dict[asyncio.Task[Any], CallBatch] = {}
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
        """Take the number of threads of all workers; more of them get more batches."""
        if threads > self.threads:
            self.events.put_nowait(None)
        self.threads = threads

    def followed(self, work: Any) -> asyncio.Task[Any]:
        """Task that is an event when it ends."""
        task: asyncio.Task[Any] = asyncio.ensure_future(work)
        task.add_done_callback(self.events.put_nowait)
        return task

    def fill(self, client: Any, at_work: dict[asyncio.Task[Any], CallBatch]) -> None:
        """Send batches, as long as workers have less than they can take."""
        while self.waiting and len(at_work) < BATCHES_PER_THREAD * self.threads:
            batch = self.next_batch()
            future = client.submit(answer_calls, self.versions, joined(batch.calls), pure=False)
            at_work[self.followed(result_of(future))] = batch

    def next_batch(self) -> CallBatch:
        """The next calls: as many as the pace allows, and not too many bytes."""
        count, size, taken = self.pace.size(len(self.waiting), self.threads), 0, list[tuple["Hashable", bytes]]()
        while self.waiting and len(taken) < count and size < MOST_BYTES:
            taken.append(self.waiting.popleft())
            size += len(taken[-1][1])
        return CallBatch(tuple(key for key, _ in taken), tuple(call for _, call in taken))

    def deliver(self, batch: CallBatch, task: asyncio.Task[Any], client: Any) -> None:
        """Hand out the answers to a batch.

        Raises
        ------
        ClusterError
            If there are none, if they are damaged, or if the worker has other code.
        """
        try:
            answers = unpacked_answers(self.value_of(task, client), len(batch.keys))
        except MessageError as error:
            raise ClusterError(f"{self.cluster}: a worker gave no answer: {error}") from None
        for key, answer in zip(batch.keys, answers, strict=True):
            self.need_same_code(answer)
            self.pace.note(answer.seconds)
            self.answered += 1
            self.done.put((key, answer))

    def need_same_code(self, answer: Answer) -> None:
        """Check that a call found the packages that its sender has."""
        if answer.end is CallEnd.OTHER_CODE:
            raise ClusterError(f"{self.cluster}: a worker {answer.reason}; {REMEDY}")

    def value_of(self, task: asyncio.Task[Any], client: Any) -> object:
        """Result of a batch, or an error with one line."""
        error = asyncio.CancelledError("cancelled") if task.cancelled() else task.exception()
        if error is None:
            return task.result()
        if isinstance(error, asyncio.CancelledError) or client.status != "running":
            raise ClusterError(f"{self.cluster}: the scheduler was lost")
        raise ClusterError(f"{self.cluster}: {task_fault(error)}")


async def result_of(future: Any) -> Any:
    """Result of a batch; the cluster forgets it then."""
    try:
        return await future
    finally:
        with contextlib.suppress(Exception):
            future.release()
