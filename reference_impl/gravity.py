"""Gravity of the central body on the bars, without ever subtracting two large numbers.

Encke's way: with q = (2 Z0 + d)·d / |Z0|², an inverse power of the distance is
|Z0 + d|^-p = |Z0|^-p (1+q)^(-p/2), and its change expm1(-p/2 log1p(q)) keeps all digits however
small d is. It replaces the paper's O(N²) sums (A.1)-(A.6) at the same freedom from cancellation.
"""

from __future__ import annotations

import numpy as np

from reference_impl.chain import Array, ChainModel


def point_field(mu_m3_s2: float, position_m: Array) -> Array:
    """Acceleration -mu Z/|Z|³ at `position_m`, shape (..., 2), m/s²: eq. (8)."""
    r2 = np.sum(position_m * position_m, axis=-1, keepdims=True)
    field: Array = -mu_m3_s2 * position_m / (r2 * np.sqrt(r2))
    return field


def field_differences(mu_m3_s2: float, com_m: Array, position_m: Array) -> Array:
    """g(Z0 + d_j) - g(Z0) for each relative position d_j, shape (N, 2), m/s²."""
    r2 = com_m @ com_m
    q = np.sum((2.0 * com_m + position_m) * position_m, axis=-1, keepdims=True) / r2
    change = np.expm1(-1.5 * np.log1p(q))
    difference: Array = -mu_m3_s2 / (r2 * np.sqrt(r2)) * (position_m * (1.0 + change) + com_m * change)
    return difference


def gradient_torques(model: ChainModel, place_m: Array, along: Array) -> Array:
    """Gravity-gradient torque on each bar, K_j = +3 mu J_j sin(phi) cos(phi)/r³, shape (N,), N m.

    Eq. (17) prints it with a minus; phi is measured from the horizontal, so that plus turns a bar
    towards the radial.

    Parameters
    ----------
    model : ChainModel
    place_m : ndarray, shape (N, 2)
        Bars' centres of mass from the centre of the body.
    along : ndarray, shape (N, 2)
        Unit vectors u_j.
    """
    r2 = np.sum(place_m * place_m, axis=-1)
    sine = np.sum(along * place_m, axis=-1)  # r sin(phi)
    cosine = along[:, 0] * place_m[:, 1] - along[:, 1] * place_m[:, 0]  # r cos(phi); horizontal = radial turned by -90°
    torque: Array = 3.0 * model.mu_m3_s2 * model.inertia_kg_m2 * sine * cosine / (r2 * r2 * np.sqrt(r2))
    return torque
