"""Functions that a Dask worker calls: they hand calls to a worker of barchain beside it.

A Dask worker may not have children of the standard library's kind (its nanny makes it a daemon), and is to survive
every run.
"""

from __future__ import annotations

import asyncio
import atexit
import json
from typing import TYPE_CHECKING

from barchain.runs.call import WrongWorkerError, packed
from barchain.runs.pool import START_S, Slot, Slots

if TYPE_CHECKING:
    from collections.abc import Mapping

IDLE_S = 600.0  # without a call: the memory of its processes is given back
SLOTS = Slots(IDLE_S)
atexit.register(SLOTS.close_idle)


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
        From :func:`barchain.runs.call.packed`.

    Raises
    ------
    WrongWorkerError
        If this machine has other code than the sender.
    """
    try:
        with SLOTS.slot() as slot:
            return packed(slot.run(call, versions))
    except WrongWorkerError:
        SLOTS.close_idle()  # it may have old code in memory
        with SLOTS.slot() as slot:
            return packed(slot.run(call, versions))


async def worker_versions() -> dict[str, str]:
    """Versions that decide results, in a fresh process beside this one, whose event loop goes on meanwhile."""
    return await asyncio.to_thread(fresh_versions)


def fresh_versions() -> dict[str, str]:
    """Versions that decide results, in a fresh process."""
    SLOTS.close_idle()
    slot = Slot()
    try:
        found: dict[str, str] = json.loads(slot.ask(b"", b"", START_S))
    finally:
        slot.close()
    return found


def versions_text(versions: Mapping[str, str]) -> bytes:
    """Versions as they are sent."""
    return json.dumps(dict(versions)).encode("ascii")
