"""Cost of each engine at a given error, and the ratios of these costs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.run.timing.statistics import (
    CurvePosition,
    Interval,
    WorkPrecisionCurve,
    cost_at,
    interval,
    locate,
    lower_envelope,
    parts,
)
from barchain.studies.cost.points import TELLS
from reports.tables.cost import BASELINE
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Mapping

    import pandas as pd

    from adapters.trajectory import Array

TARGETS = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-11)
QUANTITIES = {
    "attitude": ("attitude_error_rad", "attitude_floor_rad"),
    "reaction": ("reaction_relative", "reaction_floor_relative"),
    "com": ("com_error_m", "com_floor_m"),
}
MEASURES = ("seconds", "evaluations")


@dataclass(frozen=True)
class Reached:
    """One engine at one target."""

    engine: str
    curve: WorkPrecisionCurve
    position: CurvePosition

    @property
    def cost(self) -> float:
        """Interpolated cost."""
        return cost_at(self.curve, self.position)

    @property
    def spread(self) -> Interval:
        """Cost with its interval."""
        return interval(self.cost, parts(self.curve, self.position))

    def over(self, other: Reached) -> Interval:
        """Cost relative to the other's, with the interval of the ratio."""
        if other.engine == self.engine:
            return Interval(1.0, 1.0, 1.0)
        made_of = [*parts(self.curve, self.position), *parts(other.curve, other.position, -1.0)]
        return interval(self.cost / other.cost, made_of)


def curve_of(
    rows: pd.DataFrame, quantity: str, measure: str, times: Mapping[tuple[str, str, str], Array]
) -> WorkPrecisionCurve:
    """Envelope of one engine's points on one scene.

    Failed points do not count. An error below the certified solution's own counts as the smallest that is resolved:
    the engine is at least that accurate, and no verdict is given beyond.
    """
    error_name, floor_name = QUANTITIES[quantity]
    good = rows[rows.outcome == Outcome.PASS.value]
    if error_name not in good or measure not in good:
        return lower_envelope([], [])
    told = np.maximum(good[error_name].to_numpy(float), TELLS * good[floor_name].to_numpy(float))
    cost = good[measure].to_numpy(float)
    keys = good[["scene", "engine", "setting"]].itertuples(index=False, name=None)
    samples = [times.get(k, np.empty(0)) for k in keys] if measure == "seconds" else []
    return lower_envelope(told.tolist(), cost.tolist(), samples)


def curves_of(
    points: pd.DataFrame, scene: str, quantity: str, measure: str, times: Mapping[tuple[str, str, str], Array]
) -> dict[str, WorkPrecisionCurve]:
    """Curves of all engines that have any point on a scene."""
    rows = points[points.scene == scene]
    found = {e: curve_of(rows[rows.engine == e], quantity, measure, times) for e in dict.fromkeys(rows.engine)}
    return {e: c for e, c in found.items() if len(c.error)}


def reach_rows(
    points: pd.DataFrame, scene: str, quantity: str, measure: str, times: Mapping[tuple[str, str, str], Array]
) -> list[dict[str, Any]]:
    """Rows of reach.csv for one scene: every engine at every target; the fastest is that of an engine's own kind."""
    curves = curves_of(points, scene, quantity, measure, times)
    kinds = dict(zip(points.engine, points.kind, strict=True))
    least = TELLS * floor_of(points[points.scene == scene], quantity)
    rows: list[dict[str, Any]] = []
    for target in TARGETS:
        status = "no verdict" if target < least else "not reached"
        found = {e: Reached(e, c, p) for e, c in curves.items() if (p := locate(c, target)) is not None}
        fastest = {kinds[r.engine]: r for r in sorted(found.values(), key=lambda r: r.cost, reverse=True)}
        base = {"scene": scene, "quantity": quantity, "measure": measure, "target": target}
        for engine in curves:
            columns = reached_columns(found.get(engine), fastest.get(kinds[engine]), found.get(BASELINE))
            rows.append(base | {"engine": engine, "kind": kinds[engine], "status": status} | columns)
    return rows


def reached_columns(mine: Reached | None, fastest: Reached | None, baseline: Reached | None) -> dict[str, Any]:
    """Columns of one engine at one target."""
    if mine is None:
        return {}
    cost = mine.spread
    found: dict[str, Any] = {
        "status": "at most" if mine.position.at_most else "reached",
        "cost": cost.value,
        "cost_low": cost.low,
        "cost_high": cost.high,
    }
    for name, other in (("fastest", fastest), ("baseline", baseline)):
        if other is not None:
            ratio = mine.over(other)
            found |= {f"over_{name}": ratio.value, f"over_{name}_low": ratio.low, f"over_{name}_high": ratio.high}
    found["fastest"] = "" if fastest is None else fastest.engine
    return found


def floor_of(rows: pd.DataFrame, quantity: str) -> float:
    """Certified solution's own error of a quantity on a scene; 0 if unknown."""
    name = QUANTITIES[quantity][1]
    return float(rows[name].max()) if name in rows and rows[name].notna().any() else 0.0


def least_error(rows: pd.DataFrame, quantity: str) -> float:
    """Smallest error that an engine reaches in good runs; NaN if none."""
    name = QUANTITIES[quantity][0]
    good = rows[rows.outcome == Outcome.PASS.value]
    return float(good[name].min()) if name in good and good[name].notna().any() else math.nan
