"""Kinetic energy about the centre of mass relative to its largest possible value: bounded in chaotic motion too."""

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

MAX_KINETIC_RATIO = 4.0
"""Largest kinetic energy about the centre of mass that is accepted, relative to the largest possible: twice every rate.

The largest possible energy is that of the judging solution, and the energy that the tide can give a stretched chain
between lying along the orbit and standing upright: 3/2 n² I. The bound therefore holds beyond the predictability limit
too, and for a chain that leaves an equilibrium on which the judging solution still rests.
"""


def kinetic_energy(scene: Scene, trajectory: Trajectory) -> Array | None:
    """Kinetic energy about the centre of mass, (n,), J; None of an engine without attitude."""
    if trajectory.angle_rad is None or trajectory.rate_rad_s is None:
        return None
    return relative_kinetic_energy(chain_model(scene), trajectory.angle_rad, trajectory.rate_rad_s)


def max_tidal_gain(solution: ReferenceSolution) -> float:
    """Largest energy that the tide can give the chain, J: 3/2 n² I, n at its lowest, the chain stretched."""
    scene = solution.scene
    if scene.effects.gravity is Gravity.NONE:
        return 0.0
    lowest = float(np.linalg.norm(solution.trajectory.com_m, axis=1).min())
    model = chain_model(scene)
    place = relative_positions(model, np.zeros(model.bars))[:, 0]
    inertia = float(model.mass_kg @ place**2 + model.inertia_kg_m2.sum())
    return 1.5 * scene.central_body.mu_m3_s2 / lowest**3 * inertia


def kinetic_ratio(trajectory: Trajectory, solution: ReferenceSolution) -> float | None:
    """Largest kinetic energy about the centre of mass relative to the largest possible; None without attitude."""
    mine, theirs = (kinetic_energy(solution.scene, each) for each in (trajectory, solution.trajectory))
    if mine is None or theirs is None:
        return None
    most = float(theirs.max()) + max_tidal_gain(solution)
    return float(mine.max()) / most if most > 0.0 else None
