"""Calls in processes of this machine."""

from __future__ import annotations

import os
import queue
import threading
from typing import TYPE_CHECKING

from barchain.runs.call import pickled
from barchain.runs.environment import need_open_files
from barchain.runs.session import Session
from barchain.runs.workers import Slot

if TYPE_CHECKING:
    from collections.abc import Hashable

    from barchain.runs.call import Call

END_S = 10.0  # for the threads to notice that no answer is wanted any more


class LocalSession(Session):
    """Slots side by side, each with a thread that hands it call after call."""

    def __init__(self, workers: int | None) -> None:
        """Prepare; `workers` is the number of calls side by side, as many as there are cores by default."""
        super().__init__()
        self.workers = workers or os.cpu_count() or 1
        need_open_files(self.workers)
        self.waiting: queue.SimpleQueue[tuple[Hashable, Call] | None] = queue.SimpleQueue()
        self.slots: list[Slot] = []
        self.threads: list[threading.Thread] = []
        self.closed = False

    def start(self, key: Hashable, call: Call) -> None:
        """Queue a call; a further slot is opened while there are fewer than workers."""
        self.waiting.put((key, call))
        if len(self.slots) < min(self.workers, self.left):
            slot = Slot()
            thread = threading.Thread(target=self.serve, args=(slot,), daemon=True)
            self.slots.append(slot)
            self.threads.append(thread)
            thread.start()

    def side_by_side(self) -> int:
        """Slots."""
        return self.workers

    def serve(self, slot: Slot) -> None:
        """Run call after call in a slot, until the session is closed."""
        while (found := self.waiting.get()) is not None and not self.closed:
            key, call = found
            try:
                self.done.put((key, slot.run(pickled(call))))
            except Exception as error:  # a fault of barchain's own ends the command with its traceback
                self.done.put(error)

    def close(self) -> None:
        """End the calls at work, and all processes."""
        self.closed = True
        for _ in self.threads:
            self.waiting.put(None)
        for slot in self.slots:
            slot.close()
        for thread in self.threads:
            thread.join(END_S)
