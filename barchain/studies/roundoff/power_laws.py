"""Power laws of errors: expected and measured exponents, and the size at which the last digit is lost."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from barchain.studies.roundoff.engines import INERTIAL
from barchain.studies.roundoff.evaluation import BOTH, FORMULA, INPUT, REACTION
from barchain.studies.roundoff.formulations import LONGEST_STEP, StateKind
from barchain.studies.roundoff.third_parties import FALLS, THIRD_PARTIES
from barchain.studies.roundoff.trajectories import GROWS_FROM
from barchain.studies.timing.statistics import FEWEST, LEAST_SLOPE, SCATTERED, STRAIGHT, slope, straight_run
from reference_impl.precision.arithmetic import ARITHMETICS
from reports.results.roundoff import RUN, TABLES

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.trajectory import Array
    from reference_impl.precision.arithmetic import Values

LOST = 0.1  # an error from here on leaves no digit; u/ratio from here on does not tell a bar's ends apart
POSITIONS = "absolute positions"
STEPPED = LONGEST_STEP**4 / 12.0  # u/ratio up to which differences of positions have their best step
FLOORS = 10.0  # times what the relative formulation leaves in the same state: an error that falls with the size is
# followed down to there, where a tenth of it is the joint system's and not the coordinates'
SMALL_ERROR = 1e-2  # of an error that grows with time: beyond, it is no longer proportional to anything


def expected_exponent(state: str, formulation: str, yardstick: str, source: str = BOTH) -> float:
    """Exponent of the size ratio that an error should have.

    Counted from the body's centre, a place is known to u r, gravity's differences over a bar, n² l, to n² u r: 1/ratio
    of them. Counted from the centre of mass, everything is known to u of itself. Reactions of a horizontal chain are
    m n² l times the ratio squared, and against them either error is larger by that. Third parties' frames have
    exponents of their own, :mod:`barchain.studies.roundoff.third_parties`.
    """
    base = own_exponent(formulation, source)
    return base - 2.0 if state == StateKind.HORIZONTAL.value and yardstick == REACTION else base


def own_exponent(formulation: str, source: str) -> float:
    """Exponent in an ordinary state."""
    if formulation in THIRD_PARTIES:
        return 0.0 if source == INPUT else FALLS[THIRD_PARTIES[formulation].frame]
    if formulation == POSITIONS and source != FORMULA:
        return -0.5  # noise u r/(n h)² and truncation l (n h)²/12 at their best: the root of u/(3 ratio)
    return -1.0 if formulation.startswith("absolute") else 0.0


def line(x: Array, y: Array) -> dict[str, float]:
    """Exponent of y in x with its interval, or none of too few points."""
    found: dict[str, float] = {"points": len(x)}
    if len(x) < FEWEST:
        return found | dict.fromkeys(("exponent", "low", "high"), math.nan)
    fit = slope(np.log(x), np.log(y))
    return found | {"exponent": fit.value, "low": fit.low, "high": fit.high, "first": x.min(), "last": x.max()}


def grouped(table: pd.DataFrame, by: list[str], row: Callable[[dict[str, Any], pd.DataFrame], dict[str, Any]],
            name: str) -> pd.DataFrame:  # fmt: skip
    """Table of a name with one row for each group of another one."""
    found = [row(dict(zip(by, key, strict=True)), own) for key, own in table.groupby(by, sort=False, dropna=False)]
    return TABLES[name].framed(found)


def evaluation_laws(evaluation: pd.DataFrame) -> pd.DataFrame:
    """Laws of one evaluation's errors in the size ratio."""
    by = ["state", "bars", "formulation", "arithmetic", "source", "yardstick"]
    lost = evaluation.groupby([b for b in by if b != "arithmetic"])["median"].transform("max") >= LOST
    return grouped(with_floors(evaluation.assign(lost=lost)), by, evaluation_law, "laws")


def with_floors(evaluation: pd.DataFrame) -> pd.DataFrame:
    """The table with a column ``floor``: the error of the relative formulation in the same state, or u."""
    by = ["state", "bars", "ratio", "arithmetic", "yardstick"]
    own = evaluation[(evaluation.formulation == "relative") & (evaluation.source == FORMULA)]
    joined = evaluation.merge(own[[*by, "median"]].rename(columns={"median": "floor"}), on=by, how="left")
    units = joined.arithmetic.map({name: a.unit_roundoff for name, a in ARITHMETICS.items()})
    return joined.assign(floor=joined.floor.fillna(units).clip(lower=units))


def evaluation_law(key: dict[str, Any], own: pd.DataFrame) -> dict[str, Any]:
    """Law of one formulation in one arithmetic and state."""
    expected = expected_exponent(key["state"], key["formulation"], key["yardstick"], key["source"])
    u = ARITHMETICS[key["arithmetic"]].unit_roundoff
    ratio, error = own.ratio.to_numpy(float), own["median"].to_numpy(float)
    falls = own_exponent(key["formulation"], key["source"]) < 0.0
    floor = FLOORS * own.floor.to_numpy(float) if falls else np.zeros(len(own))
    used = (error < LOST) & (error > floor)
    if falls:
        used &= u / ratio < (STEPPED if key["formulation"] == POSITIONS else LOST)
    found = line(ratio[used], error[used]) | {"expected": expected}
    constant = float(np.exp(np.mean(np.log(error[used] / (u * ratio[used] ** expected))))) if used.any() else math.nan
    last = (LOST / (constant * u)) ** (1.0 / expected) if expected and math.isfinite(constant) else math.nan
    if not own.lost.all() or (error[ratio < last] < LOST).any():
        last = math.nan  # what is left of reactions when gravity's share is lost keeps digits at any size
    return {**key, **found, "constant": constant, "last_digit_ratio": last, "remark": remark(error, used, floor)}


