"""Tables drawn from the points: orders of convergence, cost to reach an error, price of a digit, Pareto front."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from adapters.engine import AccuracyParameter
from barchain.runs.declared import engine_class
from barchain.runs.timing.orders import SCATTERED, STRAIGHT, OrderFit, fit_order, price_of_a_digit
from barchain.runs.timing.statistics import Interval, on_front
from barchain.studies.cost.points import TELLS
from barchain.studies.cost.reach import MEASURES, QUANTITIES, curves_of, least_error, reach_rows
from reports.tables.cost import OWN_EQUATIONS
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Mapping

    from adapters.registry import Registration
    from adapters.trajectory import Array

ORDER_COLUMNS = (
    "scene", "engine", "kind", "quantity", "against", "order", "order_low", "order_high", "theory", "points",
    "error_from", "error_to", "least_error",
)  # fmt: skip
REACH_COLUMNS = (
    "scene", "quantity", "measure", "target", "engine", "kind", "status", "reason", "cost", "cost_low", "cost_high",
    "over_fastest", "over_fastest_low", "over_fastest_high",
    "over_baseline", "over_baseline_low", "over_baseline_high", "fastest",
)  # fmt: skip
PRICE_COLUMNS = ("scene", "engine", "kind", "quantity", "measure", "factor", "factor_low", "factor_high")


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
    found = {"scene": first.scene, "engine": first.engine, "kind": first.kind, "quantity": quantity, "against": against}
    return found | fit_columns(fit) | {"theory": theory, "least_error": least_error(rows, quantity)}


def fit_columns(fit: OrderFit | None) -> dict[str, Any]:
    """Columns of a fitted order; none of them without one."""
    if fit is None:
        return {}
    return {
        "order": fit.order.value,
        "order_low": fit.order.low,
        "order_high": fit.order.high,
        "points": fit.points,
        "error_from": fit.error_range[0],
        "error_to": fit.error_range[1],
    }


def equal_steps_row(scene: str, step_s: Array, error: Array, theory: float) -> dict[str, Any]:
    """Order of the reference's method at equal steps."""
    found = {"scene": scene, "engine": "reference", "kind": OWN_EQUATIONS, "quantity": "attitude"}
    found["against"] = "equal steps"
    return found | fit_columns(fit_order(step_s, error)) | {"theory": theory, "least_error": math.nan}


def orders_table(
    points: pd.DataFrame, engines: Mapping[str, Registration], extra: list[dict[str, Any]]
) -> pd.DataFrame:
    """All orders; `extra` are rows measured apart."""
    rows = []
    for (_, engine), own in points.groupby(["scene", "engine"], sort=False):
        theory = engine_class(engines[str(engine)]).order
        shown = [q for q, (error, _) in QUANTITIES.items() if error in own and own[error].notna().any()]
        wanted = shown if shown == ["com"] else [q for q in shown if q != "com"]
        rows += [order_row(own, quantity, theory) for quantity in wanted]
    return pd.DataFrame(rows + extra, columns=list(ORDER_COLUMNS))


def reach_table(points: pd.DataFrame, times: Mapping[tuple[str, str, str], Array]) -> pd.DataFrame:
    """Cost to reach each target, on every scene, in attitude and in reactions."""
    rows = [
        row
        for scene in dict.fromkeys(points.scene)
        for quantity in ("attitude", "reaction")
        for measure in MEASURES
        for row in reach_rows(points, scene, quantity, measure, times)
    ]
    return pd.DataFrame(rows, columns=list(REACH_COLUMNS))


def price_table(points: pd.DataFrame) -> pd.DataFrame:
    """Price of one more digit, on every scene."""
    rows, kinds = [], dict(zip(points.engine, points.kind, strict=True))
    for scene in dict.fromkeys(points.scene):
        for measure in MEASURES:
            for engine, curve in curves_of(points, scene, "attitude", measure, {}).items():
                price = price_of_a_digit(curve.error, curve.cost) or Interval(math.nan)
                row = (scene, engine, kinds[engine], "attitude", measure, price.value, price.low, price.high)
                rows.append(dict(zip(PRICE_COLUMNS, row, strict=True)))
    return pd.DataFrame(rows, columns=list(PRICE_COLUMNS))


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
