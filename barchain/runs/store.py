"""Runs of a comparison or a study in its folder: every run is written as it comes, and recalled by `--resume`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pandas as pd

from adapters.trajectory import Trajectory, from_frame
from barchain.runs.job import Job, Role, RunResult
from reports.tables.crossval import METRIC_COLUMNS
from reports.tables.outcome import Outcome
from reports.tables.reading import DamagedResultsError, brief, damaged, digest, read_bytes, read_parquet
from reports.tables.run_rows import frame_digest, recorded_runs
from reports.tables.writing import parquet

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from barchain.record.study_store import StudyStore

Row = dict[str, Any]


class RunStore:
    """Runs, differences and rows of a folder; :mod:`reports.tables.crossval` describes its files."""

    def __init__(self, study: StudyStore, order: list[tuple[str, str]]) -> None:
        """Take the folder of `study`; `order` lists (scene, engine) in the order of the rows."""
        self.study, self.folder, self.record, self.files = study, study.folder, study.record, study.writer
        self.place = {pair: i for i, pair in enumerate(order)}
        self.rows: dict[tuple[str, str], list[Row]] = {}
        self.recalled: dict[str, dict[str, Any]] = {}
        """Entries of recalled runs by key, until they are kept"""
        self.note: Callable[[str], None] = lambda _: None
        """Called with a sentence on each stored run that has to be made anew"""

    def earlier_runs(self) -> dict[str, dict[str, Any]]:
        """Complete runs of an earlier comparison in the same folder, by key."""
        return {run["key"]: run for run in recorded_runs(self.study.earlier) if run["outcome"] == Outcome.PASS}

    def begin(self) -> None:
        """Write the record with the earlier runs, and a table without rows.

        From here on the folder holds this comparison, and every earlier run until it is taken over or replaced.
        """
        self.write_record()
        self.write_metrics()

    def recall(self, job: Job, earlier: dict[str, dict[str, Any]]) -> RunResult | None:
        """Stored result of `job` from an earlier comparison, or None; of a damaged one a note says so."""
        run = earlier.get(job.key)
        if run is None:
            return None
        try:
            trajectory = self.stored_trajectory(job, run)
        except (DamagedResultsError, OSError) as error:
            self.note(f"run anew, as its stored samples can't be used: {brief(error)}")
            return None
        trajectory.info.update(run.get("info", {}))
        self.recalled[job.key] = run
        return RunResult(Outcome(run["outcome"]), run.get("reason", ""), trajectory, run.get("seconds", {}))

    def stored_trajectory(self, job: Job, run: dict[str, Any]) -> Trajectory:
        """Trajectory of a run, as it was recorded.

        Raises
        ------
        OSError
            If there is none.
        DamagedResultsError
            If it is another than the record describes, or none at all.
        """
        path = self.path(job)
        content = read_bytes(path)
        if run.get("digest") is not None and digest(content) != run["digest"]:
            raise damaged(path, "is not the table that the record describes")
        try:
            return from_frame(read_parquet(path, content), ended=run.get("reason", ""))
        except KeyError as error:
            raise damaged(path, f"lacks {error}") from None

    def file(self, job: Job) -> str:
        """File of a job's trajectory, relative to the folder."""
        return f"trajectories/{job.scene.name}/{job.file_stem}.parquet"

    def path(self, job: Job) -> Path:
        """File of a job's trajectory."""
        return self.folder / self.file(job)

    def keep_run(self, job: Job, result: RunResult) -> None:
        """Write a run's trajectory and note it in record.json; a recalled run stays as it is stored."""
        stored = self.recalled.pop(job.key, None)
        if stored is not None:
            self.note_run(stored)
            if stored.get("digest") is not None:
                self.files.tables[self.file(job)] = [stored["digest"]]
            else:
                self.files.tables[self.file(job)] = [digest(read_bytes(self.path(job)))]
            self.write_record()
            return
        frame = None if result.trajectory is None else result.trajectory.of_run(job.scene).to_frame()
        content = None if frame is None else parquet(frame)
        self.note_run(self.entry(job, result, content) | {"bits": "" if frame is None else frame_digest(frame)})
        if content is None:
            self.write_record()
        else:
            self.files.write(self.file(job), content)

    def entry(self, job: Job, result: RunResult, content: bytes | None) -> dict[str, Any]:
        """Entry of a run in record.json."""
        return {
            "key": job.key,
            "scene": job.scene.name,
            "engine": job.engine,
            "setting": str(job.setting),
            "role": str(job.role),
            "outcome": str(result.outcome),
            "reason": result.reason,
            "seconds": result.seconds,
            "info": result.trajectory.info if result.trajectory is not None else {},
            "file": None if content is None else self.file(job),
            "digest": None if content is None else digest(content),
            "rejected": result.rejected,
        }

    def note_run(self, entry: dict[str, Any]) -> None:
        """Add a run to the record; it replaces carried ones of the same key or the same file."""
        self.record["runs"].append(entry)
        carried = self.record.get("carried", [])
        self.record["carried"] = [run for run in carried if not replaces(entry, run)]

    def keep_rows(self, scene: str, engine: str, rows: list[Row], series: pd.DataFrame | None = None) -> None:
        """Write an engine's rows, and its differences over time."""
        self.rows[scene, engine] = rows
        if series is not None:
            self.files.write(f"differences/{scene}/{engine}.parquet", parquet(series))
        self.write_metrics()

    def write_metrics(self) -> None:
        """Write the table of all rows so far."""
        self.study.write("metrics", self.metrics())

    def keep_amplification(self, scene: str, frame: pd.DataFrame) -> None:
        """Write the error amplification of a scene over time."""
        self.files.write(f"differences/{scene}/amplification.parquet", parquet(frame))

    def keep_solution(self, scene: str, trajectory: Trajectory) -> None:
        """Write the solution that judges a scene, where no run of the comparison has its samples."""
        self.files.write(f"trajectories/{scene}/{Role.SOLUTION}.parquet", parquet(trajectory.to_frame()))

    def metrics(self) -> pd.DataFrame:
        """All rows so far, in the given order of scenes and engines."""
        pairs = sorted(self.rows, key=lambda pair: self.place.get(pair, len(self.place)))
        return pd.DataFrame([row for pair in pairs for row in self.rows[pair]], columns=list(METRIC_COLUMNS))

    def write_record(self) -> None:
        """Write record.json as it stands."""
        self.study.write_record()


def replaces(entry: dict[str, Any], run: dict[str, Any]) -> bool:
    """Whether a run takes the place of a carried one."""
    same_file = entry.get("file") is not None and all(entry[k] == run[k] for k in ("scene", "engine", "role"))
    return entry["key"] == run["key"] or same_file
