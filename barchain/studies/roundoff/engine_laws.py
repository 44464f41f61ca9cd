"""Power laws of other engines' errors: against the number of steps, the tolerance, and the size ratio.

What is expected follows from what an engine rounds. With a place rounded by u p (p = r in the inertial frame, a few bar
lengths in a moving one), n the orbital rate and h the step,

* where joints hold places (Exudyn's index 3), and where impulses close in one step the gap that they find (pymunk),
  accelerations are off by u p/h², reactions, over m n² l, by u (p/l)/(n h)²: they grow as the square of the number of
  steps;
* where joints hold velocities (Exudyn's index 2), Exudyn differences the derivative that this takes, by a step of its
  own: reactions have a floor that no step changes; below it lies what velocities are rounded by, over one step,
  u (p/l)/(n h), which grows as the number of steps, and by another root of it, as the trapezoidal rule damps nothing;
* where reactions follow from the state in one evaluation (the reference, trees of joints), steps do not matter;
* angles add up a rounding a step; if these know nothing of each other their sum grows as the square root of the number
  of steps, and so do the reactions of what adds up nothing else (MuJoCo);
* above round-off, errors fall by the order of the method.

In all of them p/l is 1/ratio in the inertial frame, and no matter of size in a moving one.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from barchain.studies.roundoff.engines import INERTIAL
from barchain.studies.roundoff.laws import grouped, line
from barchain.studies.timing.orders import FEWEST, LEAST_SLOPE, SCATTERED, STRAIGHT, straight_run
from reports.tables.roundoff import TABLES

if TYPE_CHECKING:
    from adapters.trajectory import Array

REACTION, ATTITUDE = "reaction", "attitude"
STEPS, TOLERANCE, RATIO = "steps", "rtol", "ratio"
ROUND_OFF, TRUNCATION = "round-off", "truncation"
ORDERS = {"exudyn": 2.0, "exudyn-index3": 2.0, "pymunk": 2.0, "mujoco": 4.0}
REACTIONS = {"exudyn": 0.0, "exudyn-index3": 2.0, "pymunk": 2.0}
"""Exponents of reactions' round-off in the number of steps; others' is that of the attitude"""
ADDED_UP = 0.5  # exponent of what chance adds up
SLACK = 0.05  # of an exponent: fits over a few points of scattered medians tell no less
TELLS = 0.5  # half width of an interval beyond which it agrees with too much
TOO_WIDE = "the interval is too wide to tell"
UNEXPLAINED = "not as expected, and not explained"
NEAR = "the first round-off is in it"
AGAIN = "roundings of successive steps seem to depend on each other"
FIRST = "one rounding of the start is as large as what the steps add up"
WHY = {
    ("exudyn", REACTION, ROUND_OFF): "velocities' rounding over one step, which nothing damps, rises out of the floor",
    ("exudyn", REACTION, RATIO): "the floor of a differenced derivative follows another law of the size",
    ("exudyn-index3", REACTION, TRUNCATION): "the rest of the start's transient, and the first round-off, are in it",
    ("exudyn-index3", ATTITUDE, ROUND_OFF): AGAIN,
    ("exudyn", ATTITUDE, ROUND_OFF): AGAIN,
    ("pymunk", ATTITUDE, ROUND_OFF): AGAIN,
    ("mujoco", ATTITUDE, ROUND_OFF): FIRST,
    ("mujoco", REACTION, ROUND_OFF): FIRST,
}
BY = ["engine", "frame", "quantity"]
Key = dict[str, Any]


def engine_laws(engines: pd.DataFrame) -> pd.DataFrame:
    """Laws of the medians in the table `engines`.

    Against steps there is a row of round-off for each size, with a remark where there is no line, and one of truncation
    where that is seen; exponents are of the number of steps, so that what is worse for finer ones has them positive.
    """
    own = usable(engines)
    stepped, chosen = own[own.steps_per_orbit.notna()], own[own.rtol.notna()]
    seen = grouped(stepped, [*BY, "ratio"], truncation_law, "engine_laws")
    parts = [
        grouped(stepped, [*BY, "ratio"], round_off_law, "engine_laws"),
        seen[seen.exponent.notna()],
        grouped(chosen, [*BY, "ratio"], tolerance_law, "engine_laws"),
        grouped(own, BY, size_law, "engine_laws"),
    ]
    found = pd.concat([p for p in parts if len(p)] or parts[:1], ignore_index=True)
    return found.sort_values(["engine", "frame"], kind="stable", ignore_index=True)


def usable(engines: pd.DataFrame) -> pd.DataFrame:
    """Rows whose median is resolved by the high-precision solution."""
    engines = TABLES["engines"].framed(engines)
    median = engines["median"].astype(float)
    kept = np.isfinite(median) & (median > 0.0) & engines.known.astype(bool)
    return engines[kept & engines.quantity.isin((REACTION, ATTITUDE))]


def round_off_law(key: Key, own: pd.DataFrame) -> dict[str, Any]:
    """Fit where finer steps do not help."""
    steps, error = curve(own, "steps_per_orbit")
    chosen = straight_run(np.log(steps), np.log(error), SCATTERED, lambda slope: slope > -LEAST_SLOPE)
    expected = REACTIONS.get(key["engine"], ADDED_UP) if key["quantity"] == REACTION else ADDED_UP
    fit = key | line(steps[chosen], error[chosen]) | {"against": STEPS, "expected": expected}
    return fit | {"remark": remark(fit, ROUND_OFF, too_few(steps, error))}


def truncation_law(key: Key, own: pd.DataFrame) -> dict[str, Any]:
    """Fit where finer steps help."""
    steps, error = curve(own, "steps_per_orbit")
    chosen = straight_run(np.log(steps), np.log(error), STRAIGHT, lambda slope: slope <= -LEAST_SLOPE)
    expected = -ORDERS.get(key["engine"], math.nan)
    fit = key | line(steps[chosen], error[chosen]) | {"against": STEPS, "expected": expected}
    return fit | {"remark": remark(fit, TRUNCATION, "")}


def tolerance_law(key: Key, own: pd.DataFrame) -> dict[str, Any]:
    """So short a run takes few steps, whatever is asked of each: none of its errors is truncation."""
    rtol, error = curve(own, "rtol")
    fit = key | line(rtol, error) | {"against": TOLERANCE, "expected": 0.0}
    return fit | {"remark": remark(fit, ROUND_OFF, "too few tolerances")}


def size_law(key: Key, own: pd.DataFrame) -> dict[str, Any]:
    """At the finest setting; in the inertial frame only where round-off rules that, which alone knows of sizes."""
    inertial, parts = key["frame"] == INERTIAL, [part for _, part in own.groupby("ratio")]
    ruled = [part for part in parts if not inertial or rounded(part)]
    ratio = np.array([part.ratio.iloc[0] for part in ruled])
    error = np.array([finest(part) for part in ruled])
    fit = key | line(ratio, error) | {"against": RATIO, "ratio": math.nan, "expected": -1.0 if inertial else 0.0}
    none = "too few sizes" if len(parts) < FEWEST else "truncation still rules the finest step at most sizes"
    return fit | {"remark": remark(fit, RATIO, none)}


def finest(own: pd.DataFrame) -> float:
    """Error at the finest setting."""
    return float(own.sort_values(["steps_per_orbit", "rtol"], ascending=[False, True])["median"].iloc[0])


def rounded(own: pd.DataFrame) -> bool:
    """Whether the last refinement did not help."""
    if own.steps_per_orbit.isna().all() or len(own) < 2:
        return True
    steps, error = curve(own, "steps_per_orbit")
    return bool(np.diff(np.log(error))[-1] > -LEAST_SLOPE * np.diff(np.log(steps))[-1])


def curve(own: pd.DataFrame, column: str) -> tuple[Array, Array]:
    """Settings in rising order, and the errors there."""
    line_of = own.sort_values(column)
    return line_of[column].to_numpy(float), line_of["median"].to_numpy(float)


def too_few(steps: Array, error: Array) -> str:
    """Why there is no line of round-off."""
    slopes = np.diff(np.log(error)) / np.diff(np.log(steps))
    if not len(slopes) or slopes[-1] <= -LEAST_SLOPE:
        return "truncation still rules at the finest step"
    return "round-off rules at too few steps, or along no straight line"


def remark(fit: dict[str, Any], what: str, none: str) -> str:
    """Remark on a fit: the dominant error, and why the exponent differs or no line was fitted."""
    if not math.isfinite(fit["exponent"]):
        return none
    words = "" if what == RATIO else what
    if fit["high"] - fit["low"] > 2.0 * TELLS:
        return f"{words}; {TOO_WIDE}" if words else TOO_WIDE
    if not (fit["low"] - SLACK > fit["expected"] or fit["high"] + SLACK < fit["expected"]):
        return words
    other = NEAR if what == TRUNCATION and fit["exponent"] > fit["expected"] else UNEXPLAINED
    why = WHY.get((fit["engine"], fit["quantity"], what), other)
    return f"{words}; {why}" if words else why
