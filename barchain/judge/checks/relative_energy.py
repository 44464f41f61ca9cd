"""Kinetic energy about the centre of mass beside the largest that there can be: bounded in chaotic motion too."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.common.initial_state import chain_model
from reference_impl.model.invariants import relative_kinetic_energy
from reference_impl.model.kinematics import relative_positions
from scenarios import Gravity

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

BLOWN_UP = 4.0
"""Of the largest kinetic energy about the centre of mass that there can be: every rate twice as large as any.

There can be what the reference solution has, and what the tide can lend a chain that is stretched out, between lying
along the orbit and standing upright: 3/2 n² I. So it is asked beyond the predictability limit too, where paths differ,
and of a chain that leaves an equilibrium on which the reference solution is still standing.
"""


def kinetic_energy(scene: Scene, trajectory: Trajectory) -> Array | None:
    """Kinetic energy about the centre of mass, (n,), J; None of an engine without attitude."""
    if trajectory.angle_rad is None or trajectory.rate_rad_s is None:
        return None
    return relative_kinetic_energy(chain_model(scene), trajectory.angle_rad, trajectory.rate_rad_s)


def lent_by_tide(solution: ReferenceSolution) -> float:
    """Largest energy that the tide can lend the chain, J: 3/2 n² I, n at its lowest and stretched out."""
    scene = solution.scene
    if scene.effects.gravity is Gravity.NONE:
        return 0.0
    lowest = float(np.linalg.norm(solution.trajectory.com_m, axis=1).min())
    model = chain_model(scene)
    place = relative_positions(model, np.zeros(model.bars))[:, 0]
    inertia = float(model.mass_kg @ place**2 + model.inertia_kg_m2.sum())
    return 1.5 * scene.central_body.mu_m3_s2 / lowest**3 * inertia


def kinetic_ratio(trajectory: Trajectory, solution: ReferenceSolution) -> float | None:
    """Largest kinetic energy about the centre of mass over the largest there can be; None without attitude."""
    mine, theirs = (kinetic_energy(solution.scene, each) for each in (trajectory, solution.trajectory))
    if mine is None or theirs is None:
        return None
    most = float(theirs.max()) + lent_by_tide(solution)
    return float(mine.max()) / most if most > 0.0 else None
