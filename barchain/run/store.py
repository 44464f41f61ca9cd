"""Writer of the result folder: every result is written as it comes, so that an interrupted run loses nothing."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import pandas as pd

from adapters.trajectory import from_frame
from barchain.record.files import write_atomically, write_parquet
from barchain.run.job import Job, RunResult
from reports.tables.cells import to_cells
from reports.tables.crossval import METRIC_COLUMNS
from reports.tables.outcome import Outcome
from reports.tables.schema import read_record

if TYPE_CHECKING:
    from pathlib import Path


Row = dict[str, Any]


class Store:
    """Result folder that is being written; :mod:`reports.tables.crossval` describes its files."""

    def __init__(self, folder: Path, record: dict[str, Any], order: list[tuple[str, str]]) -> None:
        """Open `folder`; `order` lists (scene, engine) in the order of the rows."""
        self.folder, self.record = folder, record
        self.place = {pair: i for i, pair in enumerate(order)}
        self.rows: dict[tuple[str, str], list[Row]] = {}
        folder.mkdir(parents=True, exist_ok=True)

    def earlier_runs(self) -> dict[str, dict[str, Any]]:
        """Complete runs in the record of an earlier, interrupted comparison in the same folder, by key.

        Raises
        ------
        SchemaVersionError
            If the record has another schema version.
        """
        path = self.folder / "run.json"
        if not path.is_file():
            return {}
        runs = read_record(path).get("runs", [])
        return {run["key"]: run for run in runs if run["outcome"] == Outcome.PASS}

    def recall(self, job: Job, earlier: dict[str, dict[str, Any]]) -> RunResult | None:
        """Stored result of `job` from an earlier comparison, or None."""
        run, path = earlier.get(job.key), self.path(job)
        if run is None or not path.is_file():
            return None
        trajectory = from_frame(pd.read_parquet(path), ended=run["reason"])
        trajectory.info.update(run["info"])
        return RunResult(Outcome(run["outcome"]), run["reason"], trajectory, run["seconds"])

    def path(self, job: Job) -> Path:
        """File of a job's trajectory."""
        return self.folder / "trajectories" / job.scene.name / f"{job.file_stem}.parquet"

    def keep_run(self, job: Job, result: RunResult) -> None:
        """Write a run's trajectory and note it in run.json."""
        if result.trajectory is not None:
            write_parquet(result.trajectory.to_frame(), self.path(job))
        self.record["runs"].append(
            {
                "key": job.key,
                "scene": job.scene.name,
                "engine": job.engine,
                "setting": str(job.setting),
                "role": str(job.role),
                "outcome": str(result.outcome),
                "reason": result.reason,
                "seconds": result.seconds,
                "info": result.trajectory.info if result.trajectory is not None else {},
            }
        )
        self.write_record()

    def keep_rows(self, scene: str, engine: str, rows: list[Row], series: pd.DataFrame | None = None) -> None:
        """Write an engine's rows, and its differences over time."""
        self.rows[scene, engine] = rows
        if series is not None:
            write_parquet(series, self.folder / "differences" / scene / f"{engine}.parquet")
        write_atomically(self.folder / "metrics.csv", to_cells(self.metrics()).to_csv(index=False))

    def keep_amplification(self, scene: str, frame: pd.DataFrame) -> None:
        """Write the error amplification of a scene over time."""
        write_parquet(frame, self.folder / "differences" / scene / "amplification.parquet")

    def metrics(self) -> pd.DataFrame:
        """All rows so far, in the given order of scenes and engines."""
        pairs = sorted(self.rows, key=lambda pair: self.place.get(pair, len(self.place)))
        return pd.DataFrame([row for pair in pairs for row in self.rows[pair]], columns=list(METRIC_COLUMNS))

    def write_record(self) -> None:
        """Write run.json as it stands."""
        write_atomically(self.folder / "run.json", json.dumps(self.record, indent=1))
