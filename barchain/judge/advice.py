"""What would let more of a run be judged: more samples, a finer setting or a shorter run, each with its figure.

The expected-error bound of the attitude, B(t), says how long two right runs stay together. A method's error of order p
falls as h^p, or as the request; round-off does not fall. Where errors grow by G in the predicted time H, a setting with
errors f times as small predicts H ln(f)/ln(G) longer.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from adapters.engine import AccuracyParameter
from reports.tables.crossval import PARTED_RAD

if TYPE_CHECKING:
    from barchain.judge.error_model import ErrorModel

LEAST_RTOL = 1e-15
"""Smallest request that double precision may meet"""
MOST_FINER = 1e4
"""Largest ratio of steps that is worth a run"""
MOST_EXPONENT, HALVINGS = 100.0, 40
ROUND_OFF_SHARE = 0.5
"""Share of round-off in a bound beyond which no setting makes the bound smaller"""


def until_next_sample(errors: ErrorModel) -> str:
    """Advice where the first sample after the start can't be predicted."""
    start, first = (float(v) for v in errors.attitude_rad[:2])
    duration_s, spacing_s = errors.scene.run.duration_s, float(errors.t_s[1] - errors.t_s[0])
    share = math.log(PARTED_RAD / start) / math.log(first / start) if 0.0 < start < PARTED_RAD < first else 0.0
    found = []
    if share > 0.0:
        found.append(f"at least {math.ceil(duration_s / (share * spacing_s)) + 1} samples")
    if first > PARTED_RAD and errors.floor_rad[1] < ROUND_OFF_SHARE * PARTED_RAD:
        found += finer(errors, first / PARTED_RAD)
    return helped(found) or "; no setting predicts so far: samples have to lie closer together"


def after_restarts(errors: ErrorModel, limit_s: float) -> str:
    """Advice where the sample after a restart can't be predicted: an error of the rates grows from one to the next.

    Over an interval t it turns a bar by t exp(t ln(G)/H) times itself, with the growth G up to the limit H.
    """
    run = errors.scene.run
    spacing_s = run.duration_s / (run.samples - 1)
    growth = max(float(errors.amplification[errors.t_s <= limit_s].max()), 1.0)
    pace = math.log(growth) / max(limit_s, spacing_s)
    found = [f"a run of at most {limit_s:.4g} s"] if limit_s > 0.0 else []
    wrong = float(errors.local.immediate["rate"].max()) if "rate" in errors.local.immediate else 0.0

    def turned_rad(interval_s: float) -> float:
        return wrong * interval_s * math.exp(min(pace * interval_s, MOST_EXPONENT))

    if turned_rad(spacing_s) > PARTED_RAD:
        shortest, longest = 0.0, spacing_s
        for _ in range(HALVINGS):
            middle = 0.5 * (shortest + longest)
            shortest, longest = (middle, longest) if turned_rad(middle) <= PARTED_RAD else (shortest, middle)
        found.append(f"at least {math.ceil(run.duration_s / longest) + 1} samples")
        found += finer(errors, turned_rad(spacing_s) / PARTED_RAD)
    return helped(found)


def until_share(errors: ErrorModel, limit_s: float, share: float, least: float) -> str:
    """Advice where a `share` of the run was judged up to `limit_s` and after restarts, and `least` is required."""
    found = []
    if share > 0.0:
        found.append(f"a run of at most {share / least * errors.scene.run.duration_s:.3g} s")
        growth = float(errors.amplification[errors.t_s <= limit_s].max())
        exponent = (least / share - 1.0) * math.log(max(growth, 1.0))
        if exponent < math.log(MOST_FINER) * (errors.engine.order or 1.0):
            found += finer(errors, math.exp(exponent))
    return helped(found)


def finer(errors: ErrorModel, ratio: float) -> list[str]:
    """Setting whose errors are smaller by a ratio; empty where there is none."""
    setting, order = errors.setting, errors.engine.order
    if setting.parameter is AccuracyParameter.RTOL:
        rtol = setting.value / ratio
        return [f"rtol={rtol:.0e}"] if rtol >= LEAST_RTOL else []
    if order is None or ratio ** (1.0 / order) > MOST_FINER:
        return []
    return [f"steps_per_orbit={setting.value * ratio ** (1.0 / order):.2g}"]


def helped(found: list[str]) -> str:
    """Ways in words; empty without one."""
    return f"; what would help: {', or '.join(found)}" if found else ""
