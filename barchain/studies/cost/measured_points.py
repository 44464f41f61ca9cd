"""Points and times of a cost study, kept in its folder as they are measured."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.studies.cost.plan import kind_of
from reports.tables.outcome import Outcome
from reports.tables.rows import NOT_RUN

if TYPE_CHECKING:
    import pandas as pd

    from adapters.trajectory import Array
    from barchain.record.study_store import StudyStore
    from barchain.runs.job import Job

Pair = tuple[str, str, str]


class MeasuredPoints:
    """Points by key, each with its measured times of `simulate`, s."""

    def __init__(self, store: StudyStore) -> None:
        """Start with no point, or with those of an interrupted study where `store` resumes one."""
        self.store = store
        self.rows: dict[str, dict[str, Any]] = {}
        self.times: dict[str, list[float]] = {}
        if store.resume and store.has("times") and store.has("points"):
            self.recall()
        self.store.write("times", (row for key, found in self.times.items() for row in time_rows(key, found)))

    def recall(self) -> None:
        """Take over the points of an interrupted study; those that were not run or that failed are run again."""
        points = self.store.read("points")
        points = points[~points.reason.str.startswith(NOT_RUN) & (points.outcome != Outcome.FAILED.value)]
        self.rows = {str(row["key"]): {str(k): v for k, v in row.items()} for row in points.to_dict("records")}
        for key, own in self.store.read("times").groupby("key", sort=False):
            if str(key) in self.rows:  # otherwise the point was cut off, and is measured anew
                self.times[str(key)] = own["seconds"].tolist()

    def keep_point(self, job: Job, columns: dict[str, Any]) -> None:
        """Keep the columns of a point's first run."""
        named = {"scene": job.scene.name, "engine": job.engine, "kind": kind_of(job.registration)}
        named["setting"] = str(job.setting)
        self.rows[job.key] = named | {"parameter": str(job.setting.parameter), "value": job.setting.value} | columns
        self.rows[job.key]["key"] = job.key
        self.store.write("points", self.points())

    def keep_time(self, job: Job, seconds: float) -> None:
        """Append one measured time to the table, at once."""
        found = self.times.setdefault(job.key, [])
        found.append(seconds)
        self.store.append("times", time_rows(job.key, found)[-1:])

    def points(self) -> pd.DataFrame:
        """All points so far, in the order in which they were run."""
        return self.store.frame("points", self.rows.values())

    def times_by_point(self) -> dict[Pair, Array]:
        """Measured times of each point."""
        return {
            (row["scene"], row["engine"], row["setting"]): np.array(self.times.get(key, []))
            for key, row in self.rows.items()
        }


def time_rows(key: str, times: list[float]) -> list[dict[str, Any]]:
    """Rows of times.csv of one point."""
    return [{"key": key, "turn": turn, "seconds": seconds} for turn, seconds in enumerate(times)]
