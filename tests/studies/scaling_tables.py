"""Synthetic tables of a scaling study."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pandas as pd

from barchain.record.study_store import StudyStore
from barchain.studies.defaults import BARS, FAST
from barchain.studies.scaling.study import fits_table, targets
from reports.results.rows import NOT_RUN
from reports.results.scaling import FILES, POINTS
from reports.results.schema import KEY, SCHEMA_VERSION
from tests.support.results import MADE

if TYPE_CHECKING:
    from pathlib import Path

SCENE = "paper/fig13"
MEGABYTE = 2.0**20


def row(engine: str, bars: int, **columns: Any) -> dict[str, Any]:
    """Row of the points."""
    return {"engine": engine, "bars": bars, "outcome": "pass", "reason": "", "per": "right-hand side"} | columns


def synthetic() -> pd.DataFrame:
    """A linear engine, and one that counts steps and stops."""
    rows = [
        row(FAST, n, evaluation_s=20e-9 * n, orbit_s=1e-9 * n**2, evaluations=30.0 * n, memory_B=200.0 * n, share=1.0)
        for n in BARS
    ]
    rows += [
        row("stepper", n, evaluation_s=1e-6 * n**1.5, orbit_s=1e-2 * n**1.5, per="steps", steps=1e4,
            share=1.0 if n < 50 else 0.2, memory_B=3 * MEGABYTE * n)
        for n in (2, 5, 10, 20, 50, 100)
    ]  # fmt: skip
    stop = {"outcome": NOT_RUN, "reason": "would take about <300> s", "per": ""}
    table = pd.DataFrame([*rows, row("stepper", 200) | stop])
    return table.reindex(columns=list(POINTS.columns))


def write(folder: Path) -> Path:
    """Tables of a study."""
    points = synthetic()
    fits = fits_table(points)
    record = MADE | {
        KEY: SCHEMA_VERSION,
        "scene": {"name": SCENE, "size_m": 500.0},
        "targets": targets(points, fits),
        "limits": {"time_limit_s": 10.0},
    }
    folder.mkdir(parents=True, exist_ok=True)
    store = StudyStore(FILES, folder, record)
    store.write("points", points)
    store.write("exponents", fits)
    store.end(12.0, complete=True)
    return folder
