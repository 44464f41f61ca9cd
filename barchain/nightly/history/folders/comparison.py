"""Figures of a comparison: verdicts, errors with their rounding, counters, and the bits of the trajectories."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.nightly.history.folders.collector import FigureCollector, records
from barchain.nightly.history.model.figures import FigureKind
from barchain.run.job import Role
from barchain.run.store import recorded_runs
from reports.tables.crossval import ALL_SCENES, ROUNDING, is_engine, read_results, recorded_parquet
from reports.tables.outcome import Outcome, gravest

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

    from barchain.nightly.history.model.figures import Figure

ERROR_METRICS = ("max", "rms", "final", "first_orbit_max", "drift")
CHAOTIC = frozenset({"relative_energy"})
"""Quantities that are looked at beyond the predictability limit, where rounding decides them: no figures"""
BITS_ROLES = (Role.MAIN, Role.FINER)
DIGITS = 32
Row = dict[str, Any]
Place = tuple[str, str, str]


def comparison_figures(folder: Path) -> tuple[Figure, ...]:
    """Figures of a folder that compare or crossval wrote.

    Raises
    ------
    FileNotFoundError, DamagedResultsError, SchemaVersionError
        As :func:`reports.tables.crossval.read_results`.
    """
    results = read_results(folder)
    found = FigureCollector()
    bits = add_runs(found, folder, results.record)
    for place, rows in by_place(results.metrics).items():
        add_verdict(found, place, rows)
        add_errors(found, place, rows, bits.get(place, ""))
    return found.figures


def by_place(metrics: pd.DataFrame) -> dict[Place, list[Row]]:
    """Rows of each scene, engine and setting; rows about several engines or scenes are left out."""
    found: dict[Place, list[Row]] = {}
    for row in records(metrics):
        if is_engine(row["engine"]) and row["scene"] != ALL_SCENES:
            found.setdefault((row["scene"], row["engine"], row["setting"]), []).append(row)
    return found


def add_verdict(found: FigureCollector, place: Place, rows: list[Row]) -> None:
    """Add the gravest outcome of an engine in a scene; the setting is no part of its name, so that it is followed."""
    worst = gravest(Outcome(row["outcome"]) for row in rows)
    reason = next((row["reason"] for row in rows if row["outcome"] == worst and row["reason"]), "")
    found.word((*place[:2], ""), "verdict", FigureKind.VERDICT, str(worst), reason)


def add_errors(found: FigureCollector, place: Place, rows: list[Row], trajectory: str) -> None:
    """Add the errors of an engine in a scene, each with the share of rounding in it."""
    rounding = {row["quantity"]: row["value"] for row in rows if row["metric"] == ROUNDING}
    for row in (row for row in rows if row["metric"] in ERROR_METRICS and row["quantity"] not in CHAOTIC):
        found.number(
            place, f"{row['quantity']}.{row['metric']}", FigureKind.ERROR, row["value"], row["unit"],
            reason=row["reason"] or row["outcome"], tolerance=rounding.get(row["quantity"]), trajectory=trajectory,
        )  # fmt: skip
    limits = [row["limit_s"] for row in rows if row["metric"] == "max" and row["quantity"] == "attitude"]
    if limits:
        found.number(place, "predictability_limit", FigureKind.VALUE, limits[0], "s", trajectory=trajectory)


def add_runs(found: FigureCollector, folder: Path, record: dict[str, Any]) -> dict[Place, str]:
    """Add bits and counters of runs, and return the digests of the main runs' trajectories."""
    bits = {}
    for run in recorded_runs(record):
        if run["role"] not in BITS_ROLES:
            continue
        place, main = (run["scene"], run["engine"], run["setting"]), run["role"] == Role.MAIN
        frame = recorded_parquet(folder, run["file"], record) if run.get("file") else None
        word = "" if frame is None else frame_digest(frame)
        quantity = "trajectory" if main else f"trajectory.{run['role']}"
        found.word(place, quantity, FigureKind.BITS, word, "" if word else run["reason"] or run["outcome"])
        if main:
            bits[place] = word
            found.counts(place, run.get("info", {}))
    return bits


def frame_digest(frame: pd.DataFrame) -> str:
    """Digest of a trajectory's numbers, bit for bit; how they are stored does not count."""
    found = hashlib.sha256()
    for name in sorted(map(str, frame.columns)):
        values = np.ascontiguousarray(frame[name].to_numpy(np.float64), dtype="<f8")
        found.update(f"{name}\0{len(values)}\0".encode() + values.tobytes())
    return found.hexdigest()[:DIGITS]