def remark(error: Array, used: Values, floor: Array) -> str:
    """Why there is no line, where there is none."""
    if used.sum() >= FEWEST:
        return ""
    if (error >= LOST).mean() > 0.5:
        return "no digit left at most sizes"
    if (error <= floor).mean() > 0.5:
        return "at the arithmetic's own floor at most sizes"
    return "too few sizes between the floor and total loss"


def best_table(trajectories: pd.DataFrame) -> pd.DataFrame:
    """Least median error of each way to run, over its steps or tolerances.

    ``settled`` says that it is not at the finest setting: from there on round-off rules.
    """
    good = trajectories[np.isfinite(trajectories["median"].astype(float))]
    best = good.loc[good.groupby(list(RUN), sort=False)["median"].idxmin()]
    ends = trajectories.groupby(["coordinates", "arithmetic", "method"]).agg(
        most=("steps_per_orbit", "max"), least=("rtol", "min")
    )
    joined = best.merge(ends, left_on=["coordinates", "arithmetic", "method"], right_index=True)
    finest = (joined.steps_per_orbit >= joined.most) | (joined.rtol <= joined.least)
    return joined.assign(settled=~finest)


def best_laws(best: pd.DataFrame) -> pd.DataFrame:
    """Laws of the least errors in the size ratio."""
    return grouped(best, ["quantity", "coordinates", "arithmetic", "method"], best_law, "best_laws")


def best_law(key: dict[str, Any], own: pd.DataFrame) -> dict[str, Any]:
    """Law of one way to run; the centre of mass is judged over a bar, so that its own round-off grows as 1/ratio."""
    lost = key["coordinates"] == "absolute" or key["quantity"] == "com"
    expected = -1.0 if lost else 0.0
    u = ARITHMETICS[key["arithmetic"]].unit_roundoff
    ratio, error = own.ratio.to_numpy(float), own["median"].to_numpy(float)
    used = (error < LOST) & (error > 0.0) & (own.known.astype(bool) & own.settled).to_numpy()
    constant = float(np.exp(np.mean(np.log(error[used] / (u * ratio[used] ** expected))))) if used.any() else math.nan
    words = remark(error, used, np.zeros(len(error)))
    if words and not own.settled.any():
        words = "truncation still rules at the finest setting"
    return {**key, **line(ratio[used], error[used]), "expected": expected, "constant": constant, "remark": words}


def growth_laws(growth: pd.DataFrame) -> pd.DataFrame:
    """Exponents of errors in time."""
    return grouped(growth, list(RUN), growth_law, "growth_laws")


def growth_law(key: dict[str, Any], own: pd.DataFrame) -> dict[str, Any]:
    """Exponent of one way to run.

    Roundings that know nothing of each other change rates as a random walk does, by the square root of time, and what
    the rates move by its 3/2nd power; what is closed by construction does not grow.
    """
    closed = key["coordinates"] == "minimal" and key["quantity"] == "gap"
    time, error = own.orbits.to_numpy(float), own["median"].to_numpy(float)
    used = (time >= GROWS_FROM) & (error > 0.0) & (error < SMALL_ERROR) & own.known.astype(bool).to_numpy()
    words = "" if used.sum() >= FEWEST else "errors too large, or too small for the high-precision solution to tell"
    found = {**key, **line(time[used], error[used]), "expected": 0.0 if closed else 1.5, "remark": words}
    if "exponent_low" in own and used.sum() >= FEWEST:
        found |= {"low": float(own.exponent_low.iloc[0]), "high": float(own.exponent_high.iloc[0])}
    return found


ATTITUDE = "attitude"
STEPS, STEPS_TRUNCATION, TOLERANCE, RATIO = "steps", "steps, truncation", "rtol", "ratio"
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
    return fit | {"remark": engine_remark(fit, ROUND_OFF, too_few(steps, error))}


def truncation_law(key: Key, own: pd.DataFrame) -> dict[str, Any]:
    """Fit where finer steps help."""
    steps, error = curve(own, "steps_per_orbit")
    chosen = straight_run(np.log(steps), np.log(error), STRAIGHT, lambda slope: slope <= -LEAST_SLOPE)
    expected = -ORDERS.get(key["engine"], math.nan)
    fit = key | line(steps[chosen], error[chosen]) | {"against": STEPS_TRUNCATION, "expected": expected}
    return fit | {"remark": engine_remark(fit, TRUNCATION, "")}


def tolerance_law(key: Key, own: pd.DataFrame) -> dict[str, Any]:
    """So short a run takes few steps, whatever is asked of each: none of its errors is truncation."""
    rtol, error = curve(own, "rtol")
    fit = key | line(rtol, error) | {"against": TOLERANCE, "expected": 0.0}
    return fit | {"remark": engine_remark(fit, ROUND_OFF, "too few tolerances")}


def size_law(key: Key, own: pd.DataFrame) -> dict[str, Any]:
    """At the finest setting; in the inertial frame only where round-off rules that, which alone knows of sizes."""
    inertial, parts = key["frame"] == INERTIAL, [part for _, part in own.groupby("ratio")]
    ruled = [part for part in parts if not inertial or rounded(part)]
    ratio = np.array([part.ratio.iloc[0] for part in ruled])
    error = np.array([finest(part) for part in ruled])
    fit = key | line(ratio, error) | {"against": RATIO, "ratio": math.nan, "expected": -1.0 if inertial else 0.0}
    none = "too few sizes" if len(parts) < FEWEST else "truncation still rules the finest step at most sizes"
    return fit | {"remark": engine_remark(fit, RATIO, none)}


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


def engine_remark(fit: dict[str, Any], what: str, none: str) -> str:
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
