"""Joint coordinates of a chain (one bar's end, then each bar's angle relative to the previous bar), and joint forces.

Coordinates (N + 2,): x and y of bar 1's left end in the frame, bar 1's angle from the frame's x axis, then the angle at
each joint.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.model.kinematics import directions

if TYPE_CHECKING:
    from adapters.common.initial_state import InitialState
    from adapters.trajectory import Array


@dataclass(frozen=True)
class BarsInFrame:
    """Bars in a frame with axes of fixed direction, at n instants."""

    position_m: Array
    """(n, N, 2) centres"""
    velocity_m_s: Array
    """(n, N, 2)"""
    angle_rad: Array
    """(n, N) absolute angles"""
    rate_rad_s: Array
    """(n, N)"""

    def track(self, mass_kg: Array, origin_m: Array, drift_m_s: Array) -> tuple[Array, Array]:
        """Centre of mass from the centre of the body, and its velocity, each (n, 2).

        Parameters
        ----------
        mass_kg : ndarray, shape (N,)
        origin_m, drift_m_s : ndarray, shape (n, 2)
            Origin of the frame and its velocity.
        """
        return origin_m + weighted_mean(mass_kg, self.position_m), drift_m_s + weighted_mean(mass_kg, self.velocity_m_s)


def to_joint_coordinates(length_m: Array, start: InitialState, left_m: Array | None = None) -> tuple[Array, Array]:
    """Joint coordinates of a state and their rates.

    Parameters
    ----------
    length_m : ndarray, shape (N,)
    start : InitialState
        With closed joints; positions and velocities of the bars in the frame, whose origin is the centre of mass.
    left_m : ndarray, shape (N,), optional
        Distances of the bars' left ends from their centres of mass; half of the lengths by default.

    Returns
    -------
    q, q_t : ndarray, shape (N + 2,)
        m and rad; m/s and rad/s.
    """
    (along, *_), (across, *_) = directions(start.angle_rad)
    lever = 0.5 * length_m[0] if left_m is None else left_m[0]
    left = start.position_m[0] - lever * along
    motion = start.velocity_m_s[0] - lever * start.rate_rad_s[0] * across
    return (
        np.concatenate([left, start.angle_rad[:1], np.diff(start.angle_rad)]),
        np.concatenate([motion, start.rate_rad_s[:1], np.diff(start.rate_rad_s)]),
    )


def from_joint_coordinates(length_m: Array, q: Array, q_t: Array, left_m: Array | None = None) -> BarsInFrame:
    """Bars in the frame from joint coordinates and their rates.

    Parameters
    ----------
    length_m : ndarray, shape (N,)
    q, q_t : ndarray, shape (n, N + 2)
        Rows as :func:`to_joint_coordinates` gives them.
    left_m : ndarray, shape (N,), optional
        As there.

    Returns
    -------
    BarsInFrame
    """
    angle_rad, rate_rad_s = angles(q), angles(q_t)
    along, across = directions(angle_rad)
    position = bar_centres(q, length_m, along, left_m)
    turned = None if left_m is None else left_m * rate_rad_s
    velocity = bar_centres(q_t, length_m * rate_rad_s, across, turned)
    return BarsInFrame(position, velocity, angle_rad, rate_rad_s)


def angles(q: Array) -> Array:
    """Bars' absolute angles from coordinates, or their rates from rates of coordinates.

    Parameters
    ----------
    q : ndarray, shape (n, N + 2)
        Coordinates (rad), or any of their time derivatives.

    Returns
    -------
    ndarray, shape (n, N)
    """
    return np.cumsum(q[:, 2:], axis=1)


def positions(length_m: Array, q: Array, left_m: Array | None = None) -> Array:
    """Bars' centres in the frame, (n, N, 2), from coordinates (n, N + 2)."""
    along, _ = directions(angles(q))
    return bar_centres(q, length_m, along, left_m)


