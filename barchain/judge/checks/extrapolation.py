"""Errors that do not fall as a method's order says: wrong physics, noise and coarse interpolation below its own error.

Of a method of order p, the error at half the step is smaller by 2^p, to leading order. Two runs then give a better
result than either, Richardson's extrapolation, and what that is still off by is not the method's error: a term that is
the same at both settings, or noise. So errors are seen that are far smaller than those of the method itself.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory

SHARE = 0.1
"""Of the change between two settings: what terms of higher order may leave of it. On random scenes less than 0.05 was
left by every sound engine in a moving frame."""
STAYS = 0.5  # of what was left one setting before: the next term falls four times or more, at order 2 sixteen times
FIELDS = {"com": "com_m", "attitude": "angle_rad", "rate": "rate_rad_s", "reaction": "reaction_N"}


def left_over(
    quantity: str, coarse: Trajectory, fine: Trajectory, right: Trajectory, order: float
) -> tuple[Array, Array]:
    """What the extrapolation of two runs is off by, and how much they differ, each (n,), the largest component.

    Parameters
    ----------
    quantity : str
        One of :data:`FIELDS`.
    coarse, fine : Trajectory
        Runs at some step and at half of it.
    right : Trajectory
        The reference solution.
    order : float
        Of the method.
    """
    arrays = [getattr(run, FIELDS[quantity]) for run in (coarse, fine, right)]
    n = min(len(values) for values in arrays)
    one, two, solution = (values[:n].reshape(n, -1) for values in arrays)
    change = one - two
    left = two - change / (2.0**order - 1.0) - solution
    size: Array = np.abs(left).max(axis=1, initial=0.0)
    own: Array = np.maximum.accumulate(np.abs(change).max(axis=1, initial=0.0))
    return size, own
