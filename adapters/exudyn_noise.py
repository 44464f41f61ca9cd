"""What limits Exudyn's multipliers whatever the step: declared to the comparison, and derived here."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from adapters.engine import Array
    from adapters.exudyn_solver import Method
    from scenarios import Scene

DIFFERENCING = 1e-8  # Exudyn's relative step in (C_q q')_q, of `minimumCoordinateSize` or of the coordinate
TRANSIENT = 0.1  # of the chain's inertia forces: first multipliers of index 3, measured up to 0.07 on eccentric scenes
PILES_UP = 4.0  # of a residual's noise: successive steps' add up while they are being damped


def multiplier_noise(scene: Scene, step_s: float, method: Method, t_s: Array) -> Array:
    """Error of the multipliers beyond the method's own, (n,), N.

    Index 2 asks for (C_q q')_q, which Exudyn differences forward: half the second derivative times the
    step, DIFFERENCING min(coordinate size) of m l w². Newton stops at a residual, a velocity there, so that
    accelerations are off by residual/h. At index 3 the residual is a place, over h², and generalized-alpha
    damps it by rho a step only: 1/(1 - rho) of them add up. It also starts with multipliers that do not
    shrink with the step and dies away by rho a step.

    Parameters
    ----------
    scene : Scene
    step_s : float
    method : Method
    t_s : ndarray, shape (n,)
    """
    chain, mass = scene.chain, max(scene.chain.mass_kg)
    rate = scene.orbital_rate_rad_s * max(1.0, *map(abs, chain.rate_factor))
    differenced = DIFFERENCING * max(method.difference_m, 1.0) * mass * max(chain.length_m) * rate**2
    if not method.index3:
        return np.full(len(t_s), differenced + mass * method.residual_N / step_s)
    damped = 1.0 - method.spectral_radius
    rough = PILES_UP * mass * method.residual_N / step_s**2 / damped
    transient = TRANSIENT * mass * scene.size_m * rate**2 * method.spectral_radius ** (t_s / step_s)
    noise: Array = differenced + rough + transient
    return noise
