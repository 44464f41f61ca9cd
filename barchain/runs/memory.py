"""Peak resident memory of this process beyond its memory at a moment.

Linux's `ru_maxrss` can't be used: it is handed on through fork and exec, so a process that a large one started begins
at that one's size. There the kernel's own high-water mark of the memory map is read, set back at the moment.
"""

from __future__ import annotations

import contextlib
import importlib
import math
import os
import sys
from pathlib import Path

STATUS, CLEAR = Path("/proc/self/status"), Path("/proc/self/clear_refs")
KIBI = 1024.0


class Peak:
    """High-water mark from its making on."""

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
