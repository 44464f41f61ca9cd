"""The cost study's folder, written as results come; :mod:`reports.tables.cost` says what is in it."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from barchain.record.files import write_atomically
from barchain.timing.left_out import NOT_RUN
from reports.tables.cost import POINT_COLUMNS, TIME_COLUMNS

if TYPE_CHECKING:
    from pathlib import Path

    from adapters.trajectory import Array
    from barchain.run.job import Job

Pair = tuple[str, str, str]


class CostStore:
    """Points and times of one study."""

    def __init__(self, folder: Path, record: dict[str, Any], *, resume: bool) -> None:
        """Open `folder`, with what an earlier, cut-off study left there if `resume`."""
        self.folder, self.record = folder, record
        folder.mkdir(parents=True, exist_ok=True)
        self.rows: dict[str, dict[str, Any]] = {}
        self.times: dict[str, list[float]] = {}
        self.path = folder / "times.csv"
        if resume and self.path.is_file() and (folder / "points.csv").is_file():
            self.recall()
        self.path.write_text(self.times_text(), encoding="utf-8")

    def recall(self) -> None:
        """Take over what an earlier study measured."""
        points = pd.read_csv(self.folder / "points.csv", keep_default_na=False, na_values=[""])
        points = points.astype({"reason": object, "under_floor": object}).fillna({"reason": "", "under_floor": ""})
        points = points[~points.reason.str.startswith(NOT_RUN)]  # what there was no time for may be tried now
        self.rows = {str(row["key"]): {str(k): v for k, v in row.items()} for row in points.to_dict("records")}
        for key, own in pd.read_csv(self.path).groupby("key", sort=False):
            self.times[str(key)] = own["seconds"].tolist()

    def times_text(self) -> str:
        """All times so far, as they stand in the file."""
        lines = [f"{key},{k},{s!r}" for key, found in self.times.items() for k, s in enumerate(found)]
        return "\n".join([",".join(TIME_COLUMNS), *lines]) + "\n"

    def keep_point(self, job: Job, columns: dict[str, Any]) -> None:
        """Note what a point's first run gave."""
        named = {"scene": job.scene.name, "engine": job.engine, "setting": str(job.setting)}
        self.rows[job.key] = named | {"parameter": str(job.setting.parameter), "value": job.setting.value} | columns
        self.rows[job.key]["key"] = job.key

    def keep_time(self, job: Job, seconds: float) -> None:
        """Append one measured time, at once."""
        found = self.times.setdefault(job.key, [])
        with self.path.open("a", encoding="utf-8") as file:
            file.write(f"{job.key},{len(found)},{seconds!r}\n")
        found.append(seconds)

    def points(self) -> pd.DataFrame:
        """All points so far, in the order they were run."""
        frame = pd.DataFrame(list(self.rows.values()))
        return frame.reindex(columns=list(POINT_COLUMNS))

    def times_by_point(self) -> dict[Pair, Array]:
        """Measured times of each point."""
        return {
            (row["scene"], row["engine"], row["setting"]): np.array(self.times.get(key, []))
            for key, row in self.rows.items()
        }

    def write(self, name: str, table: pd.DataFrame) -> None:
        """Write a table."""
        write_atomically(self.folder / f"{name}.csv", table.to_csv(index=False))

    def write_record(self) -> None:
        """Write run.json as it stands."""
        write_atomically(self.folder / "run.json", json.dumps(self.record, indent=1))
