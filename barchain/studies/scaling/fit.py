"""Growth of each cost with N: expected costs of the next point, fitted exponents, targets of the compiled reference."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from barchain.studies.defaults import FAST
from barchain.studies.timing.orders import FEWEST, slope
from barchain.studies.timing.statistics import Interval
from reports.tables.scaling import FITTED

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.trajectory import Array
    from reports.tables.rows import Rows

SHARES = (1.0, 0.5, 0.2, 0.1, 0.05)  # of an orbit; the last is two steps between samples for the fewest steps taken
LAST = 3  # points that tell how costs grow
FEW_EXPONENT, MOST_GROWTH = 2.0, 3.0  # beyond which growth is not believed, of fewer points and of all of them
LEAST_BARS = 20  # fewer have more of a call's own price in them than of the bars'
FAST_BARS = (100, 100_000)  # where the compiled reference's evaluation is fitted
LEAST_MEMORY_B = 2.0**20  # what allocators keep in store hides less
FIT_COLUMNS = ("engine", "quantity", "per", "exponent", "low", "high", *FITTED)
QUANTITIES = {
    "evaluation": "evaluation_s",
    "orbit": "orbit_s",
    "memory": "memory_B",
    "evaluations per orbit": "evaluations",
    "steps per orbit": "steps",
}
LONG = (500, 100_000)  # bars
MOST_EXPONENT, MOST_SHORT_S, MOST_PER_BAR_S = 1.05, 1e-6, 50e-9


def predicted(bars: Sequence[int], cost: Sequence[float], wanted: int) -> float:
    """Cost at `wanted` bars by the last points' own exponent; 0 where nothing is known.

    Points come in order of rising N; costs that are not positive numbers are none.
    """
    known = [(n, c) for n, c in zip(bars, cost, strict=True) if math.isfinite(c) and c > 0.0][-LAST:]
    if not known:
        return 0.0
    n, c = known[-1]
    exponent = FEW_EXPONENT
    if len(known) > 1:
        x, y = np.log([k[0] for k in known]), np.log([k[1] for k in known])
        exponent = float(np.clip(np.polyfit(x, y, 1)[0], 0.0, MOST_GROWTH if len(known) == LAST else FEW_EXPONENT))
    return float(c * (wanted / n) ** exponent)


def affordable(orbit_s: float, limit_s: float) -> float:
    """Largest share of an orbit that keeps to the limit; 0 if even the smallest does not."""
    return next((share for share in SHARES if share * orbit_s <= limit_s), 0.0)


def fit_range(engine: str, quantity: str) -> tuple[float, float]:
    """Least and largest N of a fit."""
    fast = engine == FAST and quantity == "evaluation"
    return (float(FAST_BARS[0]), float(FAST_BARS[1])) if fast else (float(LEAST_BARS), math.inf)


def exponent(bars: Array, cost: Array) -> Interval | None:
    """Exponent p of ``cost = C N^p`` by least squares in both logarithms, with Student's interval.

    None of fewer than :data:`FEWEST` points: two always lie on a line.
    """
    good = np.isfinite(cost) & (cost > 0.0)
    if good.sum() < FEWEST:
        return None
    if np.ptp(cost[good]) == 0.0:
        return Interval(0.0, 0.0, 0.0)
    return slope(np.log(bars[good]), np.log(cost[good]))


def fit_row(rows: pd.DataFrame, quantity: str) -> dict[str, Any] | None:
    """One engine's exponent of one quantity; None if there are too few points."""
    engine, (least, most) = str(rows.engine.iloc[0]), fit_range(str(rows.engine.iloc[0]), quantity)
    floor = LEAST_MEMORY_B if quantity == "memory" else 0.0
    bars, cost = rows.bars.to_numpy(float), rows[QUANTITIES[quantity]].to_numpy(float)
    used = (bars >= least) & (bars <= most) & (cost > floor)
    found = exponent(bars[used], cost[used])
    if found is None:
        return None
    per = rows.per[used].iloc[-1] if quantity == "evaluation" else ""
    ends = bars[used].min(), bars[used].max()
    row = (engine, quantity, per, found.value, found.low, found.high, int(used.sum()), *ends)
    return dict(zip(FIT_COLUMNS, row, strict=True))


def fits_table(points: pd.DataFrame) -> pd.DataFrame:
    """All exponents."""
    found = [fit_row(own, q) for _, own in points.groupby("engine", sort=False) for q in QUANTITIES]
    return pd.DataFrame([r for r in found if r], columns=list(FIT_COLUMNS))


def add_fits(summary: Rows, fits: pd.DataFrame, scene: str) -> None:
    """Add the rows of all exponents, each with its range."""
    for fit in fits.to_dict("records"):
        where = {"scene": scene, "engine": fit["engine"], "quantity": fit["quantity"]}
        summary.add("exponent", fit["exponent"], low=fit["low"], high=fit["high"], text=fit["per"], **where)
        for name in FITTED:
            summary.add(name, fit[name], **where)


def targets(points: pd.DataFrame, fits: pd.DataFrame) -> list[dict[str, Any]]:
    """Targets of the compiled reference's evaluation and the measured values; empty if it was not measured."""
    own = points[points.engine == FAST].set_index("bars").evaluation_s
    found = [target("one evaluation of 5 bars", own.get(5, math.nan), MOST_SHORT_S, "s")]
    found += [target(f"one evaluation of {n} bars, a bar", own.get(n, math.nan) / n, MOST_PER_BAR_S, "s") for n in LONG]
    fit = fits[(fits.engine == FAST) & (fits.quantity == "evaluation")]
    whole = fit[(fit.bars_from == FAST_BARS[0]) & (fit.bars_to == FAST_BARS[1])]
    value = float(whole.exponent.iloc[0]) if len(whole) else math.nan
    found.append(
        target(f"exponent of one evaluation between {FAST_BARS[0]} and {FAST_BARS[1]} bars", value, MOST_EXPONENT, "")
    )
    return [t for t in found if math.isfinite(t["measured"])]


def target(what: str, measured: float, most: float, unit: str) -> dict[str, Any]:
    """One of them."""
    return {"what": what, "measured": float(measured), "most": most, "unit": unit, "met": bool(measured <= most)}
