"""Rows of a parameter sweep, as the tables that its page is rendered from.

``values``
    a row for each run and number that varies, named by its path in the scene's file;
``runs``
    a row for each run of each engine;
``measures``
    a row for each measure of each run, e.g. ``largest(reaction_N)``; NaN where a run does not give it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.results.effects import scene_of
from reports.results.files import StudyFiles
from reports.results.schema import StudyRecord
from reports.results.table import Table

if TYPE_CHECKING:
    import pandas as pd

TABLES = {
    "values": Table(("run", "quantity"), "varied", {"value": ".value", "unit": ".unit"}, sizes=("run",)),
    "runs": Table(
        ("engine", "setting", "run"),
        "run",
        {"outcome": ".outcome", "reason": ".reason", "seconds": "seconds:simulate s"},
        sizes=("run",),
    ),
    "measures": Table(
        ("engine", "setting", "run", "quantity"), "measured", {"value": ".value", "unit": ".unit"}, sizes=("run",)
    ),
}


def samples_of(values: pd.DataFrame, runs: pd.DataFrame, measures: pd.DataFrame) -> pd.DataFrame:
    """Table with a row for each run of each engine, and a column for each number that varies and each measure."""
    order = list(dict.fromkeys(runs["engine"]))
    lines = runs.set_index(["engine", "run"]).sort_index(key=lambda k: k.map(order.index) if k.name == "engine" else k)
    varied, measured = wide(values, ["run"]), wide(measures, ["engine", "run"])
    found = lines[["setting"]].join(varied, on="run").join(lines[["outcome", "reason", "seconds"]]).join(measured)
    return found.reset_index().astype({"run": int})


def wide(table: pd.DataFrame, index: list[str]) -> pd.DataFrame:
    """Values with a column for each quantity, in the order in which they first come."""
    found = table.pivot(index=index, columns="quantity", values="value")
    return found[list(dict.fromkeys(table["quantity"]))].rename_axis(columns=None)


FILES = StudyFiles(
    "sweep",
    TABLES,
    place=scene_of,
    model=StudyRecord,
    title="Parameter sweep",
    view="sweep:view_sweep",
)
