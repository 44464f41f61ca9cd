"""Process beside a Dask worker that runs calls, each in a process of its own: ``python -m barchain.execution.host``.

A Dask worker may not have children of its own (its nanny makes it a daemon), and is to survive every run. It hands
requests to this process on a pipe, and takes answers from another. The end of the pipe ends this process and, by the
watchman, all that it has started.
"""

from __future__ import annotations

import json
import os
import queue
import tempfile
import threading
import time
from pathlib import Path
from typing import BinaryIO

from barchain.boundary.message import plain_text
from barchain.boundary.threads import one_thread_each, temporary_root
from barchain.execution.call import Answer, CallEnd, unpickled
from barchain.execution.code_versions import code_versions, difference
from barchain.execution.processes import ProcessSlot
from barchain.execution.wire import joined, packed_answers, parted, read_frame, write_frame

DONE, OTHER = b"done", b"other code"
KEPT_POOLS = 3  # calls of several pools come mixed: solutions, other runs, verdicts
IDLE_S = 600.0  # without a request: the memory of its processes is given back
ORDERLY_S = 2.0  # to end in order after the end of the pipe


def main() -> None:
    """Answer requests until the pipe ends, or none comes for a while."""
    requests, replies = protocol_files()
    waiting: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
    threading.Thread(target=receive, args=(requests, waiting), daemon=True).start()
    with one_thread_each(), tempfile.TemporaryDirectory(dir=temporary_root()) as folder:
        slot = ProcessSlot(Path(folder), KEPT_POOLS)
        try:
            while (request := next_request(waiting)) is not None:
                write_frame(replies, reply(slot, request))
        finally:
            slot.close()


def protocol_files() -> tuple[BinaryIO, BinaryIO]:
    """Pipes to the worker; all else that is printed here is dropped."""
    found = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    for target, flags in ((0, os.O_RDONLY), (1, os.O_WRONLY)):
        handle = os.open(os.devnull, flags)
        os.dup2(handle, target)
        os.close(handle)
    return found


def receive(requests: BinaryIO, waiting: queue.SimpleQueue[bytes | None]) -> None:
    """Queue requests; at the end of the pipe end this process, also while a call is at work."""
    while (request := read_frame(requests)) is not None:
        waiting.put(request)
    waiting.put(None)
    time.sleep(ORDERLY_S)
    os._exit(1)  # the watchman ends the processes that are left


def next_request(waiting: queue.SimpleQueue[bytes | None]) -> bytes | None:
    """Next request; None at the end."""
    try:
        return waiting.get(timeout=IDLE_S)
    except queue.Empty:
        return None


def reply(slot: ProcessSlot, request: bytes) -> bytes:
    """Reply to a request: answers to its calls, or the version that differs from the sender's."""
    versions, *calls = parted(request)
    differs = difference(code_versions(), json.loads(versions)) if versions else ""
    if differs:
        return joined([OTHER, differs.encode()])
    if not calls:
        return joined([DONE, json.dumps(code_versions()).encode("ascii")])
    return joined([DONE, packed_answers([answer(slot, call) for call in calls])])


def answer(slot: ProcessSlot, content: bytes) -> Answer:
    """Answer to a call; one that this code can't read is a failure of its own."""
    try:
        call = unpickled(content)
    except Exception as error:
        reason = f"can't load a call ({type(error).__name__}: {plain_text(error, 160)})"
        return Answer(end=CallEnd.OTHER_CODE, reason=reason)
    return slot.run(call)


if __name__ == "__main__":
    main()
