"""Closed forms of a straight radial chain."""

from itertools import pairwise

import numpy as np

from scenarios import Scene


def radial_tension(scene: Scene) -> np.ndarray:
    """Tension (N-1,) of the straight radial chain at v0/r0, exactly: sum beyond of m (omega² d + tide)."""
    mass, length = np.array(scene.chain.mass_kg), np.array(scene.chain.length_m)
    d, r, mu = distances(scene), scene.radius0_m, scene.central_body.mu_m3_s2
    change = -mu / r**2 * np.expm1(-2.0 * np.log1p(d / r))  # -mu/(r+d)² + mu/r², without cancellation
    tide = change - mass @ change / mass.sum()
    beyond = mass * (scene.orbital_rate_rad_s**2 * d + tide)
    return np.array([beyond[j + 1 :].sum() for j in range(len(length) - 1)])


def distances(scene: Scene) -> np.ndarray:
    """Places (N,) along the straight chain from its centre of mass."""
    mass, length = np.array(scene.chain.mass_kg), np.array(scene.chain.length_m)
    d = np.concatenate([[0.0], np.cumsum([0.5 * (a + b) for a, b in pairwise(length)])])
    return d - mass @ d / mass.sum()


def first_moments(scene: Scene) -> np.ndarray:
    """First moment (N-1,), kg m, of everything beyond each joint."""
    moment = np.array(scene.chain.mass_kg) * distances(scene)
    return np.array([moment[j + 1 :].sum() for j in range(scene.bars - 1)])
