"""Calls beside the workers of a Dask cluster; quick to import, as the command line's help needs it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from barchain.runs.pool import Session

WORKERS_S = 30.0  # without any worker; a batch system may need more


@dataclass(frozen=True)
class DaskCluster:
    """Workers of an existing Dask cluster: the address of its scheduler, and the patience with it."""

    address: str
    """E.g. ``tcp://10.0.0.1:8786``"""
    workers_s: float = WORKERS_S
    """Longest time without any worker, s"""

    def __str__(self) -> str:
        return f"--dask {self.address}"

    def check(self) -> None:
        """Check that a scheduler answers, that workers are there, and that all have the code that is here.

        Raises
        ------
        ClusterError
            With one line on the first fault.
        """
        from barchain.runs.cluster.connection import check_cluster  # noqa: PLC0415

        check_cluster(self)

    def session(self) -> Session:
        """Context that runs calls."""
        from barchain.runs.cluster.dask_session import DaskSession  # noqa: PLC0415

        return DaskSession(self)
