"""Record of a comparison: outcome and errors of each engine in each scene."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from reports.results.comparison import read_results
from reports.results.outcome import Outcome, gravest
from scenarios.channels import CHANNELS

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

QUANTITIES = {name: CHANNELS[name].column_of() for name in ("attitude", "reaction", "com")}


def comparison_rows(folder: Path) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """A row for each scene and engine of a result folder, and its record."""
    results = read_results(folder)
    rows = results.metrics
    rows = rows[~rows.engine.str.startswith("(") & ~rows.scene.str.startswith("(")]
    pairs = rows.groupby(["scene", "engine"], sort=False)
    return [row_of(str(scene), str(engine), own) for (scene, engine), own in pairs], results.record


def row_of(scene: str, engine: str, rows: pd.DataFrame) -> dict[str, Any]:
    """Outcome of a pair, its errors up to the predictability limit, and its reason."""
    outcome = gravest(Outcome(word) for word in rows.outcome)
    reasons = [reason for reason in rows[rows.outcome == outcome.value].reason if reason]
    limits = rows[rows.metric == "detection_limit"].value.astype(float)
    found = {
        "scene": scene,
        "engine": engine,
        "setting": next((s for s in rows.setting if s), ""),
        "outcome": outcome.value,
        "detection_limit": float(limits.max()) if len(limits) else math.nan,
        "limit_s": float(rows.limit_s.astype(float).min()) if rows.limit_s.notna().any() else math.nan,
        "reason": reasons[0] if reasons and outcome is not Outcome.PASS else "",
    }
    return found | {column: largest(rows, name) for name, column in QUANTITIES.items()}


def largest(rows: pd.DataFrame, quantity: str) -> float:
    """Largest difference of a quantity from the judging solution; NaN without one."""
    values = rows[(rows.quantity == quantity) & (rows.metric == "max")].value
    return float(values.iloc[0]) if len(values) else math.nan


def version_rows(record: dict[str, Any]) -> list[dict[str, Any]]:
    """Version of each engine."""
    return [{"engine": name, "version": facts["version"]} for name, facts in record["engines"].items()]
