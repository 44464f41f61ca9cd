"""Synthetic tables of a cost study: a fast, a slow and a failing engine."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from adapters.registry import Registration
from barchain.studies.cost.findings import front_of, orders_table, price_table, reach_table
from reports.results.cost import FILES
from tests.studies.cost_points import engine_points, kind_of, point, table, times_of
from tests.support.results import MADE, write_results

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

REFERENCE = Registration("adapters.reference.numpy_engines:Reference", ours=True)


def load_row(engine: str, share: float, low: float, high: float) -> dict[str, object]:
    """Share of the loads in an engine's time."""
    named = {"scene": "s", "engine": engine, "setting": "steps_per_orbit=640"}
    times = {"seconds": 0.01, "seconds_twice": 0.01 * (1.0 + share)}
    return named | times | {"share": share, "share_low": low, "share_high": high}


def write(folder: Path, points: pd.DataFrame, **more: Any) -> Path:
    """Write the tables of a study; `more` joins its record."""
    times = times_of(points)
    points = points.assign(on_front=front_of(points))
    engines = dict.fromkeys(points.engine, REFERENCE)
    made: dict[str, Any] = {"points": points, "orders": orders_table(points, engines, []), "price": price_table(points)}
    made |= {"reach": reach_table(points, times), "loads": [load_row("slow", 0.4, 0.38, 0.43)]}
    record = MADE | {
        "engines": {e: {"version": "1", "title": e, "kind": kind_of(e)} for e in engines},
        "scenes": {s: {"title": f"Scene <{s}>", "orbits": 1.0} for s in dict.fromkeys(points.scene)},
        "certified_solutions": {
            s: {"source": "committed", "precision": "real128", "error": {"attitude": 1e-14}} for s in points.scene
        },
        "left_out": [{"scene": "s", "engine": "gone", "outcome": "missing", "reason": "it is <not> installed"}],
    }
    return write_results(folder, FILES, made, record | more)


def study() -> pd.DataFrame:
    """A fast, a slow and a failing engine, and the one that ratios are given over."""
    steps = [20, 40, 80, 160, 320, 640]
    failed = [
        point("bad", 10, math.nan, math.nan) | {"outcome": "failed", "reason": "gave up", "com_error_m": math.nan}
    ]
    return table(
        engine_points("reference-fast", 8.0, 1e-6, [14, 20, 30, 40, 60, 80]),
        engine_points("slow", 2.0, 1e-3, steps),
        engine_points("slow-er", 2.0, 2e-3, steps),
        failed,
    )
