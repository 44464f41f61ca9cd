"""Tasks on a Dask cluster: every fault of the cluster is one line within a stated time, and nothing of Dask stays.

The client lives in an event loop of this module's own, without threads of Dask. A watch beside the tasks asks the
scheduler for its state, so that a fault is not waited for longer than :mod:`barchain.studies.ensemble.limits` says.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import socket
import warnings
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar
from urllib.parse import urlsplit

from barchain.boundary.message import plain_text
from barchain.studies.ensemble.cluster_code import code_fault, code_versions, protocol_fault, task_fault
from barchain.studies.ensemble.limits import ANSWER_S, CLOSE_S, SILENT_S, WORKERS_S

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Coroutine, Iterator, Mapping

T = TypeVar("T")
LOOK_S = 1.0  # between looks at the scheduler
TALKATIVE = ("distributed", "tornado", "tornado.application", "tornado.general", "asyncio")


class ClusterError(RuntimeError):
    """Raised for a Dask cluster that can't be used; nothing was run."""


class ClusterLostError(ClusterError):
    """Raised for a Dask cluster that failed while tasks ran."""


@dataclass(frozen=True)
class DaskAddress:
    """Scheduler and patience."""

    address: str
    workers_s: float = WORKERS_S
    """Longest time without any worker"""

    def __str__(self) -> str:
        return f"--dask {self.address}"


def check_cluster(cluster: DaskAddress) -> None:
    """Check that a scheduler answers, that workers are there, and that all have the code that is here.

    Raises
    ------
    ClusterError
        With one line on the first fault.
    """
    run_loop(checked(cluster))


def run_on_cluster(
    cluster: DaskAddress, function: Callable[..., Any], tasks: Mapping[int, Any], keep: Callable[[int, Any], None]
) -> None:
    """Run ``function(task, versions)`` for each task on the cluster; `keep` gets each result as it comes.

    Raises
    ------
    ClusterLostError
        If the cluster fails; results so far have been kept.
    """
    run_loop(sent(cluster, function, tasks, keep))


def run_loop(work: Coroutine[Any, Any, None]) -> None:
    """Run a coroutine to its end, beside an event loop that may run already, as in a notebook."""
    with quiet():
        try:
            asyncio.get_running_loop()
        except RuntimeError:
            run_bounded(work)
            return
        with ThreadPoolExecutor(1) as thread:
            thread.submit(run_bounded, work).result()


