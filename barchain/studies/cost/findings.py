"""Tables drawn from the points: orders of convergence, cost to reach an error, price of a digit, Pareto front."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.engine import AccuracyParameter
from barchain.runs.asking import declarations_of
from barchain.studies.cost.errors import TELLS
from barchain.studies.timing.statistics import (
    SCATTERED,
    STRAIGHT,
    Interval,
    OrderFit,
    WorkPrecisionCurve,
    cost_at,
    fit_order,
    interval,
    locate,
    lower_envelope,
    on_front,
    parts,
    price_of_a_digit,
)
from reports.results.cost import BASELINE, INTERRUPTED, TABLES
from reports.results.outcome import Outcome
from reports.results.rows import NOT_RUN, NotRun

if TYPE_CHECKING:
    from collections.abc import Mapping

    import pandas as pd

    from adapters.registry import Registration
    from adapters.trajectory import Array

TARGETS = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-11)
QUANTITIES = {
    "attitude": ("attitude_error_rad", "attitude_floor_rad"),
    "reaction": ("reaction_relative", "reaction_floor_relative"),
    "com": ("com_error_m", "com_floor_m"),
}
MEASURES = ("seconds", "evaluations")


def judged(rows: pd.DataFrame, quantity: str) -> pd.DataFrame:
    """Good runs whose error of a quantity exceeds that of the certified solution."""
    error, floor = QUANTITIES[quantity]
    if error not in rows:
        return rows.iloc[:0]
    return rows[(rows.outcome == Outcome.PASS.value) & (rows[error] >= TELLS * rows[floor])]


def order_row(rows: pd.DataFrame, quantity: str, theory: float | None) -> dict[str, Any]:
    """Order of one engine on one scene: against its step, or against evaluations if it chooses its steps."""
    fixed = bool((rows.parameter == AccuracyParameter.STEPS_PER_ORBIT.value).all())
    told = judged(rows, quantity)
    x = told.step_s.to_numpy(float) if fixed else 1.0 / told.evaluations.to_numpy(float)
    error = told[QUANTITIES[quantity][0]].to_numpy(float)
    fit = fit_order(x, error, STRAIGHT if fixed else SCATTERED) if len(told) else None
    against = "step" if fixed else "evaluations"
    first = rows.iloc[0]
    found = {"scene": first.scene, "engine": first.engine, "quantity": quantity, "against": against}
    return found | fit_columns(fit) | {"theory": theory, "least_error": least_error(rows, quantity)}


def fit_columns(fit: OrderFit | None) -> dict[str, Any]:
    """Columns of a fitted order, or why there is none."""
    if fit is None:
        return {"reason": "too few points"}
    ends = {"points": fit.points, "error_from": fit.error_range[0], "error_to": fit.error_range[1]}
    return fit.order.columns("order") | ends


def equal_steps_row(scene: str, step_s: Array, error: Array, theory: float) -> dict[str, Any]:
    """Order of the reference's method at equal steps."""
    found = {"scene": scene, "engine": "reference", "quantity": "attitude", "against": "equal steps"}
    return found | fit_columns(fit_order(step_s, error)) | {"theory": theory, "least_error": math.nan}


def orders_table(
    points: pd.DataFrame, engines: Mapping[str, Registration], extra: list[dict[str, Any]]
) -> pd.DataFrame:
    """All orders; `extra` are rows measured apart."""
    rows = []
    for (_, engine), own in points.groupby(["scene", "engine"], sort=False):
        theory = declarations_of(engines[str(engine)]).order
        shown = [q for q, (error, _) in QUANTITIES.items() if error in own and own[error].notna().any()]
        wanted = shown if shown == ["com"] else [q for q in shown if q != "com"]
        rows += [order_row(own, quantity, theory) for quantity in wanted]
    return TABLES["orders"].framed(rows + extra)


def unknown_orders(orders: pd.DataFrame) -> pd.DataFrame:
    """Orders of an interrupted study: finer settings may be missing."""
    unknown = dict.fromkeys(("order", "order_low", "order_high"), math.nan)
    return orders.assign(**unknown, outcome=NOT_RUN, reason=INTERRUPTED)


def reach_table(points: pd.DataFrame, times: Mapping[tuple[str, str, str], Array]) -> pd.DataFrame:
    """Cost to reach each target, on every scene, in attitude and in reactions."""
    rows = [
        row
        for scene in dict.fromkeys(points.scene)
        for quantity in ("attitude", "reaction")
        for measure in MEASURES
        for row in reach_rows(points, scene, quantity, measure, times)
    ]
    return TABLES["reach"].framed(rows)


