"""Rows of recorded runs: times of their phases, counters, words, and the bits of their trajectories."""

from __future__ import annotations

import hashlib
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from reports.tables.reading import recorded_parquet
from reports.tables.rows import Followed, known

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    import pandas as pd

    from reports.tables.rows import Rows

MAIN, FINER = "main", "finer"
"""Roles of the runs whose bits are rows"""
BITS, COUNT = "trajectory", "count"
DIGITS = 32
FOLLOWED = {BITS: Followed("bits", "{metric}.{role}"), COUNT: Followed("count", "{level}.{quantity}")}
"""How nights follow the rows of runs"""


def add_runs(found: Rows, folder: Path, record: dict[str, Any]) -> None:
    """Add the rows of all runs in a record.

    Raises
    ------
    DamagedResultsError
        If a trajectory is damaged, or another than the record describes.
    """
    named = {tuple(run[k] for k in ("scene", "engine", "setting", "role")): run for run in record.get("runs") or ()}
    for (scene, engine, setting, role), run in named.items():
        place: dict[str, Any] = {"scene": scene, "engine": engine, "setting": setting}
        where = place if role == MAIN else place | {"role": role}
        for phase, seconds in run.get("seconds", {}).items():
            found.add("seconds", seconds, "s", quantity=phase, **where)
        if role in (MAIN, FINER):
            found.add(
                BITS, text=bits_of(run, folder, record), outcome=run["outcome"], reason=run.get("reason", ""), **where
            )
        if role == MAIN:
            add_info(found, run.get("info", {}), **where)


def add_info(found: Rows, info: Mapping[str, Any], **where: Any) -> None:
    """Add what an engine tells of a run: whole numbers as counts, other numbers as values, words as texts."""
    for name, value in info.items():
        if isinstance(value, str):
            found.add(name, text=value, **where)
        elif known(value) and not isinstance(value, bool):
            whole = is_count(value) and not name.endswith("_s")
            found.add(COUNT if whole else "value", value, "s" if name.endswith("_s") else "1", quantity=name, **where)


def is_count(value: float) -> bool:
    """Whether a number is whole and not negative."""
    return math.isfinite(value) and value == int(value) and value >= 0.0


def bits_of(run: Mapping[str, Any], folder: Path, record: dict[str, Any]) -> str:
    """Digest of a run's trajectory; empty if it left none."""
    if run.get("bits"):
        return str(run["bits"])
    frame = recorded_parquet(folder, run["file"], record) if run.get("file") else None
    return "" if frame is None else frame_digest(frame)


def frame_digest(frame: pd.DataFrame) -> str:
    """Digest of a trajectory's numbers, bit for bit; how they are stored does not count."""
    found = hashlib.sha256()
    for name in sorted(map(str, frame.columns)):
        values = np.ascontiguousarray(frame[name].to_numpy(np.float64), dtype="<f8")
        found.update(f"{name}\0{len(values)}\0".encode() + values.tobytes())
    return found.hexdigest()[:DIGITS]
