"""Joint coordinates of a chain: one bar's end, and each bar's angle relative to the previous bar.

Coordinates (N + 2,): x and y of bar 1's left end in the frame, bar 1's angle from the frame's x axis, then the angle at
each joint.
"""

from __future__ import annotations

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


def to_joint_coordinates(length_m: Array, start: ChainPose) -> tuple[Array, Array]:
    """Joint coordinates and their rates, each (N + 2,), of a state."""
    (along, *_), (across, *_) = directions(start.angle_rad)
    half = 0.5 * length_m[0]
    left = start.position_m[0] - half * along
    motion = start.velocity_m_s[0] - half * start.rate_rad_s[0] * across
    return (
        np.concatenate([left, start.angle_rad[:1], np.diff(start.angle_rad)]),
        np.concatenate([motion, start.rate_rad_s[:1], np.diff(start.rate_rad_s)]),
    )


def angles(q: Array) -> Array:
    """Bars' absolute angles (or rates), (n, N), from coordinates (or their rates), (n, N + 2)."""
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
    """Accelerations of the bars' centres in the frame, (n, N, 2)."""
    along, across = directions(angles(q))
    turning = angles(q_tt)[..., None] * across - (angles(q_t) ** 2)[..., None] * along
    return bar_centres(q_tt, 0.5 * length_m[:, None] * turning)


def bar_centres(base: Array, reach: Array) -> Array:
    """Centres (n, N, 2) of bars with vectors `reach` from centre to right end; the first bar starts at `base`."""
    total: Array = base[:, None, :2] + 2.0 * np.cumsum(reach, axis=1) - reach
    return total
