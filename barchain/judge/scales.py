"""Scales of a scene, which errors are counted in: sizes of its quantities, rates of its orbit, roundings, slacks."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

NORM_SLACK = 10.0
"""Slack of all bounds: largest component against norm, method constants other than the textbook's, stage effects"""
MACHINE_EPSILON = float(np.finfo(float).eps)  # twice the unit roundoff: distance from 1 to the next double
ROUNDINGS = 16.0
"""Rounding errors that enter a state in one step: a handful of operations, one for each stage"""
FIELDS = {
    "com": "com_m",
    "com_velocity": "com_velocity_m_s",
    "attitude": "angle_rad",
    "rate": "rate_rad_s",
    "reaction": "reaction_N",
    "torque": "torque_N_m",
    "impulse": "impulse_N_s",
}
"""Compared quantities, and their arrays in a trajectory"""


def scales(solution: ReferenceSolution) -> dict[str, float]:
    """Size of each quantity over the whole run, from the judging solution and the scene alone; SI units.

    ``attitude`` counts in radians, ``rate`` in the fastest rate of a bar. ``reaction`` counts in the largest one, but
    in no less than the inertia force of the bars: where forces cancel, their sum says nothing of what they are made of.
    """
    scene, seen = solution.scene, solution.trajectory
    force = inertia_force_N(scene)
    found = {
        "com": largest(seen.com_m),
        "com_velocity": largest(seen.com_velocity_m_s),
        "attitude": 1.0,
        "rate": max(largest_entry(seen.rate_rad_s), scene.fastest_rate_rad_s),
        "reaction": max(largest(seen.reaction_N), force),
        "torque": max(largest_entry(seen.torque_N_m), force * max(scene.chain.length_m)),
        "impulse": max(largest(seen.impulse_N_s), force / scene.fastest_rate_rad_s),
        "gap": min(scene.chain.length_m),
        "com_residual": min(scene.chain.length_m),
    }
    return found | dict.fromkeys(("energy", "angular_momentum", "energy_about_com", "angular_momentum_about_com"), 1.0)


def inertia_force_N(scene: Scene) -> float:
    """Force that turns the heaviest bar about its end at the orbit's rate, or at the bars' own, N: m l w²."""
    chain = scene.chain
    return max(m * size for m, size in zip(chain.mass_kg, chain.length_m, strict=True)) * scene.fastest_rate_rad_s**2


def largest(vectors: Array | None) -> float:
    """Largest length of vectors (..., 2); 0 of none."""
    return 0.0 if vectors is None else float(np.linalg.norm(vectors, axis=-1).max(initial=0.0))


def largest_entry(values: Array | None) -> float:
    """Largest absolute value; 0 of none."""
    return 0.0 if values is None else float(np.abs(values).max(initial=0.0))


def orbit_scale(scene: Scene) -> float:
    """Rate of the orbit: its mean motion, or that of the circular orbit at r0 if faster."""
    return 2.0 * math.pi / scene.step_period_s


def kepler_growth(scene: Scene, t_s: Array) -> Array:
    """Growth of a small error of the centre of mass, (n,): 1 + 3 n t, an error of the period along the track."""
    return 1.0 + 3.0 * orbit_scale(scene) * t_s


def orbit_rate_bound(scene: Scene, trajectory: Trajectory) -> float:
    """Largest rate at which a displaced centre of mass moves: speed over distance, where the orbit is lowest."""
    speed, distance = (np.linalg.norm(x, axis=1) for x in (trajectory.com_velocity_m_s, trajectory.com_m))
    return max(orbit_scale(scene), float((speed / distance).max()))
