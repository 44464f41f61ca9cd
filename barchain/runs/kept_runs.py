"""Runs in the folder of a comparison or a study: the samples of each, and its entry in the record."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.tables.reading import digest
from reports.tables.rows import frame_digest
from reports.tables.writing import parquet

if TYPE_CHECKING:
    from barchain.record.study_store import StudyStore
    from barchain.runs.job import Job, RunResult


def keep_run(store: StudyStore, job: Job, result: RunResult) -> None:
    """Write a run's samples as ``trajectories/<scene>/<engine>.parquet``, and note the run in the record."""
    trajectory = result.trajectory
    frame = None if trajectory is None else trajectory.of_run(job.scene).to_frame()
    content = None if frame is None else parquet(frame)
    file = None if content is None else f"trajectories/{job.scene.name}/{job.file_stem}.parquet"
    store.record["runs"].append({
        "scene": job.scene.name,
        "engine": job.engine,
        "setting": str(job.setting),
        "role": str(job.role),
        "outcome": str(result.outcome),
        "reason": result.reason,
        "seconds": result.seconds,
        "info": {} if trajectory is None else trajectory.info,
        "file": file,
        "digest": None if content is None else digest(content),
        "rejected": result.rejected,
        "bits": "" if frame is None else frame_digest(frame),
    })  # fmt: skip
    if file is None or content is None:
        store.write_record()
    else:
        store.write_file(file, content)
