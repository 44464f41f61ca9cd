"""Kinematics of the chain: positions of the bars relative to the chain's centre of mass, from the angles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reference_impl.model.complex_vectors import as_complex, as_vectors, unit_along
from reference_impl.model.state import State

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array, ComplexArray
    from reference_impl.model.effect import ChainProperties


def directions(angle_rad: Array) -> tuple[Array, Array]:
    """Unit vectors u_j along each bar and n_j across (u_j turned by +90 degrees), each (N, 2)."""
    u = unit_along(angle_rad)
    return as_vectors(u), as_vectors(1j * u)


def by_levers(model: ChainProperties, left: ComplexArray, right: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Quantities (..., N) of the left and the right ends of bars with equal levers, as they are with the bars' own."""
    if model.com_share is None:
        return left, right
    return model.left_share * left, model.right_share * right


def bar_centre_vectors(model: ChainProperties, reach: Array) -> Array:
    """Positions of the bars' centres relative to the centre of mass, given each bar's half length as a vector.

    By eq. (7') neighbouring centres are `reach_j + reach_{j+1}` apart, with unequal levers
    `beta_j reach_j + alpha_{j+1} reach_{j+1}`; by eq. (6) the weighted mean is zero. The map is linear in `reach`, and
    serves positions and velocities.

    Parameters
    ----------
    model : ChainProperties
    reach : ndarray, shape (..., N, 2)
        (l_j/2) u_j, or its time derivative.

    Returns
    -------
    ndarray, shape (..., N, 2)
    """
    return as_vectors(bar_centres(model, as_complex(reach)))


def bar_centres(model: ChainProperties, reach: ComplexArray) -> ComplexArray:
    """:func:`bar_centre_vectors` for plane vectors as complex numbers, shape (..., N)."""
    from_first = np.zeros_like(reach)
    left, right = by_levers(model, reach, reach)
    np.cumsum(right[..., :-1] + left[..., 1:], axis=-1, out=from_first[..., 1:])
    centred: ComplexArray = from_first - (from_first @ model.weight)[..., None]
    return centred


def relative_positions(model: ChainProperties, angle_rad: Array) -> Array:
    """d_j = Z_j - Z0 of a chain with closed joints at angles (..., N), shape (..., N, 2), m."""
    return as_vectors(bar_centres(model, model.half_m * unit_along(angle_rad)))


def relative_velocities(model: ChainProperties, angle_rad: Array, rate_rad_s: Array) -> Array:
    """Time derivative of :func:`relative_positions`, shape (N, 2), m/s."""
    return as_vectors(bar_centres(model, 1j * model.half_m * rate_rad_s * unit_along(angle_rad)))


def consistent_state(
    model: ChainProperties, com_m: Array, com_velocity_m_s: Array, angle_rad: Array, rate_rad_s: Array
) -> State:
    """Complete state of a chain with closed joints."""
    reach = np.empty((2, len(angle_rad)), np.complex128)  # and its rate; np.stack takes a fifth of the whole time
    np.multiply(model.half_m, unit_along(angle_rad), out=reach[0])
    np.multiply(1j * rate_rad_s, reach[0], out=reach[1])
    position, velocity = bar_centres(model, reach)
    return State(com_m, com_velocity_m_s, angle_rad, rate_rad_s, as_vectors(position), as_vectors(velocity))


def gap_vectors(model: ChainProperties, position_m: Array, angle_rad: Array) -> Array:
    """Left end of bar j+1 minus right end of bar j, shape (..., N-1, 2), m: eq. (19), zero for a closed joint."""
    reach = model.half_m * unit_along(angle_rad)
    left, right = map(as_vectors, by_levers(model, reach, reach))
    gap: Array = (position_m[..., 1:, :] - position_m[..., :-1, :]) - (left[..., 1:, :] + right[..., :-1, :])
    return gap


def cross(a: Array, b: Array) -> Array:
    """Third component of the plane vectors' cross product, over the last axis."""
    product: Array = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return product