def run_bounded(work: Coroutine[Any, Any, None]) -> None:
    """Run a coroutine as ``asyncio.run`` does, and wait for tasks that it leaves for a limited time only."""
    loop = asyncio.new_event_loop()
    loop.set_exception_handler(lambda *_: None)  # tasks of a client whose scheduler is gone
    try:
        loop.run_until_complete(work)
    finally:
        left = asyncio.all_tasks(loop)
        for task in left:
            task.cancel()
        if left:
            loop.run_until_complete(asyncio.wait(left, timeout=CLOSE_S))
        loop.run_until_complete(loop.shutdown_asyncgens())
        loop.close()


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Keep what Dask says of lost connections from the terminal: the error of this module tells it."""
    import_distributed()  # it sets up its loggers when it is imported
    names = [n for n in logging.root.manager.loggerDict if n.partition(".")[0] == "distributed"]
    loggers = [logging.getLogger(name) for name in dict.fromkeys((*TALKATIVE, *names))]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


def import_distributed() -> Any:
    """Module of Dask's cluster.

    Raises
    ------
    ClusterError
        If it is not installed.
    """
    try:
        import distributed  # noqa: PLC0415  # an extra
    except ImportError:
        raise ClusterError("--dask: distributed is not installed; try: pip install '.[cluster]'") from None
    return distributed


async def checked(cluster: DaskAddress) -> None:
    """Body of :func:`check_cluster`."""
    async with connected(cluster) as client:
        await workers_there(client, cluster)
        fault = protocol_fault(await answered(cluster, client.get_versions()))
        fault = fault or code_fault(await answered(cluster, client.run(code_versions, on_error="return")))
    if fault:
        raise ClusterError(f"{cluster}: {fault}")


@contextlib.asynccontextmanager
async def connected(cluster: DaskAddress) -> AsyncIterator[Any]:
    """Client of the scheduler; it is closed at the end, also if the scheduler is gone.

    Raises
    ------
    ClusterError
        If no scheduler answers.
    """
    look_up(cluster)
    client = None
    try:
        try:
            client = import_distributed().Client(
                cluster.address, asynchronous=True, timeout=ANSWER_S, set_as_default=False
            )
            await asyncio.wait_for(client, ANSWER_S)
        except Exception as error:  # OSError, ValueError and TypeError by version and kind of address
            why = plain_text(error, 200) or f"no answer within {ANSWER_S:g} s"
            why = "it speaks another protocol" if isinstance(error, MemoryError) else why  # a length of some exabytes
            raise ClusterError(f"{cluster}: no Dask scheduler answers there ({why})") from None
        yield client
    finally:
        if client is not None:
            with contextlib.suppress(Exception):
                await asyncio.wait_for(client.close(), CLOSE_S)


def look_up(cluster: DaskAddress) -> None:
    """Connect to a TCP address before Dask does, which retries in the background.

    Raises
    ------
    ClusterError
        If it is no address, or nothing answers there.
    """
    address = cluster.address
    try:
        where = urlsplit(address if "://" in address else f"tcp://{address}")
        if where.scheme not in {"tcp", "tls"}:
            return  # Dask's own business
        if where.hostname is None or where.port is None:
            raise ClusterError(f"{cluster}: given, allowed: HOST:PORT, e.g. tcp://10.0.0.1:8786")
        socket.create_connection((where.hostname, where.port), timeout=ANSWER_S).close()
    except (OSError, ValueError) as error:
        raise ClusterError(f"{cluster}: no Dask scheduler answers there ({error})") from None


async def answered(cluster: DaskAddress, question: Any) -> Any:
    """Answer of the scheduler within its time.

    Raises
    ------
    ClusterError
        If there is none.
    """
    task = asyncio.ensure_future(question)
    await asyncio.wait({task}, timeout=SILENT_S)
    if not task.done():
        task.cancel()  # not waited for, as a lost connection may hold it
        raise ClusterError(f"{cluster}: the scheduler gave no answer within {SILENT_S:g} s")
    try:
        return task.result()
    except (Exception, asyncio.CancelledError) as error:
        raise ClusterError(f"{cluster}: the scheduler was lost ({plain_text(error, 200)})") from None


async def workers_there(client: Any, cluster: DaskAddress) -> None:
    """Wait for the first worker."""
    waited = Absence(cluster)
    while not await waited.over(client):
        await asyncio.sleep(LOOK_S / 5.0)


class Absence:
    """Time since a scheduler last had a worker."""

    def __init__(self, cluster: DaskAddress) -> None:
        self.cluster, self.since = cluster, asyncio.get_running_loop().time()

    async def over(self, client: Any) -> bool:
        """Whether there is a worker.

        Raises
        ------
        ClusterError
            If there has been none for the stated time, or the scheduler is gone.
        """
        now = asyncio.get_running_loop().time
        info = await answered(self.cluster, client.scheduler.identity())
        if info["workers"]:
            self.since = now()
            return True
        if now() - self.since > self.cluster.workers_s:
            raise ClusterError(
                f"{self.cluster}: the scheduler has had no worker for {self.cluster.workers_s:g} s; "
                "start workers, or wait longer with --dask-wait"
            )
        return False


async def sent(
    cluster: DaskAddress, function: Callable[..., Any], tasks: Mapping[int, Any], keep: Callable[[int, Any], None]
) -> None:
    """Body of :func:`run_on_cluster`."""
    count = 0

    def count_and_keep(k: int, result: Any) -> None:
        nonlocal count
        keep(k, result)
        count += 1

    try:
        async with connected(cluster) as client:
            await gathered(client, cluster, function, tasks, count_and_keep)
    except ClusterError as error:
        raise ClusterLostError(f"{error}; {count} of {len(tasks)} parts sent were done") from None


async def gathered(
    client: Any,
    cluster: DaskAddress,
    function: Callable[..., Any],
    tasks: Mapping[int, Any],
    keep: Callable[[int, Any], None],
) -> None:
    """Submit tasks and keep results, until all are there or the watch finds the cluster lost."""
    here = code_versions()
    watch = asyncio.create_task(watched(client, cluster))
    waiting = {
        asyncio.create_task(result_of(client.submit(function, task, here, pure=False))): k for k, task in tasks.items()
    }
    try:
        while waiting:
            ready, _ = await asyncio.wait({watch, *waiting}, return_when=asyncio.FIRST_COMPLETED)
            for task in ready & waiting.keys():
                keep(waiting.pop(task), value_of(cluster, client, task))
            if watch in ready:
                watch.result()
    finally:
        for task in (watch, *waiting):
            task.cancel()
        await asyncio.wait({watch, *waiting}, timeout=CLOSE_S)


async def result_of(future: Any) -> Any:
    """Result of a task; the cluster forgets it then."""
    try:
        return await future
    finally:
        future.release()


def value_of(cluster: DaskAddress, client: Any, task: asyncio.Task[T]) -> T:
    """Result of a task, or an error with one line."""
    error = asyncio.CancelledError("cancelled") if task.cancelled() else task.exception()
    if error is None:
        return task.result()
    if isinstance(error, asyncio.CancelledError) or client.status != "running":
        raise ClusterError(f"{cluster}: the scheduler was lost")
    raise ClusterError(f"{cluster}: {task_fault(error)}")


async def watched(client: Any, cluster: DaskAddress) -> None:
    """Look at the scheduler until it is lost, or has had no worker for too long."""
    absence = Absence(cluster)
    while client.status == "running":
        await absence.over(client)
        await asyncio.sleep(LOOK_S)
    raise ClusterError(f"{cluster}: the scheduler was lost")
