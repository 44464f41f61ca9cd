"""Share of barchain's loads in the time of an engine with independent physics.

An engine that offers the option ``repeated_load`` applies each load twice, at half strength. The motion stays the same
up to round-off, and the additional time is that of the loads once more. Runs with and without the option take turns.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.runs.declared import engine_class
from barchain.runs.timing.statistics import interval
from barchain.studies.cost.plan import kind_of
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from adapters.trajectory import Array
    from barchain.runs.job import Job
    from barchain.runs.timing.bench import TimingBench

OPTION = "repeated_load"
TURNS = 7
LONGEST_S = 0.1  # of the run that is taken: the finest setting below it, where the fixed costs of a run are least


@dataclass(frozen=True)
class LoadTimes:
    """Times of an engine with its loads applied once and twice."""

    job: Job
    once_s: Array
    twice_s: Array

    @property
    def row(self) -> dict[str, Any]:
        """Row of loads.csv."""
        once, twice = float(np.median(self.once_s)), float(np.median(self.twice_s))
        ratio = interval(twice / once, [(1.0, self.twice_s), (-1.0, self.once_s)])
        return {
            "scene": self.job.scene.name,
            "engine": self.job.engine,
            "setting": str(self.job.setting),
            "kind": kind_of(self.job.registration),
            "seconds": once,
            "seconds_twice": twice,
            "share": ratio.value - 1.0,
            "share_low": ratio.low - 1.0,
            "share_high": ratio.high - 1.0,
        }


def load_jobs(sweeps: Iterable[list[Job]], points: Mapping[str, Mapping[str, Any]]) -> list[Job]:
    """Runs whose loads are timed: of each engine with the option, the finest good setting below :data:`LONGEST_S`.

    Parameters
    ----------
    sweeps : iterable of list of Job
        Settings of each engine, coarse to fine.
    points : mapping
        Measured points by the key of their job.
    """
    found = []
    for jobs in sweeps:
        good = [j for j in jobs if points[j.key]["outcome"] == Outcome.PASS.value]
        brief = [j for j in good if points[j.key]["seconds"] <= LONGEST_S]
        if good and OPTION in engine_class(good[0].registration).options:
            found.append(brief[-1] if brief else good[0])
    return found


def load_times(bench: TimingBench, job: Job, time_limit_s: float) -> LoadTimes | None:
    """Times of a run with its loads once and twice, in turn; None if a run fails."""
    pair = (job, twice(job))
    times: tuple[list[float], list[float]] = ([], [])
    for _ in range(TURNS):
        for which, own in zip(pair, times, strict=True):
            result = bench.run(which, time_limit_s)
            if result.outcome is not Outcome.PASS:
                return None
            own.append(result.seconds["simulate"])
    return LoadTimes(job, np.array(times[0]), np.array(times[1]))


def twice(job: Job) -> Job:
    """The same run with its loads applied twice."""
    return dataclasses.replace(job, options=(OPTION,))
