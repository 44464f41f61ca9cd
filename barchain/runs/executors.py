"""Executors: the places where calls run, behind one interface; quick to import, as the command line's help needs it."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, TypeAlias

from barchain.runs.cluster import WORKERS_S, DaskCluster

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.runs.pool import Session

__all__ = [
    "ALL_CORES", "ONE_BY_ONE", "WORKERS_S", "DaskCluster", "Executor", "KeptAnswers", "LocalProcesses", "OneByOne",
    "chosen_executor",
]  # fmt: skip


@dataclass(frozen=True)
class LocalProcesses:
    """Processes of this machine."""

    workers: int | None = None
    """Calls side by side; as many as there are cores by default"""

    def check(self) -> None:
        """Nothing to check."""

    def session(self) -> Session:
        """Context that runs calls."""
        from barchain.runs.pool import LocalSession  # noqa: PLC0415

        return LocalSession(self.workers)


@dataclass(frozen=True)
class OneByOne:
    """Processes of this machine, one of which is at work at a time: their times count."""

    def check(self) -> None:
        """Nothing to check."""

    def session(self) -> Session:
        """Context that runs calls."""
        from barchain.runs.pool import OneByOneSession  # noqa: PLC0415

        return OneByOneSession()


@dataclass(frozen=True)
class KeptAnswers:
    """Executor that keeps each answer in a folder, and gives those that are there without a call."""

    folder: Path
    inside: LocalProcesses | OneByOne | DaskCluster | KeptAnswers
    """Place of the calls whose answers are not there"""
    tally: Counter[str] = field(default_factory=Counter, compare=False)
    """Answers that were asked for, and those of them that were there, of all sessions"""

    def one_by_one(self) -> KeptAnswers:
        """The same folder for calls whose times count."""
        return replace(self, inside=ONE_BY_ONE)

    def check(self) -> None:
        """Check the place of the calls, with its errors."""
        self.inside.check()

    def session(self) -> Session:
        """Context that runs calls."""
        from barchain.runs.kept_answers import KeptSession  # noqa: PLC0415

        return KeptSession(self.inside.session(), self.folder, self.tally)


Executor: TypeAlias = LocalProcesses | OneByOne | DaskCluster | KeptAnswers
ALL_CORES, ONE_BY_ONE = LocalProcesses(), OneByOne()


def chosen_executor(
    workers: int | None = None, dask: str | None = None, dask_wait_s: float = WORKERS_S
) -> LocalProcesses | DaskCluster:
    """Executor by the options of a command: a cluster where an address is given."""
    return LocalProcesses(workers) if dask is None else DaskCluster(dask, dask_wait_s)
