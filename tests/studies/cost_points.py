"""Synthetic points of a cost study: engines of known order and speed."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from reports.results.cost import INDEPENDENT, OWN_EQUATIONS, TABLES

if TYPE_CHECKING:
    import pandas as pd

FLOOR = 1e-14


def engine_points(
    engine: str, order: float, seconds_at_1: float, steps: list[int], *, scene: str = "s", least: float = 0.0
) -> list[dict[str, Any]]:
    """Points with error (10/steps)^order, never below `least`, at `seconds_at_1` a step."""
    return [
        point(engine, n, max((10.0 / n) ** order, least), seconds_at_1 * n, scene=scene) | {"step_s": 1.0 / n}
        for n in steps
    ]


def point(engine: str, n: int, error: float, seconds: float, *, scene: str = "s") -> dict[str, Any]:
    """One good point."""
    errors = {"attitude_error_rad": error, "reaction_error_N": error, "reaction_relative": error, "com_error_m": error}
    floors = {name: FLOOR for name in TABLES["points"].columns if "_floor_" in name}
    setting = {"setting": f"steps_per_orbit={n}", "parameter": "steps_per_orbit", "value": float(n)}
    spent = {"seconds": seconds, "evaluations": float(2 * n), "steps": float(n), "turns": 5}
    named = {"scene": scene, "engine": engine, "outcome": "pass", "reason": "", "under_floor": ""}
    return named | setting | errors | floors | spent


def table(*rows: list[dict[str, Any]]) -> pd.DataFrame:
    """Points as the study has them."""
    found = TABLES["points"].framed(r for some in rows for r in some)
    return found.assign(kind=[kind_of(engine) for engine in found.engine])


def kind_of(engine: str) -> str:
    """Kind of a synthetic engine."""
    return OWN_EQUATIONS if engine.startswith("reference") else INDEPENDENT


def times_of(points: pd.DataFrame, spread: float = 0.05, turns: int = 7, seed: int = 1) -> dict[Any, np.ndarray]:
    """Measured times about each point's own, by a few percent."""
    rng = np.random.default_rng(seed)
    return {
        (r.scene, r.engine, r.setting): r.seconds * np.exp(spread * rng.standard_normal(turns))
        for r in points.itertuples()
        if not math.isnan(r.seconds)
    }
