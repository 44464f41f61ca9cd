"""Positions and velocities of other points, or from other origins."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.common.initial_state import chain_model, initial_state
from barchain.judge.diagnosis.mistake import ReadingMistake
from barchain.judge.diagnosis.readings.angles import bar_places, longitude_rate_rad_s
from barchain.judge.diagnosis.readings.joints import in_axes_at
from reference_impl.model.kinematics import directions

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.trajectory import Array, Trajectory
    from barchain.judge.diagnosis.mistake import ReadingChange
    from scenarios import Scene

    Point = Callable[[Scene, Trajectory], tuple[Array, Array]]


def from_start_position(scene: Scene, right: Trajectory) -> Trajectory:
    """Position of the centre of mass less its initial position."""
    return right.replace(com_m=right.com_m - initial_state(scene).com_m)


def from_start_velocity(scene: Scene, right: Trajectory) -> Trajectory:
    """Velocity of the centre of mass less its initial velocity."""
    return right.replace(com_velocity_m_s=right.com_velocity_m_s - initial_state(scene).com_velocity_m_s)


def from_start_track(scene: Scene, right: Trajectory) -> Trajectory:
    """Position and velocity of the centre of mass less their initial values."""
    return from_start_velocity(scene, from_start_position(scene, right))


def rotating_velocity(rate: Callable[[Scene, Trajectory], Array]) -> ReadingChange:
    """Velocity relative to axes that turn with a rate (n, 1) or (1, 1) rad/s."""

    def read(scene: Scene, right: Trajectory) -> Trajectory:
        across = np.stack([-right.com_m[:, 1], right.com_m[:, 0]], axis=-1)
        return right.replace(com_velocity_m_s=right.com_velocity_m_s - rate(scene, right) * across)

    return read


def velocity_in_local_axes(_: Scene, right: Trajectory) -> Trajectory:
    """Velocity as its radial and its transverse component."""
    longitude = np.arctan2(right.com_m[:, 1], right.com_m[:, 0])
    return right.replace(com_velocity_m_s=in_axes_at(right.com_velocity_m_s, longitude))


def first_bar(scene: Scene, right: Trajectory) -> tuple[Array, Array]:
    """Centre of the first bar, (n, 2) m and m/s."""
    place, velocity = bar_places(scene, right)
    return place[:, 0], velocity[:, 0]


def last_bar(scene: Scene, right: Trajectory) -> tuple[Array, Array]:
    """Centre of the last bar, (n, 2) m and m/s."""
    place, velocity = bar_places(scene, right)
    return place[:, -1], velocity[:, -1]


def chain_end(side: float) -> Point:
    """Left end of the first bar (-1) or right end of the last bar (+1)."""

    def point(scene: Scene, right: Trajectory) -> tuple[Array, Array]:
        assert right.angle_rad is not None
        assert right.rate_rad_s is not None
        bar = 0 if side < 0.0 else -1
        place, velocity = bar_places(scene, right)
        along, across = directions(right.angle_rad[:, bar])
        half_m = side * chain_model(scene).half_m[bar]
        return place[:, bar] + half_m * along, velocity[:, bar] + half_m * right.rate_rad_s[:, bar, None] * across

    return point


def unweighted_centre(scene: Scene, right: Trajectory) -> tuple[Array, Array]:
    """Mean of the bars' centres without weights, (n, 2) m and m/s."""
    place, velocity = bar_places(scene, right)
    return place.mean(axis=1), velocity.mean(axis=1)


def of_point(point: Point, *, position: bool = True, velocity: bool = True) -> ReadingChange:
    """Positions, velocities, or both, of another point than the centre of mass."""

    def read(scene: Scene, right: Trajectory) -> Trajectory:
        if right.angle_rad is None or right.rate_rad_s is None:
            return right
        com_m, com_velocity_m_s = point(scene, right)
        return right.replace(
            com_m=com_m if position else right.com_m,
            com_velocity_m_s=com_velocity_m_s if velocity else right.com_velocity_m_s,
        )

    return read


POINTS: tuple[tuple[str, str, Point], ...] = (
    ("first-bar", "the first bar's centre", first_bar),
    ("last-bar", "the last bar's centre", last_bar),
    ("left-end", "the chain's left end", chain_end(-1.0)),
    ("right-end", "the chain's right end", chain_end(1.0)),
    ("unweighted-centre", "the bars' centres without their masses", unweighted_centre),
)
MISTAKES = (
    ReadingMistake(
        "centre-of-mass-from-start",
        "the positions of the centre of mass count from the first sample",
        "centre-of-mass",
        from_start_position,
    ),
    ReadingMistake(
        "velocity-from-start",
        "the velocities of the centre of mass are relative to the first sample",
        "centre-of-mass",
        from_start_velocity,
    ),
    ReadingMistake(
        "track-from-start",
        "the centre of mass and its velocity are relative to the first sample",
        "centre-of-mass",
        from_start_track,
    ),
    ReadingMistake(
        "velocity-in-rotating-axes",
        "the velocities are relative to axes that turn with the orbit",
        "centre-of-mass",
        rotating_velocity(longitude_rate_rad_s),
    ),
    ReadingMistake(
        "velocity-in-radial-axes",
        "the velocity is given by its radial and transverse components",
        "centre-of-mass",
        velocity_in_local_axes,
    ),
    *(
        ReadingMistake(f"track-of-{name}", f"the track is that of {what}", "centre-of-mass", of_point(point))
        for name, what, point in POINTS
    ),
    *(
        ReadingMistake(
            f"position-of-{name}", f"the positions alone are those of {what}", "centre-of-mass",
            of_point(point, velocity=False),
        )
        for name, what, point in POINTS
    ),
    *(
        ReadingMistake(
            f"velocity-of-{name}", f"the velocities alone are those of {what}", "centre-of-mass",
            of_point(point, position=False),
        )
        for name, what, point in POINTS
    ),
)  # fmt: skip
