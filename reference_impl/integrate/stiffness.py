"""Stiffness by joint springs: stability, not accuracy, then limits the steps of an explicit method.

A high-order method limited by accuracy takes steps of a radian or two of any visible oscillation. Longer steps beside
unexcited springs indicate a stability limit. An implicit method, SciPy's Radau IIA of order 5, is then hundreds of
times as fast.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import DOP853, Radau

if TYPE_CHECKING:
    from collections.abc import Callable

    from reference_impl.integrate.coordinate_sets import StateCoordinates
    from reference_impl.model.arrays import Array

Solver = DOP853 | Radau
Method = type[DOP853] | type[Radau]

SUSPECTED_RAD = 1e4  # of the fastest spring in a run; an explicit method integrates fewer within a second
TRIAL_STEPS = 100
SETTLED_STEPS = 50  # last steps of the trial; the first ones still adapt their size
STABILITY_LIMIT_RAD = 2.5  # of the fastest spring in one step; DOP853 is stable up to 3.5 (oscillation) or 6 (decay)
RTOL_FLOOR = 100.0 * np.finfo(float).eps  # SciPy's least; atol sets the accuracy of each block
METHOD_NAMES = {DOP853: "DOP853", Radau: "Radau IIA of order 5, as its joint springs make the scene stiff"}


def choose_method(coordinates: StateCoordinates, y0: Array, t_s: Array, atol: Array) -> Method:
    """Solver of a run: DOP853, or Radau if stability would limit the steps of DOP853.

    Parameters
    ----------
    coordinates : StateCoordinates
    y0 : ndarray, shape (size,)
    t_s : ndarray, shape (n,)
        Sample instants.
    atol : ndarray, shape (size,)
        Error allowed in one step.
    """
    fastest = coordinates.model.spring_rate_rad_s
    if fastest * (t_s[-1] - t_s[0]) < SUSPECTED_RAD:
        return DOP853
    steps = trial_steps(coordinates.rhs, y0, t_s, atol)
    held = len(steps) == TRIAL_STEPS and np.median(steps[-SETTLED_STEPS:]) * fastest > STABILITY_LIMIT_RAD
    return Radau if held else DOP853


def trial_steps(rhs: Callable[[float, Array], Array], y0: Array, t_s: Array, atol: Array) -> list[float]:
    """Sizes of the first steps of an explicit method, s."""
    solver = DOP853(rhs, t_s[0], y0, t_s[-1], rtol=RTOL_FLOOR, atol=atol)  # type: ignore[arg-type]  # stubs accept scalars only
    steps: list[float] = []
    while solver.status == "running" and len(steps) < TRIAL_STEPS:
        if solver.step():
            break
        steps.append(float(solver.t - solver.t_old))
    return steps
