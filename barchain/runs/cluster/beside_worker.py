"""Functions that a Dask worker calls: they hand calls to a worker of barchain beside it.

A Dask worker may not have children of the standard library's kind (its nanny makes it a daemon), and is to survive
every run.
"""

from __future__ import annotations

import asyncio
import json
from typing import TYPE_CHECKING

from barchain.runs.call import WrongWorkerError, packed_answers
from barchain.runs.frames import joined
from barchain.runs.workers import START_S, IdleSlots, Worker

if TYPE_CHECKING:
    from collections.abc import Mapping

IDLE_S = 600.0  # without a call: the memory of its processes is given back
IDLE = IdleSlots(IDLE_S)


def answer_call(versions: bytes, call: bytes) -> bytes:
    """Answer to a call, on a Dask worker.

    Parameters
    ----------
    versions : bytes
        :func:`barchain.runs.versions.code_versions` of the sender, as JSON.
    call : bytes
        From :func:`barchain.runs.call.pickled`.

    Returns
    -------
    bytes
        From :func:`barchain.runs.call.packed_answers`.

    Raises
    ------
    WrongWorkerError
        If this machine has other code than the sender.
    """
    try:
        with IDLE.slot() as slot:
            return packed_answers([slot.run(call, versions)])
    except WrongWorkerError:
        IDLE.close()  # it may have old code in memory
        with IDLE.slot() as slot:
            return packed_answers([slot.run(call, versions)])


async def worker_versions() -> dict[str, str]:
    """Versions that decide results, in a fresh process beside this one, whose event loop goes on meanwhile."""
    return await asyncio.to_thread(fresh_versions)


def fresh_versions() -> dict[str, str]:
    """Versions that decide results, in a fresh process."""
    IDLE.close()
    worker = Worker()
    try:
        found: dict[str, str] = json.loads(worker.ask(joined([b""]), START_S))
    finally:
        worker.close()
    return found


def versions_text(versions: Mapping[str, str]) -> bytes:
    """Versions as they are sent."""
    return json.dumps(dict(versions)).encode("ascii")
