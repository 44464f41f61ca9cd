"""Cost of each engine at a given error, and the ratios of these costs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.runs.timing.statistics import (
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
from reports.tables.rows import NOT_RUN

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
LONGER = "past the time limit"  # in the reason of a point that is not tried
SHORTENED = "the time budget is half used"  # in that of one past the limit that is shortened then


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
    own = {str(e): rows for e, rows in points[points.scene == scene].groupby("engine", sort=False)}
    reasons = {e: stopped(rows) for e, rows in own.items()}
    shown = [e for e in own if e in curves or not (own[e].outcome == Outcome.PASS.value).any()]
    kinds = dict(zip(points.engine, points.kind, strict=True))
    least = TELLS * floor_of(points[points.scene == scene], quantity)
    rows: list[dict[str, Any]] = []
    for target in TARGETS:
        status = "no verdict" if target < least else "not reached"
        found = {e: Reached(e, c, p) for e, c in curves.items() if (p := locate(c, target)) is not None}
        fastest = {kinds[r.engine]: r for r in sorted(found.values(), key=lambda r: r.cost, reverse=True)}
        base = {"scene": scene, "quantity": quantity, "measure": measure, "target": target}
        for engine in shown:
            columns = reached_columns(found.get(engine), fastest.get(kinds[engine]), found.get(BASELINE))
            reason = "" if columns or status == "no verdict" else reasons[engine]
            named = {"engine": engine, "kind": kinds[engine], "status": status, "reason": reason}
            rows.append(base | named | columns)
    return rows


def stopped(rows: pd.DataFrame) -> str:
    """Why an engine has no finer good point than its finest one; empty if it ran its whole sweep, coarse to fine."""
    good = (rows.outcome == Outcome.PASS.value).to_numpy(bool)
    later = rows.iloc[int(good.nonzero()[0].max()) + 1 :] if good.any() else rows
    if not len(later):
        return ""
    outcome, reason = str(later.outcome.iloc[0]), str(later.reason.iloc[0])
    if not reason.startswith(NOT_RUN):
        return outcome.replace("_", " ")
    if SHORTENED in reason:
        return f"{NOT_RUN}: budget"
    return f"{NOT_RUN}: time limit" if LONGER in reason else ""


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
