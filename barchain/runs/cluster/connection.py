"""Connection to a Dask cluster: every fault is one line within a stated time, and nothing of Dask stays.

The client lives in an event loop of this package's own, without threads of Dask. A watch beside the calls asks the
scheduler for its state, so that a fault is not waited for longer than the times below.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import socket
import warnings
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from barchain.runs.cluster.on_dask_worker import worker_versions
from barchain.runs.message import plain_text
from barchain.runs.same_code import code_fault, protocol_fault

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Coroutine, Iterator

    from barchain.runs.cluster import DaskCluster

ANSWER_S = 10.0  # for a scheduler to connect
SILENT_S = 30.0  # for a scheduler to answer: it may import this code for several seconds
START_S = 120.0  # for workers to start a process beside them, which imports this code
CLOSE_S = 5.0  # for the connection to be closed
LOOK_S = 0.5  # between looks at the scheduler
TALKATIVE = ("distributed", "tornado", "tornado.application", "tornado.general", "asyncio")


class ClusterError(RuntimeError):
    """Raised for a Dask cluster that can't be used; nothing was run."""


class ClusterLostError(ClusterError):
    """Raised for a Dask cluster that failed while calls ran."""


def check_cluster(cluster: DaskCluster) -> None:
    """Check that a scheduler answers, that workers are there, and that all have the code that is here.

    Raises
    ------
    ClusterError
        With one line on the first fault.
    """
    run_loop(checked(cluster))


def run_loop(work: Coroutine[Any, Any, None]) -> None:
    """Run a coroutine to its end, in a thread: an event loop may run here already, as in a notebook."""
    with quiet(), ThreadPoolExecutor(1) as thread:
        thread.submit(run_bounded, work, asyncio.new_event_loop()).result()


def run_bounded(work: Coroutine[Any, Any, None], loop: asyncio.AbstractEventLoop) -> None:
    """Run a coroutine as ``asyncio.run`` does, and wait for tasks that it leaves for a limited time only."""
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


async def checked(cluster: DaskCluster) -> None:
    """Body of :func:`check_cluster`."""
    async with connected(cluster) as client:
        await watched(client, cluster)
        fault = protocol_fault(await answered(cluster, client.get_versions()))
        fault = fault or code_fault(await answered(cluster, client.run(worker_versions, on_error="return"), START_S))
    if fault:
        raise ClusterError(f"{cluster}: {fault}")


@contextlib.asynccontextmanager
async def connected(cluster: DaskCluster) -> AsyncIterator[Any]:
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


def look_up(cluster: DaskCluster) -> None:
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


async def answered(cluster: DaskCluster, question: Any, limit_s: float | None = None) -> Any:
    """Answer of the scheduler within its time.

    Raises
    ------
    ClusterError
        If there is none.
    """
    task = asyncio.ensure_future(question)
    limit_s = SILENT_S if limit_s is None else limit_s
    await asyncio.wait({task}, timeout=limit_s)
    if not task.done():
        task.cancel()  # not waited for, as a lost connection may hold it
        raise ClusterError(f"{cluster}: the scheduler gave no answer within {limit_s:g} s")
    try:
        return task.result()
    except (Exception, asyncio.CancelledError) as error:
        raise ClusterError(f"{cluster}: the scheduler was lost ({plain_text(error, 200)})") from None


async def watched(client: Any, cluster: DaskCluster, told: Callable[[int], None] | None = None) -> None:
    """Look at the scheduler until it is lost; `told` gets the number of threads of its workers.

    Without `told`, until there is a worker.

    Raises
    ------
    ClusterError
        If there has been no worker for the stated time, or the scheduler is gone.
    """
    now = asyncio.get_running_loop().time
    since = now()
    while client.status == "running":
        workers = (await answered(cluster, client.scheduler.identity()))["workers"]
        if workers and told is None:
            return
        if workers and told is not None:
            since = now()
            told(sum(int(w["nthreads"]) for w in workers.values()))
        elif now() - since > cluster.workers_s:
            raise ClusterError(
                f"{cluster}: the scheduler has had no worker for {cluster.workers_s:g} s; "
                "start workers, or wait longer with --dask-wait"
            )
        await asyncio.sleep(LOOK_S)
    raise ClusterError(f"{cluster}: the scheduler was lost")
