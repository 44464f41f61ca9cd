"""Errors that fall less than a method's order says: wrong physics, noise, coarse interpolation below its own error.

At half the step, the error of a method of order p is smaller by 2^p, to leading order. Richardson's extrapolation of
two runs is therefore better than either run. Its remaining error is not the method's: it is a term that is the same at
both settings, or noise. The check detects errors far smaller than the method's own.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory

HIGHER_ORDER_SHARE = 0.1
"""Largest error of the extrapolation by terms of higher order, relative to the change between two settings. On random
scenes every unmodified engine in a moving frame stayed below 0.05."""
PERSISTING_SHARE = 0.5
"""Least size of a persisting error, relative to one setting before: terms of higher order fall four times or more, at
order 2 sixteen times"""
FIELDS = {"com": "com_m", "attitude": "angle_rad", "rate": "rate_rad_s", "reaction": "reaction_N"}


def extrapolation_residual(
    quantity: str, coarse: Trajectory, fine: Trajectory, right: Trajectory, order: float
) -> tuple[Array, Array]:
    """Error of the extrapolation of two runs, and their difference, each (n,), the largest component.

    Parameters
    ----------
    quantity : str
        One of :data:`FIELDS`.
    coarse, fine : Trajectory
        Runs at some step and at half of it.
    right : Trajectory
        The judging solution.
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
