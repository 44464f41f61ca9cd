"""Figures of the studies that judge: stability, self-test, campaign, and the quantiles of an ensemble."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from barchain.nightly.history.folders.collector import FigureCollector, records
from barchain.nightly.history.folders.comparison import add_runs
from barchain.nightly.history.model.figures import FigureKind, FigureUnit
from reports.tables.ensemble import read_ensemble
from reports.tables.faults.campaign import ALL, read_campaign
from reports.tables.faults.selftest import read_selftest
from reports.tables.stability import read_stability

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.nightly.history.model.figures import Figure

Row = dict[str, Any]


def stability_figures(folder: Path) -> tuple[Figure, ...]:
    """Classes of stability, steps of each run, and the bits of the trajectories."""
    tables, found = read_stability(folder), FigureCollector("stability")
    for row in records(tables.outcomes):
        found.word((row["scene"], row["engine"], ""), "class", FigureKind.VERDICT, row["stability"], row["reason"])
    for row in records(tables.evidence):
        place = (row["scene"], row["engine"], row["setting"])
        found.word(place, f"run.{row['level']}", FigureKind.VERDICT, row["run"], row["reason"])
        found.counts(place, {"steps": row["steps"]}, f"{row['level']}.")
    add_runs(found, tables.folder, tables.record)
    return found.figures


def selftest_figures(folder: Path) -> tuple[Figure, ...]:
    """Outcome of each fault in each scene."""
    tables, found = read_selftest(folder), FigureCollector("selftest")
    host = str(tables.record.get("host") or "")
    for row in records(tables.cells):
        found.word((row["scene"], host, row["fault"]), "fate", FigureKind.VERDICT, row["fate"], row["why"])
    return found.figures


def campaign_figures(folder: Path) -> tuple[Figure, ...]:
    """Class of each cell, and the rates with their intervals; scenes of other seeds are other figures."""
    tables, found = read_campaign(folder), FigureCollector("campaign")
    for row in records(tables.cells):
        found.word(
            (row["scene"], row["engine"], row["fault"]), "class", FigureKind.VERDICT, row["class"], row["reason"]
        )
    for row in (row for row in records(tables.rates) if row["by"] == ALL):
        name, ends = f"rate.{row['what']}", {"low": row["low"], "high": row["high"]}
        found.number(("", "", ""), name, FigureKind.VALUE, row["rate"], reason="none tried", **ends)
    return found.figures


def ensemble_figures(folder: Path) -> tuple[Figure, ...]:
    """Quantiles at the last instant, and counts of outcomes."""
    tables, found = read_ensemble(folder), FigureCollector("ensemble")
    record = tables.record
    scene = str((record.get("scene") or {}).get("name") or "")
    engine, setting = "reference-fast", f"rtol={record.get('rtol')} seed={record.get('seed')} runs={record.get('runs')}"
    last = tables.quantiles[tables.quantiles["t_s"] == tables.quantiles["t_s"].max()]
    for row in (row for row in records(last) if row["unit"] in set(FigureUnit)):
        name = f"{row['quantity']}.{row['item']:g}.q{row['quantile']:g}"
        place, bound = (scene, engine, setting), row["error_bound"]
        found.number(place, name, FigureKind.VALUE, row["value"], row["unit"] or "1", tolerance=bound)
    found.counts((scene, engine, setting), record.get("outcomes") or {}, "runs.")
    return found.figures
