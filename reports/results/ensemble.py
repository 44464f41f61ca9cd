"""Rows of an ensemble, and the series that its page is rendered from.

``quantiles``
    tidy: a row for each instant, quantity, item (bar or joint, from 1) and quantile; ``runs`` is the number of runs
    that reached the instant; those of the last instant are rows of the study too;
``runs``
    a row for each run: the drawn values, the outcome (finished, ended or failed), its reason, steps, evaluations.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from reports.results.effects import scene_of
from reports.results.files import StudyFiles
from reports.results.rows import COUNT, Followed, records
from reports.results.schema import StudyRecord

if TYPE_CHECKING:
    from collections.abc import Mapping

    import pandas as pd

    from reports.results.rows import Rows

QUANTILE_COLUMNS = ("t_s", "quantity", "item", "quantile", "value", "unit", "runs")
ENGINE = "reference-fast"
FOLLOWED = {
    "quantile": Followed("value", "{quantity}.{item:g}.q{quantile:g}"),
    COUNT: Followed("count", "runs.{quantity}"),
}


def place_of(record: Mapping[str, Any]) -> dict[str, str]:
    """Scene, engine and setting of all rows."""
    setting = f"rtol={record.get('rtol')} seed={record.get('seed')} runs={record.get('runs')}"
    return scene_of(record) | {"engine": ENGINE, "setting": setting}


def add_rows(found: Rows, quantiles: pd.DataFrame, record: Mapping[str, Any]) -> None:
    """Add the quantiles at the last instant, counts of outcomes, and times."""
    place: dict[str, Any] = {**place_of(record)}
    for row in records(quantiles[quantiles["t_s"] == quantiles["t_s"].max()]):
        named = {name: row[name] for name in ("quantity", "item", "quantile")}
        found.add("quantile", row["value"], row["unit"], until_s=row["t_s"], **named, **place)
    for outcome, runs in record["outcomes"].items():
        found.add(COUNT, runs, quantity=outcome, **place)
    for phase, seconds in record["phases_s"].items():
        found.add("seconds", seconds, "s", quantity=phase, **place)


FILES = StudyFiles(
    "ensemble",
    series={"quantiles": QUANTILE_COLUMNS, "runs": ()},
    followed=FOLLOWED,
    model=StudyRecord,
    title="Ensemble of perturbed runs",
    view="ensemble:view_ensemble",
)
