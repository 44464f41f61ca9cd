"""Joint coordinates of a chain: one bar's end, and each bar's angle relative to the previous bar.

Coordinates (N + 2,): x and y of bar 1's left end in the frame, bar 1's angle from the frame's x axis, then the angle at
each joint.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from reference_impl.model.kinematics import directions

if TYPE_CHECKING:
    from adapters.trajectory import Array


class ChainPose(Protocol):
    """State of the bars in a frame whose origin is the centre of mass."""

    @property
    def position_m(self) -> Array:
        """(N, 2)."""

    @property
    def velocity_m_s(self) -> Array:
        """(N, 2)."""

    @property
    def angle_rad(self) -> Array:
        """(N,)."""

    @property
    def rate_rad_s(self) -> Array:
        """(N,)."""


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


def to_joint_coordinates(length_m: Array, start: ChainPose) -> tuple[Array, Array]:
    """Joint coordinates of a state and their rates.

    Parameters
    ----------
    length_m : ndarray, shape (N,)
    start : ChainPose
        Bars in the frame, with closed joints; an `InitialState` is one, as the frame starts at the centre of mass.

    Returns
    -------
    q, q_t : ndarray, shape (N + 2,)
        m and rad; m/s and rad/s.
    """
    (along, *_), (across, *_) = directions(start.angle_rad)
    half = 0.5 * length_m[0]
    left = start.position_m[0] - half * along
    motion = start.velocity_m_s[0] - half * start.rate_rad_s[0] * across
    return (
        np.concatenate([left, start.angle_rad[:1], np.diff(start.angle_rad)]),
        np.concatenate([motion, start.rate_rad_s[:1], np.diff(start.rate_rad_s)]),
    )


def from_joint_coordinates(length_m: Array, q: Array, q_t: Array) -> BarsInFrame:
    """Bars in the frame from joint coordinates and their rates.

    Parameters
    ----------
    length_m : ndarray, shape (N,)
    q, q_t : ndarray, shape (n, N + 2)
        Rows as :func:`to_joint_coordinates` gives them.

    Returns
    -------
    BarsInFrame
    """
    angle_rad, rate_rad_s, half = angles(q), angles(q_t), 0.5 * length_m[:, None]
    along, across = directions(angle_rad)
    position, velocity = bar_centres(q, half * along), bar_centres(q_t, half * rate_rad_s[..., None] * across)
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


def positions(length_m: Array, q: Array) -> Array:
    """Bars' centres in the frame, (n, N, 2), from coordinates (n, N + 2)."""
    along, _ = directions(angles(q))
    return bar_centres(q, 0.5 * length_m[:, None] * along)


def velocities(length_m: Array, q: Array, q_t: Array) -> Array:
    """Velocities of the bars' centres in the frame, (n, N, 2)."""
    _, across = directions(angles(q))
    return bar_centres(q_t, 0.5 * length_m[:, None] * angles(q_t)[..., None] * across)


def accelerations(length_m: Array, q: Array, q_t: Array, q_tt: Array) -> Array:
    """Accelerations of the bars' centres in the frame, (n, N, 2), m/s².

    They are linear in `q_tt`. With unit vectors as rows of `q_tt` and zeros as `q_t` the rows of the result are the
    columns of the Jacobian from joint coordinates to centres.

    Parameters
    ----------
    length_m : ndarray, shape (N,)
    q, q_t, q_tt : ndarray, shape (n, N + 2)
        Coordinates, their rates and their second derivatives.

    Returns
    -------
    ndarray, shape (n, N, 2)
    """
    along, across = directions(angles(q))
    turning = angles(q_tt)[..., None] * across - (angles(q_t) ** 2)[..., None] * along
    return bar_centres(q_tt, 0.5 * length_m[:, None] * turning)


def bar_centres(base: Array, reach: Array) -> Array:
    """Centres (n, N, 2) of bars with vectors `reach` from centre to right end; the first bar starts at `base`."""
    total: Array = base[:, None, :2] + 2.0 * np.cumsum(reach, axis=1) - reach
    return total


def weighted_mean(mass_kg: Array, vectors: Array) -> Array:
    """Mean of the bars' vectors (n, N, 2), weighted by mass: (n, 2)."""
    mean: Array = np.einsum("j,njk->nk", mass_kg / math.fsum(mass_kg), vectors)
    return mean
