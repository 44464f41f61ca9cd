"""Calls on the workers of a Dask cluster: sent one by one, watched, and answered in bytes that this process checks.

A call that was lost with its worker runs again on another; answers that have come are kept.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from barchain.runs.call import CallEnd, pickled, unpacked
from barchain.runs.cluster.connection import (
    CLOSE_S,
    ClusterError,
    ClusterLostError,
    connected,
    quiet,
    run_bounded,
    watched,
)
from barchain.runs.cluster.on_dask_worker import answer_call
from barchain.runs.message import MessageError
from barchain.runs.pool import Session
from barchain.runs.same_code import REMEDY, code_versions, task_fault

if TYPE_CHECKING:
    from collections.abc import Hashable

    from barchain.runs.call import Call
    from barchain.runs.cluster import DaskCluster


class DaskSession(Session):
    """A client in a thread with an event loop of its own."""

    def __init__(self, cluster: DaskCluster) -> None:
        """Start the thread."""
        super().__init__()
        self.cluster = cluster
        self.threads = 1
        """Of all workers"""
        self.sent = self.answered = 0
        self.closed = False
        self.loop = asyncio.new_event_loop()
        self.waiting: asyncio.Queue[tuple[Hashable, bytes] | None] = asyncio.Queue()
        """Calls that the loop has not taken; None ends it"""
        self.context = ExitStack()
        self.context.enter_context(quiet())
        self.thread = threading.Thread(target=self.serve, daemon=True)
        self.thread.start()

    def start(self, key: Hashable, call: Call) -> None:
        """Queue a call."""
        self.sent += 1
        self.hand_over((key, pickled(call, code_versions())))

    def close(self) -> None:
        """Forget the calls that are left, and end the connection."""
        self.hand_over(None)
        self.thread.join(3.0 * CLOSE_S)
        self.context.close()

    def hand_over(self, one: tuple[Hashable, bytes] | None) -> None:
        """Queue something for the loop."""
        with contextlib.suppress(RuntimeError):  # the loop has ended with an error, which the next answer tells
            self.loop.call_soon_threadsafe(self.waiting.put_nowait, one)

    def side_by_side(self) -> int:
        """Threads of all workers."""
        return self.threads

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
        """Connect, and make calls until the session is closed, the scheduler is lost, or a call fails."""
        async with connected(self.cluster) as client:
            taken = asyncio.ensure_future(self.waiting.get())
            at_work: set[asyncio.Future[Any]] = {
                taken,
                asyncio.ensure_future(watched(client, self.cluster, self.note_threads)),
            }
            try:
                while not self.closed:
                    ended, at_work = await asyncio.wait(at_work, return_when=asyncio.FIRST_COMPLETED)
                    for task in ended:
                        found = task.result()
                        if task is taken:
                            self.closed = found is None
                            taken = asyncio.ensure_future(self.waiting.get())
                            at_work.add(taken)
                            if found is not None:
                                at_work.add(asyncio.ensure_future(self.answer(client, *found)))
            finally:
                self.closed = True
                for task in at_work:
                    task.cancel()
                await asyncio.wait(at_work, timeout=CLOSE_S)

    def note_threads(self, threads: int) -> None:
        """Take the number of threads of all workers."""
        self.threads = threads

    async def answer(self, client: Any, key: Hashable, call: bytes) -> None:
        """Send a call, and hand out its answer; the cluster forgets it then.

        Raises
        ------
        ClusterError
            If there is none, if it is damaged, or if the worker has other code.
        """
        future = client.submit(answer_call, call, pure=False)
        try:
            answer = unpacked(await future)
        except MessageError as error:
            raise ClusterError(f"{self.cluster}: a worker gave no answer: {error}") from None
        except (Exception, asyncio.CancelledError) as error:  # a lost scheduler cancels what it had
            if self.closed:
                raise
            lost = isinstance(error, asyncio.CancelledError) or client.status != "running"
            said = "the scheduler was lost" if lost else task_fault(error)
            raise ClusterError(f"{self.cluster}: {said}") from None
        finally:
            with contextlib.suppress(Exception):
                future.release()
        if answer.end is CallEnd.OTHER_CODE:
            raise ClusterError(f"{self.cluster}: a worker {answer.reason}; {REMEDY}")
        self.answered += 1
        self.done.put((key, answer))
