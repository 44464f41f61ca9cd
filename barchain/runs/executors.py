"""Executors: the places where calls run, behind one interface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from barchain.runs.cluster.address import DaskAddress
from barchain.runs.cluster.limits import WORKERS_S

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.runs.session import Session


@dataclass(frozen=True)
class LocalProcesses:
    """Processes of this machine."""

    workers: int | None = None
    """Calls side by side; as many as there are cores by default"""

    def check(self) -> None:
        """Nothing to check."""

    def session(self) -> Session:
        """Context that runs calls."""
        from barchain.runs.local import LocalSession  # noqa: PLC0415  # the command line's help must be quick

        return LocalSession(self.workers)


@dataclass(frozen=True)
class DaskCluster(DaskAddress):
    """Workers of an existing Dask cluster."""

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


@dataclass(frozen=True)
class KeptAnswers:
    """Executor that keeps each answer in a folder of a study, and gives those that are there without a call."""

    folder: Path
    """Folder of the study; answers lie in a folder inside it"""
    inside: LocalProcesses | DaskCluster | KeptAnswers
    """Place of the calls whose answers are not there"""

    def check(self) -> None:
        """Check the place of the calls, with its errors."""
        self.inside.check()

    def session(self) -> Session:
        """Context that runs calls."""
        from barchain.runs.kept_answers import KeptSession  # noqa: PLC0415

        return KeptSession(self.inside.session(), self.folder)


Executor: TypeAlias = LocalProcesses | DaskCluster | KeptAnswers
ALL_CORES = LocalProcesses()


def chosen_executor(
    workers: int | None = None, dask: str | None = None, dask_wait_s: float = WORKERS_S
) -> LocalProcesses | DaskCluster:
    """Executor by the options of a command: a cluster where an address is given."""
    return LocalProcesses(workers) if dask is None else DaskCluster(dask, dask_wait_s)