def accelerations(length_m: Array, q: Array, q_t: Array, q_tt: Array, left_m: Array | None = None) -> Array:
    """Accelerations of the bars' centres in the frame, (n, N, 2), m/s².

    They are linear in `q_tt`. With unit vectors as rows of `q_tt` and zeros as `q_t` the rows of the result are the
    columns of the Jacobian from joint coordinates to centres.

    Parameters
    ----------
    length_m : ndarray, shape (N,)
    q, q_t, q_tt : ndarray, shape (n, N + 2)
        Coordinates, their rates and their second derivatives.
    left_m : ndarray, shape (N,), optional
        As in :func:`to_joint_coordinates`.

    Returns
    -------
    ndarray, shape (n, N, 2)
    """
    along, across = directions(angles(q))
    turning = angles(q_tt)[..., None] * across - (angles(q_t) ** 2)[..., None] * along
    return bar_centres(q_tt, length_m, turning, left_m)


def bar_centres(base: Array, length_m: Array, along: Array, left_m: Array | None) -> Array:
    """Centres (n, N, 2) of bars along `along` (n, N, 2), or derivatives of both; the first bar starts at `base`."""
    right_m = 0.5 * length_m if left_m is None else length_m - left_m
    total: Array = base[:, None, :2] + np.cumsum(length_m[..., None] * along, axis=1) - right_m[..., None] * along
    return total


def weighted_mean(mass_kg: Array, vectors: Array) -> Array:
    """Mean of the bars' vectors (n, N, 2), weighted by mass: (n, 2)."""
    mean: Array = np.einsum("j,njk->nk", mass_kg / math.fsum(mass_kg), vectors)
    return mean


def reaction_from_wrench(force_N: Array, *, on_next_bar: bool, axes_rad: Array | float = 0.0) -> Array:
    """Force on bar j from bar j+1 in inertial axes, from the force of a joint's wrench.

    A wrench is a force and a moment. Its force is the same at every point of reference, so that the moment and the
    point are not needed. A spatial wrench may begin with its moment: give the force alone.

    Parameters
    ----------
    force_N : ndarray, shape (..., 2) or (..., 3)
        Components along the wrench's own axes; a third one, normal to the plane, is left out.
    on_next_bar : bool
        True if the force acts on bar j+1, as on the child of a joint tree that starts at bar 1. False if it acts on
        bar j.
    axes_rad : float or ndarray, shape (...)
        Angle of the wrench's first axis from the inertial z1 axis, counter-clockwise: 0 for inertial axes, a bar's
        angle for its body axes.

    Returns
    -------
    ndarray, shape (..., 2)

    Raises
    ------
    ValueError
        If the last axis of `force_N` holds neither two nor three components.
    """
    if force_N.shape[-1] not in (2, 3):
        raise ValueError(f"force_N has shape {force_N.shape}, expected (..., 2) or (..., 3)")
    sign = -1.0 if on_next_bar else 1.0
    c, s = sign * np.cos(axes_rad), sign * np.sin(axes_rad)
    first, second = force_N[..., 0], force_N[..., 1]
    return np.stack([c * first - s * second, s * first + c * second], axis=-1)


def reactions_from_motion(mass_kg: Array, acceleration_m_s2: Array, force_N: Array) -> Array:
    """Force on each bar from the next, by Newton's law for all bars up to it.

    For engines without joint forces. Accelerations and forces must be relative to the same falling frame: in inertial
    ones the reactions are lost as small differences of large numbers.

    Parameters
    ----------
    mass_kg : ndarray, shape (N,)
    acceleration_m_s2 : ndarray, shape (..., N, 2)
        Of the bars' centres.
    force_N : ndarray, shape (..., N, 2)
        On each bar, without the reactions.

    Returns
    -------
    ndarray, shape (..., N-1, 2)
    """
    missing: Array = np.cumsum(mass_kg[:, None] * acceleration_m_s2 - force_N, axis=-2)
    return missing[..., :-1, :]
