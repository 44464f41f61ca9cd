"""Gravity of the central body's point field, and the torque of its gradient; other models are effects beside it.

No two large numbers are subtracted.

Encke's method: with q = (2 Z0 + d)·d / |Z0|², an inverse power of the distance is |Z0 + d|^-p = |Z0|^-p (1+q)^(-p/2).
Its change expm1(-p/2 log1p(q)) keeps all digits for any small d. Encke's method replaces the paper's O(N²) sums
(A.1)-(A.6) and is as free from cancellation.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reference_impl.model.complex_vectors import as_complex, as_vectors, squared_norm

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array, ComplexArray
    from reference_impl.model.chain import ChainModel


def point_field(mu_m3_s2: float, position_m: Array) -> Array:
    """Acceleration -mu Z/|Z|³ at `position_m`, shape (..., 2), m/s²: eq. (8)."""
    r2 = squared_norm(as_complex(position_m))
    field: Array = (-mu_m3_s2 / (r2 * np.sqrt(r2)))[..., None] * position_m
    return field


def field_differences(mu_m3_s2: float, com_m: Array, position_m: Array) -> Array:
    """g(Z0 + d_j) - g(Z0) for each relative position d_j, shape (N, 2), m/s²."""
    return as_vectors(complex_field_differences(mu_m3_s2, as_complex(com_m), as_complex(position_m)))


def complex_field_differences(mu_m3_s2: float, com_m: ComplexArray, position_m: ComplexArray) -> ComplexArray:
    """:func:`field_differences` for plane vectors as complex numbers."""
    r2 = squared_norm(com_m)
    twice = 2.0 * com_m + position_m
    q = (twice.real * position_m.real + twice.imag * position_m.imag) / r2
    change = np.expm1(-1.5 * np.log1p(q))
    difference: ComplexArray = -mu_m3_s2 / (r2 * np.sqrt(r2)) * (position_m * (1.0 + change) + com_m * change)
    return difference


def gradient_angular_accelerations(model: ChainModel, place_m: ComplexArray, along: ComplexArray) -> Array:
    """Angular acceleration K_j/J_j = +3 mu sin(phi) cos(phi)/r³ of each bar, shape (N,), rad/s².

    Eq. (17) prints a minus sign. The angle phi counts from the horizontal (the radial direction turned by -90 degrees),
    so that the plus sign turns a bar towards the radial direction.

    Parameters
    ----------
    model : ChainModel
    place_m : ndarray of complex, shape (N,)
        Bars' centres of mass from the centre of the body.
    along : ndarray of complex, shape (N,)
        Unit vectors u_j.
    """
    r2 = squared_norm(place_m)
    seen = along.conj() * place_m  # r sin(phi) + i r cos(phi)
    spin: Array = 3.0 * model.mu_m3_s2 * seen.real * seen.imag / (r2 * r2 * np.sqrt(r2))
    return spin


def perigee_m(mu_m3_s2: float, place_m: Array, velocity_m_s: Array) -> float:
    """Perigee of the Kepler orbit through a position and a velocity, both (2,), m from the body's centre."""
    (x, z), (vx, vz) = place_m, velocity_m_s
    parameter = (x * vz - z * vx) ** 2 / mu_m3_s2
    energy = 0.5 * (vx * vx + vz * vz) - mu_m3_s2 / np.hypot(x, z)
    return float(parameter / (1.0 + np.sqrt(max(0.0, 1.0 + 2.0 * energy * parameter / mu_m3_s2))))
