"""Processors that other processes use while times are measured.

Times without the wait for a processor still grow on a busy machine, by up to a tenth: caches and cores are shared. So a
study of times records how busy the machine was.
"""

from __future__ import annotations

import contextlib
import time
from typing import TYPE_CHECKING

import psutil

if TYPE_CHECKING:
    from collections.abc import Iterator


def busy_s() -> float:
    """Time that all processors have worked so far, s; time that a hypervisor gave to other machines counts too."""
    spent = psutil.cpu_times()._asdict()
    idle = ("idle", "iowait", "guest", "guest_nice")  # guests are in the time of users already
    return float(sum(value for name, value in spent.items() if name not in idle))


def own_s() -> float:
    """Time that this process and those that it started have used so far, s."""
    found = 0.0
    for process in own_processes():
        with contextlib.suppress(psutil.Error):
            spent = process.cpu_times()
            found += spent.user + spent.system + spent.children_user + spent.children_system
    return found


def own_processes() -> Iterator[psutil.Process]:
    """The calling process and all below it."""
    this = psutil.Process()
    yield this
    with contextlib.suppress(psutil.Error):
        yield from this.children(recursive=True)


class OtherLoad:
    """Load by other processes from its making on."""

    def __init__(self) -> None:
        """Begin."""
        self.start_s, self.busy_s, self.own_s = time.monotonic(), busy_s(), own_s()

    def processors(self) -> float:
        """Mean number of processors that other processes have used since the start; at least 0."""
        wall_s = time.monotonic() - self.start_s
        others_s = busy_s() - self.busy_s - (own_s() - self.own_s)
        return max(others_s / wall_s, 0.0) if wall_s > 0.0 else 0.0
