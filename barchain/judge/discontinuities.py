"""Errors of equal steps in which a bar turns its other face to the wind or the Sun: a force's slope jumps there."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import cumulative_trapezoid

from barchain.judge.equations import Equations, mode_changes, states_of

if TYPE_CHECKING:
    from adapters.trajectory import Array
    from barchain.solutions.reference import ReferenceSolution
    from reference_impl.model.arrays import ComplexArray

LARGEST = 1.0 / 8.0
"""Largest error of a step h across a jump of an acceleration's slope, in h² times that jump: the jump half way"""
ON_ORBIT = 4.0
"""Largest growth on an orbit of an error of the velocity, and of its integral: (4 sin nt - 3 nt)/n along the track"""


def kink_errors(solution: ReferenceSolution, step_s: float, t_s: Array, amplification: Array) -> dict[str, Array]:
    """Error of equal steps by turning faces, (n,) for each quantity.

    As the jump lies in the step, 0 to :data:`LARGEST` are left, at each setting anew: two settings tell it of neither.
    Their mean falls with the step and is extrapolated. The rest adds up as a random walk, and so do the largest errors:
    of jumps that lie at random that is 3.4 standard deviations, and one alone is allowed whole.

    Parameters
    ----------
    solution : ReferenceSolution
        Judging solution; its close samples tell the jumps.
    step_s : float
        Step, s.
    t_s, amplification : ndarray, shape (n,)
        Samples, s, and the growth of an error of the attitude from the start on.
    """
    scene, seen = solution.scene, solution.fine
    states = states_of(seen)
    if states is None or len(seen.t_s) < 2:
        return {}
    e = Equations(scene, states)
    turning = list(mode_changes(e))
    if not turning:
        return {}
    inertia = e.shape.coupled(states) + np.diag(e.shape.inertia)
    velocity, rate = np.zeros(len(seen.t_s)), np.zeros(len(seen.t_s))
    for effect, turned in turning:
        load = e.of_effect(effect)
        whole = load.common + load.force.sum(axis=1) / e.shape.whole
        bars = np.linalg.solve(inertia, e.shape.generalised(states, load)[..., None])[..., 0]
        velocity[1:] += np.cumsum(turned * slope_jumps(seen.t_s, whole[:, None]) ** 2)
        rate[1:] += np.cumsum(turned * slope_jumps(seen.t_s, bars.astype(float)) ** 2)
    velocity, rate = (LARGEST * step_s**2 * np.sqrt(squares) for squares in (velocity, rate))
    drifted = cumulative_trapezoid(velocity, seen.t_s, initial=0)
    grown = cumulative_trapezoid(rate / np.interp(seen.t_s, t_s, amplification), seen.t_s, initial=0)
    attitude = amplification * np.interp(t_s, seen.t_s, grown)
    found = {name: attitude * response[: len(t_s)] for name, response in solution.response.items()}
    for name, more in (("com", ON_ORBIT * drifted), ("com_velocity", ON_ORBIT * velocity), ("rate", rate)):
        if name in found:
            found[name] = found[name] + np.interp(t_s, seen.t_s, more)
    return found


def slope_jumps(t_s: Array, values: Array | ComplexArray) -> Array:
    """Largest change of the slopes of values (m, k) across each interval, (m - 1,)."""
    slope = np.diff(values, axis=0) / np.diff(t_s)[:, None]
    beside = np.concatenate([slope[:1], slope, slope[-1:]])
    found: Array = np.abs(beside[2:] - beside[:-2]).max(axis=1)
    return found
