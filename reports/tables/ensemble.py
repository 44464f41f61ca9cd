"""Rows of an ensemble, and the series that its page is rendered from.

``quantiles``
    tidy: a row for each instant, quantity, item (bar or joint, from 1) and quantile; ``runs`` is the number of runs
    that reached the instant; those of the last instant are rows of the study too;
``runs``
    a row for each run: the drawn values, the outcome (finished, ended or failed), its reason, steps, evaluations.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from reports.tables.effects import scene_of
from reports.tables.files import StudyFiles
from reports.tables.rows import COUNT, Followed, Rows
from reports.tables.schema import StudyRecord
from reports.tables.table import Table

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from reports.tables.files import Frames, StudyTables

QUANTILE_COLUMNS = ("t_s", "quantity", "item", "quantile", "value", "unit", "runs")


LAST = Table(
    ("quantity", "item", "quantile"),
    "quantile",
    {"value": "value", "unit": "unit", "until_s": "t_s"},
    sizes=("item", "quantile"),
)
"""Quantiles at the last instant"""
ENGINE = "reference-fast"
FOLLOWED = {
    "quantile": Followed("value", "{quantity}.{item:g}.q{quantile:g}"),
    COUNT: Followed("count", "runs.{quantity}"),
}


def place_of(record: Mapping[str, Any]) -> dict[str, str]:
    """Scene, engine and setting of all rows."""
    setting = f"rtol={record.get('rtol')} seed={record.get('seed')} runs={record.get('runs')}"
    return scene_of(record) | {"engine": ENGINE, "setting": setting}


def counts(tables: Frames, record: Mapping[str, Any]) -> Rows:
    """Counts of outcomes, and times."""
    del tables
    found = Rows(FILES.study)
    place: dict[str, Any] = {**place_of(record)}
    for outcome, runs in (record.get("outcomes") or {}).items():
        found.add(COUNT, runs, quantity=outcome, **place)
    for phase, seconds in (record.get("phases_s") or {}).items():
        found.add("seconds", seconds, "s", quantity=phase, **place)
    return found


FILES = StudyFiles(
    "ensemble",
    {"last": LAST},
    {"quantiles": QUANTILE_COLUMNS, "runs": ()},
    followed=FOLLOWED,
    derived=counts,
    place=place_of,
    model=StudyRecord,
    title="Ensemble of perturbed runs",
    view="ensemble:view_ensemble",
)


def read_ensemble(folder: Path) -> StudyTables:
    """Record and quantiles of the ensemble in a result folder, without its runs; errors as `FILES.contents`."""
    return FILES.contents(folder, "quantiles")
