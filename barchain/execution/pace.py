"""Number of calls that are sent together: enough that the scheduler costs little, and few where calls take long."""

from __future__ import annotations

import math
from collections import deque

BATCH_S = 0.5  # of work in a batch: a hundred times what the scheduler takes for it
MOST_CALLS = 500
MOST_BYTES = 16 * 2**20
"""Calls that are sent together, B"""
REMEMBERED = 20
"""Durations that decide: the longest but a tenth of them counts, so that calls of unlike length go one by one"""


class Pace:
    """Durations of the last calls, and the size of batches that follows."""

    def __init__(self) -> None:
        """Begin with calls one by one: nothing is known yet."""
        self.seconds: deque[float] = deque(maxlen=REMEMBERED)

    def note(self, seconds: float) -> None:
        """Take the duration of a call."""
        self.seconds.append(seconds)

    def size(self, waiting: int, threads: int) -> int:
        """Number of calls for the next batch; the last calls are spread over all threads."""
        if not self.seconds:
            return 1
        long_s = sorted(self.seconds)[-1 - len(self.seconds) // 10]
        by_time = int(BATCH_S / max(long_s, BATCH_S / MOST_CALLS))
        return max(1, min(by_time, MOST_CALLS, math.ceil(waiting / (2 * threads))))
