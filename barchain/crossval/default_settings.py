"""Settings of a comparison: the cheapest at which an engine of equal steps still shows something at a scene's scale."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import AccuracyParameter, Setting
from barchain.judge.error_model import ErrorModel

if TYPE_CHECKING:
    from collections.abc import Iterator

    from adapters.engine import Engine
    from barchain.solutions.reference import ReferenceSolution

WANTED_SHARE = 1e-3
"""Largest expected-error bound over the first orbit, relative to each quantity's scale"""
KEPT_LIMIT = 0.75
"""Least predictability limit of a chaotic scene, relative to that at the engine's default setting"""
STEPS_PER_TURN = 40
"""Least steps in the fastest turn of a bar: bounds hold to the predictability limit, and some chains tumble after it"""
QUANTITIES = ("attitude", "rate", "reaction")
PER_OCTAVE = 2
"""Settings tried for each factor of two in the steps"""


def comparison_setting(engine: type[Engine], solution: ReferenceSolution | None) -> Setting:
    """Setting at which an engine of barchain's own registry is compared on a scene, if none is given.

    Methods that choose their steps, and scenes whose solution is not known before the runs, have the engine's default
    setting. Otherwise it is the coarsest setting of an engine of equal steps whose expected-error bound stays below
    :data:`WANTED_SHARE`. Where not even the default setting promises so much in a chaotic scene, it is the coarsest
    that keeps :data:`KEPT_LIMIT` of the predictability limit: each halving of the step of a second-order method buys
    an eighth of an orbit more. The fastest turn of the whole run takes at least :data:`STEPS_PER_TURN` steps.
    """
    default = engine.sweep.setting()
    if default.parameter is not AccuracyParameter.STEPS_PER_ORBIT or solution is None:
        return default
    own = promise(engine, default, solution)
    if expected_share(own) > WANTED_SHARE:
        least_s = KEPT_LIMIT * own.limit_s
        if own.limit_s >= own.t_s[-1]:
            return default
        shows = (s for s in coarse_first(engine, default) if promise(engine, s, solution).limit_s >= least_s)
    else:
        shows = (
            s for s in coarse_first(engine, default) if expected_share(promise(engine, s, solution)) <= WANTED_SHARE
        )
    least = STEPS_PER_TURN * turns_per_orbit(solution)
    return next((s for s in shows if s.value >= least), default)


def turns_per_orbit(solution: ReferenceSolution) -> float:
    """Turns of the fastest bar in the orbit to which steps are counted."""
    rates = solution.trajectory.rate_rad_s
    if rates is None:
        return 0.0
    return float(np.max(np.abs(rates))) * solution.scene.step_period_s / (2.0 * math.pi)


def coarse_first(engine: type[Engine], default: Setting) -> Iterator[Setting]:
    """Settings from the coarsest of an engine's accuracy sweep to just below its default."""
    octaves = math.log2(default.value / min(engine.sweep.values))
    for k in range(math.floor(PER_OCTAVE * octaves), 0, -1):
        yield Setting(default.parameter, two_digits(default.value * 2.0 ** (-k / PER_OCTAVE)))


def two_digits(value: float) -> float:
    """Value rounded up to two digits."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return math.ceil(value / unit - 1e-9) * unit


def promise(engine: type[Engine], setting: Setting, solution: ReferenceSolution) -> ErrorModel:
    """Error model of an engine at a setting, before it runs."""
    return ErrorModel(engine, setting, solution, solution.trajectory)


def expected_share(errors: ErrorModel) -> float:
    """Largest expected-error bound over the first orbit, relative to the quantity's scale."""
    last = int(np.count_nonzero(errors.t_s <= errors.scene.step_period_s)) - 1
    shares = [float(errors.bound[q][last]) / errors.scale[q] for q in QUANTITIES if q in errors.bound]
    return max(shares, default=math.inf)