def price_table(points: pd.DataFrame) -> pd.DataFrame:
    """Price of one more digit, on every scene."""
    rows = []
    for scene in dict.fromkeys(points.scene):
        for measure in MEASURES:
            for engine, curve in curves_of(points, scene, "attitude", measure, {}).items():
                price = price_of_a_digit(curve.error, curve.cost) or Interval(math.nan)
                named = {"scene": scene, "engine": engine, "quantity": "attitude", "measure": measure}
                rows.append(named | price.columns("factor"))
    return TABLES["price"].framed(rows)


def front_of(points: pd.DataFrame) -> Array:
    """Points that no other engine of the same kind beats in attitude error and time, (n,) bool."""
    error, cost = points.attitude_error_rad.to_numpy(float), points.seconds.to_numpy(float)
    good = (points.outcome == Outcome.PASS.value).to_numpy()
    told = np.maximum(error, TELLS * points.attitude_floor_rad.to_numpy(float))
    found = np.zeros(len(points), bool)
    for _, group in points.reset_index(drop=True).groupby(["scene", "kind"], sort=False):
        here = group.index[good[group.index]]
        found[here] = on_front(told[here], cost[here])
    return found


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
    """Rows of `reach` for one scene: every engine at every target; the fastest is that of an engine's own kind."""
    curves = curves_of(points, scene, quantity, measure, times)
    own = {str(e): rows for e, rows in points[points.scene == scene].groupby("engine", sort=False)}
    reasons = {e: stopped(rows) for e, rows in own.items()}
    shown = [e for e in own if e in curves or not (own[e].outcome == Outcome.PASS.value).any()]
    kinds = dict(zip(points.engine, points.kind, strict=True))
    least = TELLS * floor_of(points[points.scene == scene], quantity)
    rows: list[dict[str, Any]] = []
    for target in TARGETS:
        found = {e: (c, p) for e, c in curves.items() if (p := locate(c, target)) is not None}
        cost = {e: cost_at(*at) for e, at in found.items()}
        fastest = {kinds[e]: e for e in sorted(found, key=lambda e: cost[e], reverse=True)}
        for engine in shown:
            row: dict[str, Any] = {"scene": scene, "quantity": quantity, "measure": measure, "target": target}
            row |= {"engine": engine, "status": "no verdict" if target < least else "not reached", "reason": ""}
            row["reached_by"] = reached_by(own[engine], quantity, measure, target) if engine in found else ""
            if engine in found:
                row |= interval(cost[engine], parts(*found[engine])).columns("cost")
                row |= {
                    "status": "at most" if found[engine][1].at_most else "reached",
                    "fastest": fastest[kinds[engine]],
                }
                for name, other in (("fastest", row["fastest"]), ("baseline", BASELINE)):
                    if other in found:
                        made_of = [*parts(*found[engine]), *parts(*found[other], -1.0)]
                        ratio = (
                            interval(cost[engine] / cost[other], made_of)
                            if other != engine
                            else Interval(1.0, 1.0, 1.0)
                        )
                        row |= ratio.columns(f"over_{name}")
            elif row["status"] == "not reached":
                row["reason"] = reasons[engine]
            rows.append(row)
    return rows


def reached_by(rows: pd.DataFrame, quantity: str, measure: str, target: float) -> str:
    """Setting of the cheapest good run of an engine whose error is at most a target; empty without one."""
    good = rows[(rows.outcome == Outcome.PASS.value) & (rows[QUANTITIES[quantity][0]] <= target)]
    known = good[good[measure].notna()]
    return "" if known.empty else str(known.setting.iloc[int(np.argmin(known[measure].to_numpy(float)))])


def stopped(rows: pd.DataFrame) -> str:
    """Why an engine has no finer good point than its finest one; empty if it ran its whole sweep, coarse to fine."""
    good = (rows.outcome == Outcome.PASS.value).to_numpy(bool)
    later = rows.iloc[int(good.nonzero()[0].max()) + 1 :] if good.any() else rows
    if not len(later):
        return ""
    outcome = str(later.outcome.iloc[0])
    return "" if outcome == NotRun.BLURRED else outcome.replace("_", " ")


def floor_of(rows: pd.DataFrame, quantity: str) -> float:
    """Certified solution's own error of a quantity on a scene; 0 if unknown."""
    name = QUANTITIES[quantity][1]
    return float(rows[name].max()) if name in rows and rows[name].notna().any() else 0.0


def least_error(rows: pd.DataFrame, quantity: str) -> float:
    """Smallest error that an engine reaches in good runs; NaN if none."""
    name = QUANTITIES[quantity][0]
    good = rows[rows.outcome == Outcome.PASS.value]
    return float(good[name].min()) if name in good and good[name].notna().any() else math.nan
