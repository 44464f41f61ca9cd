"""Address of a Dask scheduler, and the patience with it."""

from __future__ import annotations

from dataclasses import dataclass

from barchain.runs.cluster.limits import WORKERS_S


@dataclass(frozen=True)
class DaskAddress:
    """Scheduler and patience."""

    address: str
    """E.g. ``tcp://10.0.0.1:8786``"""
    workers_s: float = WORKERS_S
    """Longest time without any worker, s"""

    def __str__(self) -> str:
        return f"--dask {self.address}"
