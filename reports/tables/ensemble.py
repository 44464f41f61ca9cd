"""Stored tables of an ensemble: everything that its page is rendered from.

A folder ``ensemble`` inside a result folder holds

``quantiles.csv``
    tidy: a row for each instant, quantity, item (bar or joint, from 1) and quantile, columns :data:`QUANTILE_COLUMNS`;
    ``runs`` is the number of runs that reached the instant;
``runs.csv``
    a row for each run: the drawn values, the outcome (finished, ended or failed), its reason, steps, evaluations;
``record.json``
    the scene, the distributions, counts of outcomes, wall time of each phase, and the provenance.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from reports.tables.files import StudyFiles
from reports.tables.rows import COUNT, Followed, Rows, records
from reports.tables.schema import Record

if TYPE_CHECKING:
    from pathlib import Path

    from reports.tables.files import StudyTables

QUANTILE_COLUMNS = ("t_s", "quantity", "item", "quantile", "value", "unit", "runs")


class EnsembleRecord(Record):
    """Entries of the record."""

    scene: dict[str, Any] | None = None
    vary: list[str] | None = None
    runs: int | None = None
    rtol: float | None = None
    seed: int | None = None
    key: str | None = None
    outcomes: dict[str, int] | None = None
    phases_s: dict[str, float] | None = None
    evaluations: int | None = None


WORDS = ("quantity", "unit", "outcome", "reason")
FILES = StudyFiles(
    "ensemble",
    {"quantiles": QUANTILE_COLUMNS, "runs": ()},
    WORDS,
    model=EnsembleRecord,
    pages=("ensemble.html",),
)


def read_ensemble(folder: Path) -> StudyTables:
    """Record and quantiles of the ensemble in a result folder, without its runs; errors as `FILES.contents`."""
    return FILES.contents(folder, "quantiles")


ENGINE = "reference-fast"
FOLLOWED = {
    "quantile": Followed("value", "{quantity}.{item:g}.q{quantile:g}"),
    COUNT: Followed("count", "runs.{quantity}"),
}


def ensemble_rows(folder: Path) -> Rows:
    """Rows of an ensemble: quantiles at the last instant, counts of outcomes, and times; the table has all instants."""
    tables = read_ensemble(folder)
    record = tables.record
    found = Rows(FILES.name, str((record.get("scene") or {}).get("name") or ""))
    setting = f"rtol={record.get('rtol')} seed={record.get('seed')} runs={record.get('runs')}"
    place: dict[str, Any] = {"engine": ENGINE, "setting": setting}
    last = tables.quantiles[tables.quantiles["t_s"] == tables.quantiles["t_s"].max()]
    for row in records(last):
        where = place | {name: row[name] for name in ("quantity", "item", "quantile")}
        found.add("quantile", row["value"], row["unit"] or "1", until_s=row["t_s"], **where)
    for outcome, runs in (record.get("outcomes") or {}).items():
        found.add(COUNT, runs, quantity=outcome, **place)
    for phase, seconds in (record.get("phases_s") or {}).items():
        found.add("seconds", seconds, "s", quantity=phase, **place)
    return found
