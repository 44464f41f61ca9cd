"""What would let more of a run be judged: more samples, a finer setting or a shorter run, each with its figure.

The expected-error bound of the attitude, B(t), says how long two right runs stay together. A method's error of order p
falls as h^p, or as the request; round-off does not fall. Where errors grow by G in the predicted time H, a setting with
errors f times as small predicts H ln(f)/ln(G) longer. How far the next sample may be is measured: the reference
restarts from some states of the judging solution, at instants that lie close together.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import AccuracyParameter, EngineError, Setting
from adapters.reference.numpy_engines import Reference
from barchain.judge.checks.restart import restarted_between
from barchain.judge.error_model import ErrorModel
from barchain.judge.written import Undeclared
from barchain.solutions.reference import SOLUTION_RTOL
from reports.results.comparison import PARTED_RAD

if TYPE_CHECKING:
    from barchain.solutions.reference import ReferenceSolution

LEAST_RTOL = 1e-15
"""Smallest request that double precision may meet"""
MOST_FINER = 1e4
"""Largest ratio of steps that is worth a run"""
ROUND_OFF_SHARE = 0.5
"""Share of round-off in a bound beyond which no setting makes the bound smaller"""
SPARE = 1.5
"""Advised figure over the estimated one: growth differs between one state and the next"""
STATES = 7
"""States from which intervals are tried; the median counts, as most segments must predict a sample"""
PARTS = 32
"""Instants at which the bound in an interval is computed"""


def next_sample(errors: ErrorModel) -> str:
    """Reason why not even the first sample after the start can be predicted, with advice; empty where it can."""
    if len(errors.solution.amplification) <= 1 or np.count_nonzero(errors.t_s <= errors.limit_s) > 1:
        return ""
    return (
        f"the next sample is beyond the predictability limit at {errors.setting}: the expected-error bound of the "
        f"attitude reaches {PARTED_RAD:g} rad before t = {errors.t_s[1]:.4g} s{closer_or_finer(errors)}"
    )


def beyond_any_setting(solution: ReferenceSolution) -> str:
    """Reason why not even the reference's tightest setting predicts the first sample after the start; else empty."""
    tightest = Setting(AccuracyParameter.RTOL, SOLUTION_RTOL)
    return next_sample(ErrorModel(Reference.declarations(), tightest, solution, solution.trajectory))


def closer_or_finer(errors: ErrorModel, first: int = 0) -> str:
    """Advice where samples from one on are too far apart: how many samples, or which setting, would predict them."""
    if isinstance(errors.setting, Undeclared):
        return helped(finer(errors, float(errors.attitude_rad[1]) / PARTED_RAD))
    found = intervals(errors, first)
    if not found:
        return ""
    predicted_s, ratio = (float(np.median(each)) for each in zip(*found, strict=True))
    if first == 0:  # nothing is judged without the first interval
        predicted_s, ratio = min(predicted_s, found[0][0]), max(ratio, found[0][1])
    said = []
    if 0.0 < predicted_s < float(np.median(np.diff(errors.t_s))):
        said.append(f"at least {math.ceil(SPARE * float(errors.t_s[-1]) / predicted_s) + 1} samples")
    said += finer(errors, ratio) if 1.0 < ratio < math.inf else []
    return helped(said) or "; no setting predicts so far: samples have to lie closer together"


def intervals(errors: ErrorModel, first: int) -> list[tuple[float, float]]:
    """Predicted time (s), and bound over the distance of parted runs at the next sample, after samples from one on.

    The ratio is infinite where errors outgrow what a perturbed run measures, or are round-off.
    """
    found = []
    for k in np.unique(np.linspace(first, errors.n - 2, STATES).astype(int)):
        try:
            model = restarted_between(errors, int(k), PARTS)
        except (EngineError, ArithmeticError):
            continue
        measured = len(model.t_s) == PARTS + 1 and model.solution.limit_s >= model.t_s[-1]
        bound = np.maximum.accumulate(model.attitude_rad)
        if k == 0 and measured:  # the bound that judges counts the errors of the whole run's motion
            bound = bound * max(1.0, float(errors.attitude_rad[1] / bound[-1]))
        until_s = float(np.interp(math.log(PARTED_RAD), np.log(bound), model.t_s))
        helps = measured and model.floor_rad[-1] < ROUND_OFF_SHARE * PARTED_RAD
        ratio = float(bound[-1]) / PARTED_RAD if helps else math.inf
        found.append((min(until_s, model.solution.limit_s) - float(model.t_s[0]), ratio))
    return found


def after_restarts(errors: ErrorModel, limit_s: float) -> str:
    """Advice where the sample after a restart can't be predicted; up to `limit_s` the run can be judged."""
    shorter = [f"a run of at most {limit_s:.4g} s"] if limit_s > 0.0 else []
    first = int(np.count_nonzero(errors.t_s <= limit_s)) - 1
    more = closer_or_finer(errors, min(max(first, 0), errors.n - 2))
    if not shorter or "what would help" not in more:
        return helped(shorter) or more
    return helped([*shorter, more.partition(": ")[2]])


def until_share(errors: ErrorModel, limit_s: float, share: float, least: float) -> str:
    """Advice where a `share` of the run was judged up to `limit_s` and after restarts, and `least` is required."""
    found = []
    if share > 0.0:
        found.append(f"a run of at most {share / least * errors.t_s[-1]:.3g} s")
        growth = float(errors.amplification[errors.t_s <= limit_s].max())
        exponent = (least / share - 1.0) * math.log(max(growth, 1.0))
        bound = float(errors.attitude_rad[errors.t_s <= limit_s * least / share].max()) / PARTED_RAD
        if exponent < math.log(MOST_FINER) * (errors.engine.order or 1.0):
            found += finer(errors, max(math.exp(exponent), bound))
    return helped(found)


def finer(errors: ErrorModel, ratio: float) -> list[str]:
    """Setting whose errors are smaller by a ratio, with :data:`SPARE`; empty where there is none."""
    setting, order, ratio = errors.setting, errors.engine.order, SPARE * ratio
    steps = math.inf if order is None else ratio ** (1.0 / order)
    if isinstance(setting, Undeclared):
        if order is None:
            return [f"two files whose errors are {ratio:.2g} times as small"]
        return [f"two files of steps {steps:.2g} times as short"] if steps <= MOST_FINER else []
    if setting.parameter is AccuracyParameter.RTOL:
        rtol = setting.value / ratio
        return [f"rtol={rtol:.0e}"] if rtol >= LEAST_RTOL else []
    return [f"steps_per_orbit={setting.value * steps:.2g}"] if steps <= MOST_FINER else []


def helped(found: list[str]) -> str:
    """Ways in words; empty without one."""
    return f"; what would help: {', or '.join(found)}" if found else ""
