"""Budget of a night: the time of each job, what fits into it, and what a job that was ended has done."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import psutil

from barchain.studies.cost.study import FEWEST_LONG_TURNS, FEWEST_TURNS
from barchain.studies.timing.bench import LONG_S
from reports.results import comparison, cost, stability
from reports.results.nights.document import PartState, scene_name
from reports.results.outcome import Outcome
from reports.results.reading import DamagedResultsError
from reports.results.schema import SchemaVersionError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    import pandas as pd

    from barchain.nightly.running.jobs import NightJob
    from reports.results.files import StudyFiles
    from reports.results.nights.document import NightRun, PartResult


RESERVE_S = 25.0
"""Time at the end of a long night for judging and telling"""
LEAST_RESERVE_S = 6.0
"""The same of a short night, which has a short history"""
RESERVED = 0.05
"""Part of a night that is kept for its end, between these two"""
ALARM = "selftest"
COST = "cost"
LEAST_S = 6.0
"""A job with less time does not begin: reading barchain and an engine takes two seconds, an end up to four"""
ENDING_S = 4.0
"""Time in which an interrupted job ends, inside its own time"""
RUNNING = 0.75
"""Least part of a job's time before it is interrupted"""
FILL = 0.9
"""Part of a job's time that the scenes that are taken on may fill"""
MEASURED = 0.85
"""Part of a cost study's time that it plans with; its first runs are not planned"""
FAVOURED = 0.75
"""Part of the time that is left that one waiting part may take"""
OLDEST_S = 60.0
"""A process that is older than this was not started for the night"""


def working_time_s(minutes: float) -> float:
    """Time of all jobs together, without the reserve at the end."""
    whole = 60.0 * minutes
    return whole - min(RESERVE_S, max(LEAST_RESERVE_S, RESERVED * whole))


def process_age_s() -> float:
    """Time since the start of this process, which belongs to the night; 0 of one that was not started for it."""
    age = time.time() - psutil.Process().create_time()
    return age if 0.0 <= age <= OLDEST_S else 0.0


def limit_s(job: NightJob, rest: Sequence[NightJob], left_s: float) -> float:
    """Time of a job: its share of what is left, among itself and the jobs after it.

    Planted faults get enough to begin in the shortest night: without them, no other part is worth believing. So does a
    part of which nothing was done on the night before. One of these parts, another one each night, may take most of
    what is left: a night that is too short for all parts does one after the other.
    """
    share = left_s * job.share / sum(each.share for each in (job, *rest))
    if job.study == ALARM or job.waits:
        share = max(share, LEAST_S)
    if job.favoured:
        share = max(share, FAVOURED * left_s)
    return min(share, left_s)


def running_s(time_s: float) -> float:
    """Time after which a job is interrupted, so that it ends within its time."""
    return max(time_s - ENDING_S, RUNNING * time_s)


def last_of(name: str, last: NightRun | None) -> PartResult | None:
    """Result of a part on the last night of the plan; None where nothing was done."""
    parts = last.parts if last else ()
    return next((part for part in parts if part.name == name and part.done and part.duration_s > 0.0), None)


def fitting(job: NightJob, time_s: float, last: PartResult | None) -> NightJob:
    """Job with the scenes that are known to fit, at least one; `last` is what the last night did of the part.

    As many fit as at the pace of the last night, and as many as it did in no more time. A part of which nothing was
    done on the last night takes on one scene.
    """
    if not job.scenes or (last is None and not job.waits):
        return job
    count = 1
    if last is not None:
        did = last.done if last.duration_s <= time_s else 0
        count = max(int(FILL * time_s * last.done / last.duration_s), did, 1)
    return replace(job, scenes=job.scenes[:count])


def leftovers(last: NightRun | None) -> dict[str, list[str]]:
    """What the last night of the plan left, by part: scenes, or the part's name."""
    if last is None:
        return {}
    return {part.name: list(part.left or (part.name,)) for part in last.parts if part.state is PartState.LEFT}


def waiting_parts(last: NightRun | None) -> list[str]:
    """Parts of which the last night of the plan did nothing for want of time, in its order.

    A night that ended before a part began says nothing of it.
    """
    parts = last.parts if last else ()
    return [p.name for p in parts if p.state is PartState.LEFT and not p.done and p.begun]


FILES: dict[str, tuple[StudyFiles, str]] = {
    "comparison": (comparison.FILES, "metrics"),
    "stability": (stability.FILES, "outcomes"),
    COST: (cost.FILES, "points"),
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
        found = files.contents(folder, table)
        record, rows = found.record, found.tables[table]
    except (FileNotFoundError, DamagedResultsError, SchemaVersionError):
        return job.scenes
    if record.get("complete"):
        return ()
    done = set(zip(rows["scene"], rows["engine"], strict=True))
    done |= {(str(scene), str(engine)) for scene, engine in record.get("left_out") or () if job.study == "stability"}
    engines = list(record.get("engines") or ())
    if job.study == COST:
        return tuple(s for s in job.scenes if not is_timed(rows[rows["scene"] == scene_name(s)]))
    if not engines:
        return job.scenes
    return tuple(s for s in job.scenes if not all((scene_name(s), engine) in done for engine in engines))


def times_left_out(folder: Path) -> str:
    """Why the times of a cost study are no figures of the night; empty if they are."""
    busy = cost.busy_machine(cost.FILES.contents(folder, "points").record)
    return f"no times are compared: {busy}" if busy else ""


def is_timed(points: pd.DataFrame) -> bool:
    """Whether the good points of a scene have the times that a median needs: they are measured in rounds over all."""
    good = points[points["outcome"] == Outcome.PASS.value]
    fewest = np.where(good["seconds"] >= LONG_S, FEWEST_LONG_TURNS, FEWEST_TURNS)
    return bool(len(good) and (good["turns"].fillna(0).to_numpy() >= fewest).all())
