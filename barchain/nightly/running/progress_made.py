"""Progress of a job as its result folder shows it: the scenes that are done."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from barchain.nightly.run_facts import scene_name
from barchain.runs.timing.bench import LONG_S
from barchain.studies.cost.study import FEWEST_LONG_TURNS, FEWEST_TURNS
from reports.tables import cost, crossval, stability
from reports.tables.outcome import Outcome
from reports.tables.reading import DamagedResultsError
from reports.tables.schema import SchemaVersionError

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

    from barchain.nightly.plan.jobs import NightJob
    from reports.tables.files import StudyFiles

FILES: dict[str, tuple[StudyFiles, str]] = {
    "comparison": (crossval.FILES, "metrics"),
    "stability": (stability.FILES, "outcomes"),
    "cost": (cost.FILES, "points"),
}
"""Studies with scenes, each with a table that has a row for every scene and engine that is done"""


def scenes_left(job: NightJob, folder: Path) -> tuple[str, ...]:
    """Scenes of an interrupted job that are not done with all engines, in their order.

    Parameters
    ----------
    job : NightJob
        Of a study with scenes.
    folder : Path
        Result folder; without results there all scenes are left.
    """
    files, table = FILES[job.study]
    if not files.has_record(folder):
        return job.scenes
    try:
        record = files.sound_record(folder)
        rows = files.read(folder, table) if files.has(folder, table) else None
    except (FileNotFoundError, DamagedResultsError, SchemaVersionError):
        return job.scenes
    if record.get("complete"):
        return ()
    done = set() if rows is None else set(zip(rows["scene"], rows["engine"], strict=True))
    done |= {(str(scene), str(engine)) for scene, engine in record.get("left_out") or () if job.study == "stability"}
    engines = list(record.get("engines") or ())
    if job.study == "cost":
        return tuple(s for s in job.scenes if rows is None or not is_timed(rows[rows["scene"] == scene_name(s)]))
    if not engines:
        return job.scenes
    return tuple(s for s in job.scenes if not all((scene_name(s), engine) in done for engine in engines))


def is_timed(points: pd.DataFrame) -> bool:
    """Whether the good points of a scene have the times that a median needs: they are measured in rounds over all."""
    good = points[points["outcome"] == Outcome.PASS.value]
    fewest = np.where(good["seconds"] >= LONG_S, FEWEST_LONG_TURNS, FEWEST_TURNS)
    return bool(len(good) and (good["turns"].fillna(0).to_numpy() >= fewest).all())
