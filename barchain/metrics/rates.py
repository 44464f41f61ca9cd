"""Fastest rates of a scene, which steps and samples must resolve."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene

MODES_PER_BAR = 2.1  # fastest oscillation of a chain of N bars, over N times its rate (radial chain: 2.1 N n)


def rate_scale(scene: Scene, solution: Trajectory) -> float:
    """Fastest rate in the scene, rad/s: the chain's stiffest oscillation in its field or under its own spin."""
    spin = float(np.abs(solution.rate_rad_s).max()) if solution.rate_rad_s is not None else 0.0
    return max(MODES_PER_BAR * scene.bars * max(spin, scene.mean_motion_rad_s), scene.spring_rate_rad_s)


def own_rate(scene: Scene) -> float:
    """Fastest of the orbit's and the bars' own initial rates, rad/s."""
    orbit = 2.0 * math.pi / scene.step_period_s
    turning = scene.orbital_rate_rad_s * max(1.0, *(abs(a) for a in scene.chain.rate_factor))
    return max(orbit, turning, scene.spring_rate_rad_s / (MODES_PER_BAR * scene.bars))


def orbit_rate(trajectory: Trajectory) -> Array:
    """Rate of the longitude of the centre of mass, (n,), rad/s."""
    z, v = trajectory.com_m, trajectory.com_velocity_m_s
    rate: Array = (z[:, 0] * v[:, 1] - z[:, 1] * v[:, 0]) / np.sum(z * z, axis=1)
    return rate
