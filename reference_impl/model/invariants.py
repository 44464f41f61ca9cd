"""Energy and angular momentum, each split into the centre of mass' part and the relative part."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reference_impl.model.kinematics import bar_centre_vectors, cross, directions

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array
    from reference_impl.model.chain import ChainModel


def relative_kinetic_energy(model: ChainModel, angle_rad: Array, rate_rad_s: Array) -> Array:
    """Kinetic energy about the centre of mass of a chain with closed joints, shape (n,), J.

    Parameters
    ----------
    model : ChainModel
    angle_rad, rate_rad_s : ndarray, shape (n, N)
    """
    velocity = relative_motion(model, angle_rad, rate_rad_s)[1]
    spin = 0.5 * rate_rad_s**2 @ model.inertia_kg_m2
    total: Array = spin + 0.5 * np.sum(velocity**2, axis=-1) @ model.mass_kg
    return total


def relative_angular_momentum(model: ChainModel, angle_rad: Array, rate_rad_s: Array) -> Array:
    """Angular momentum about the centre of mass of a chain with closed joints, shape (n,), N m s."""
    position, velocity = relative_motion(model, angle_rad, rate_rad_s)
    total: Array = rate_rad_s @ model.inertia_kg_m2 + cross(position, velocity) @ model.mass_kg
    return total


def com_energy(model: ChainModel, com_m: Array, com_velocity_m_s: Array) -> Array:
    """Energy of a particle of the chain's mass at the centre of mass, shape (n,), J."""
    mass = model.mass_kg.sum()
    kinetic: Array = 0.5 * mass * np.sum(com_velocity_m_s**2, axis=-1)
    if model.gravity == "none":
        return kinetic
    energy: Array = kinetic - mass * model.mu_m3_s2 / np.linalg.norm(com_m, axis=-1)
    return energy


def com_angular_momentum(model: ChainModel, com_m: Array, com_velocity_m_s: Array) -> Array:
    """Angular momentum of a particle of the chain's mass about the centre of the body, shape (n,), N m s."""
    momentum: Array = model.mass_kg.sum() * cross(com_m, com_velocity_m_s)
    return momentum


def tidal_energy(model: ChainModel, com_m: Array, angle_rad: Array) -> Array:
    """Potential energy of the bars as particles minus that of the whole mass at the centre of mass, (n,), J.

    With 1 + q_j = |Z0 + d_j|²/|Z0|² and s_j its root, the sum of m_j (-mu) (1/|Z0 + d_j| - 1/|Z0|) equals the sum of

    (-mu/|Z0|) m_j (-q_j/2 + q_j² (s_j + 2)/(2 s_j (1 + s_j)²)).

    The part of q_j = (2 Z0 + d_j)·d_j/|Z0|² linear in d_j exceeds the rest by the inverse size ratio. Its weighted sum
    is zero by eq. (6). The code omits this part, so that nothing cancels.
    """
    along, _ = directions(angle_rad)
    position = bar_centre_vectors(model, model.half_m[:, None] * along)
    com = com_m[:, None, :]
    r2 = np.sum(com * com, axis=-1)
    q = np.sum((2.0 * com + position) * position, axis=-1) / r2
    s = np.sqrt(1.0 + q)
    curved = q * q * (s + 2.0) / (2.0 * s * (1.0 + s) ** 2) - 0.5 * np.sum(position * position, axis=-1) / r2
    potential: Array = -model.mu_m3_s2 / np.sqrt(r2[:, 0]) * (curved @ model.mass_kg)
    return potential


def relative_motion(model: ChainModel, angle_rad: Array, rate_rad_s: Array) -> tuple[Array, Array]:
    """Relative positions and velocities over time, each (n, N, 2)."""
    along, across = directions(angle_rad)
    return (
        bar_centre_vectors(model, model.half_m[:, None] * along),
        bar_centre_vectors(model, (model.half_m * rate_rad_s)[..., None] * across),
    )
