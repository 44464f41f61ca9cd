"""Time and memory that a run takes, in its own process."""

from __future__ import annotations

import contextlib
import importlib
import math
import os
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable

T = TypeVar("T")
WAITS = Path("/proc/thread-self/schedstat")
"""Linux: time on a processor and time in the queue for one, ns, and the number of time slices of this thread"""


class Stopwatch:
    """Time of a call as on an idle machine: without the time in which its thread waited for a processor.

    On a busy machine the wall time of a run grows with what else runs, and a long run loses a larger share than one
    that ends within a time slice. Ratios of wall times are therefore wrong there. A run needs what it used of the
    processors, or what is left of the wall time without the wait in the scheduler's queue, whichever is more: an engine
    that waits for a child process or a file uses no processor meanwhile, and the scheduler settles a wait late, so that
    one may contain part of an earlier one. On an idle machine, and where the system does not tell the wait, this is the
    wall time.
    """

    def __init__(self) -> None:
        """Start; the wall clock last, so that it holds nothing of the other two."""
        self.waited_s = queue_time_s()
        self.used_s = time.process_time()
        self.start_s = time.perf_counter()

    def seconds(self) -> float:
        """Time since the start, s."""
        wall_s = time.perf_counter() - self.start_s
        used_s = time.process_time() - self.used_s
        return min(wall_s, max(used_s, wall_s - (queue_time_s() - self.waited_s)))


def queue_time_s() -> float:
    """Time that this thread has waited for a processor so far, s; 0 where the system does not tell."""
    try:
        return int(WAITS.read_bytes().split()[1]) / 1e9
    except (OSError, ValueError, IndexError):
        return 0.0


def timed(seconds: dict[str, float], phase: str, call: Callable[[], T]) -> T:
    """Result of `call`; its time is noted under `phase`, and an exception carries the phase as a note."""
    clock = Stopwatch()
    try:
        result = call()
    except BaseException as error:
        error.add_note(phase)
        raise
    seconds[phase] = clock.seconds()
    return result


STATUS, CLEAR = Path("/proc/self/status"), Path("/proc/self/clear_refs")
KIBI = 1024.0


class Peak:
    """Peak resident memory of this process beyond its memory at a moment.

    Linux's `ru_maxrss` can't be used: it is handed on through fork and exec, so a process that a large one started
    begins at that one's size. There the kernel's own high-water mark of the memory map is read, set back at the moment.
    """

    def __init__(self) -> None:
        """Begin."""
        with contextlib.suppress(OSError):
            CLEAR.write_text("5", encoding="ascii")  # sets the mark back to what is resident now
        self.base_B = mark()

    def beyond(self) -> float:
        """Bytes by which the peak exceeds the mark; NaN where the system does not report it."""
        return max(0.0, mark() - self.base_B) if math.isfinite(self.base_B) else math.nan


def mark() -> float:
    """Largest resident size so far, bytes; NaN where it is not known."""
    if STATUS.is_file():
        lines = dict(line.split(":", 1) for line in STATUS.read_text(encoding="utf-8").splitlines() if ":" in line)
        return KIBI * float(lines["VmHWM"].split()[0]) if "VmHWM" in lines else math.nan
    try:
        resource = importlib.import_module("resource")  # POSIX only
    except ImportError:
        return math.nan
    unit = 1.0 if sys.platform == "darwin" else KIBI
    return unit * float(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)


def installed() -> float:
    """Memory of this machine, bytes; infinite where the system does not report it."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        return math.inf
