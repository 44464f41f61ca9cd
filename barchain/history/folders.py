"""Nights from result folders: every figure of a comparison that a later night can be compared with."""

from __future__ import annotations

import hashlib
import json
import math
from typing import TYPE_CHECKING, Any

from barchain.history.figures import CodePart, Figure, FigureKind, FigureUnit, Night, Series
from reports.tables.crossval import is_engine, read_results
from reports.tables.outcome import Outcome, gravest

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    import pandas as pd

    from reports.tables.crossval import Results

ERRORS = ("max", "first_orbit_max", "drift", "normalised_error")
"""Metrics that are errors"""
MAIN = "main"
"""Role of the run that a verdict is about"""
CLASS_DIGITS = 16
HARNESS = "barchain"
"""Name of the part that is barchain itself: reference, adapters, scenes, judge"""
DECIDING = ("cpu", "cpu_flags", "cores", "libc", "blas", "python")
"""Entries of an environment that decide last bits, or times"""


def night_of(folder: Path) -> Night:
    """Night of a result folder.

    Raises
    ------
    FileNotFoundError, DamagedResultsError, SchemaVersionError
        If it holds no comparison, or a damaged one.
    """
    results = read_results(folder)
    record = results.record
    return Night(
        started=str(record.get("created") or ""),
        command=str(record.get("command") or ""),
        barchain=str(record.get("barchain") or ""),
        machine=machine_class(record.get("environment") or {}),
        environment=dict(record.get("environment") or {}),
        parts=tuple(parts_of(record)),
        figures=tuple(figures_of(results)),
        seconds=float(record.get("seconds") or 0.0),
        complete=bool(record.get("finished")),
    )


def machine_class(environment: dict[str, Any]) -> str:
    """Digest of the entries that decide bits and times."""
    text = json.dumps({name: environment.get(name) for name in DECIDING}, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:CLASS_DIGITS]


def parts_of(record: dict[str, Any]) -> Iterator[CodePart]:
    """Barchain, every engine that ran, and the packages below them."""
    keys = (run.get("key", "").split("|") for run in record["runs"])
    sources = {key[3].partition("+")[0] for key in keys if len(key) > 3}
    yield CodePart(HARNESS, str(record.get("barchain") or ""), ",".join(sorted(sources)))
    for name, engine in (record.get("engines") or {}).items():
        if engine.get("external") and not engine.get("missing"):
            yield CodePart(f"engine {name}", str(engine.get("version")), "")
    for name, version in sorted((record.get("packages") or {}).items()):
        yield CodePart(f"package {name}", str(version), "")


def figures_of(results: Results) -> Iterator[Figure]:
    """Figures of every engine in every scene."""
    runs = {(run["scene"], run["engine"]): run for run in results.record["runs"] if run["role"] == MAIN}
    engines = results.record.get("engines") or {}
    for (scene, engine), rows in results.metrics.groupby(["scene", "engine"], sort=True):
        if not is_engine(str(engine)):
            continue
        run = runs.get((scene, engine), {})
        setting = str(run.get("setting") or "")
        name = str(scene), str(engine), setting
        depends = tuple(sorted({HARNESS, *({f"engine {engine}"} if engines.get(engine, {}).get("external") else ())}))
        yield verdict(name, rows, depends)
        yield from errors(name, rows, depends)
        yield from run_figures(name, run, depends)


def verdict(name: tuple[str, str, str], rows: pd.DataFrame, parts: tuple[str, ...]) -> Figure:
    """Outcome of an engine in a scene, with the first reason."""
    outcome = gravest(Outcome(word) for word in rows["outcome"])
    outcome = Outcome.PASS if outcome is Outcome.REPORTED else outcome
    reasons = rows.loc[rows["outcome"] == outcome.value, "reason"]
    reason = next((str(text) for text in reasons if text), "")
    return Figure(
        Series(*name, "run", "outcome", FigureKind.VERDICT), word=str(outcome), reason=reason[:500], parts=parts
    )


def errors(name: tuple[str, str, str], rows: pd.DataFrame, parts: tuple[str, ...]) -> Iterator[Figure]:
    """Errors of an engine in a scene; a row without a number is a missing value with its reason."""
    floors = rows[rows["metric"] == "roundoff_floor"].set_index("quantity")["value"].to_dict()
    for row in rows[rows["metric"].isin(ERRORS)].to_dict("records"):
        unit = FigureUnit(row["unit"] or "1")
        series = Series(*name, str(row["quantity"]), str(row["metric"]), FigureKind.ERROR, unit)
        value = float(row["value"])
        known = math.isfinite(value)
        yield Figure(
            series,
            value=value if known else None,
            roundoff=floors.get(row["quantity"]) if unit is not FigureUnit.NONE else None,
            reason=str(row["reason"])[:500] if known else str(row["reason"])[:500] or "no number",
            parts=parts,
        )


def run_figures(name: tuple[str, str, str], run: dict[str, Any], parts: tuple[str, ...]) -> Iterator[Figure]:
    """Trajectory's digest and counts of the main run."""
    if run.get("digest"):
        yield Figure(Series(*name, "trajectory", "digest", FigureKind.BITS), word=str(run["digest"]), parts=parts)
    for quantity, value in sorted((run.get("info") or {}).items()):
        if isinstance(value, int) and not isinstance(value, bool):
            yield Figure(Series(*name, str(quantity)[:60], "count", FigureKind.COUNT), value=float(value), parts=parts)
