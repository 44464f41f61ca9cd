"""Functions that a Dask worker calls: they hand calls to a worker of barchain beside it.

A Dask worker may not have children of the standard library's kind (its nanny makes it a daemon), and is to survive
every run.
"""

from __future__ import annotations

import asyncio
import atexit
import json

from barchain.runs.call import Call, CallEnd, packed, pickled
from barchain.runs.pool import START_S, Slot, Slots
from barchain.runs.same_code import versions_bytes

IDLE_S = 600.0  # without a call: the memory of its processes is given back
SLOTS = Slots(IDLE_S)
atexit.register(SLOTS.close_idle)


def answer_call(call: bytes) -> bytes:
    """Packed answer to a pickled call, on a Dask worker."""
    with SLOTS.slot() as slot:
        answer = slot.run(call)
    if answer.end is CallEnd.OTHER_CODE:  # the worker may have old code in memory
        SLOTS.close_idle()
        with SLOTS.slot() as slot:
            answer = slot.run(call)
    return packed(answer)


async def worker_versions() -> dict[str, str]:
    """Versions that decide results, in a fresh process beside this one, whose event loop goes on meanwhile."""
    return await asyncio.to_thread(fresh_versions)


def fresh_versions() -> dict[str, str]:
    """Versions that decide results, in a fresh process."""
    SLOTS.close_idle()
    slot = Slot()
    try:
        found: dict[str, str] = json.loads(slot.run(pickled(Call(versions_bytes, (), START_S, pool=""))).needed())
    finally:
        slot.close()
    return found
