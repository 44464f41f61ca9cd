"""Fit of an unknown amount in the scene to a result: the secant method on the weighted residuals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.channels import channels_of
from barchain.judge.diagnosis.fit import QUANTITY_OF

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.trajectory import Array, Trajectory
    from barchain.judge.diagnosis.altered_scenes.amounts import Amount
    from barchain.judge.diagnosis.fit import GivenResult
    from barchain.judge.diagnosis.mistake import SceneMistake

ROUNDS = 8
"""Runs of a fit; a linear effect takes four"""
SLOPES = 1
"""Probes before the first slope: a delayed event jumps at once from one sample to another, and changes smoothly then"""
LEAST_FALL = 0.7
"""Ratio of residuals from one run to the next above which a fit ends"""
LEAST_WEIGHT = 1e-12
"""Least tolerance relative to a quantity's scale: the start has none"""


def fitted_amount(amount: Amount, result: GivenResult, run: Callable[[SceneMistake], Trajectory | None]) -> float:
    """Amount whose motion comes near to a result, by least squares.

    Parameters
    ----------
    amount : Amount
    result : GivenResult
        n samples.
    run : callable
        Run of a mistake in the scene, n samples.
    """
    at, seen, step = 0.0, residual(result, result.right), amount.probe
    for k in range(ROUNDS):
        motion = run(amount.mistake(at + step))
        if motion is None or len(motion.t_s) < result.n:
            break
        after = residual(result, motion)
        if k > SLOPES and not np.linalg.norm(after) < LEAST_FALL * np.linalg.norm(seen):
            break
        at, seen, slope = at + step, after, (after - seen) / step
        if k >= SLOPES:
            square = float(np.vdot(slope, slope))
            step = -float(np.vdot(after, slope)) / square if square > 0.0 else 0.0
        if step == 0.0 or not amount.range[0] <= at + step <= amount.range[1]:
            break
    return at


def residual(result: GivenResult, motion: Trajectory) -> Array:
    """Differences of a result and a motion over their tolerances, one row; without what is not compared."""
    given, supposed = channels_of(result.given), channels_of(motion)
    rows = []
    for field, values in given.items():
        quantity = QUANTITY_OF[field]
        if quantity not in result.quantities or field not in supposed:
            continue
        allowed = np.fmax(result.tolerance[quantity], LEAST_WEIGHT * result.scale[quantity])
        weight = np.where(np.isfinite(allowed), 1.0 / allowed, 0.0).reshape(-1, *[1] * (values.ndim - 1))
        rows.append(((values - supposed[field][: result.n]) * weight).ravel())
    return np.concatenate(rows)
