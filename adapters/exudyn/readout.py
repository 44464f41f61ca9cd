"""Trajectory in inertial axes from Exudyn's coordinates in the frame's axes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from adapters.trajectory import Trajectory

if TYPE_CHECKING:
    from adapters.exudyn.frames import FrameAxes
    from adapters.trajectory import Array
    from scenarios import Scene


@dataclass(frozen=True)
class SensorReadings:
    """Readings of the sensors at n samples, in the frame's axes."""

    position_m: Array
    """(n, N, 2)"""
    velocity_m_s: Array
    """(n, N, 2)"""
    angle_rad: Array
    """(n, N)"""
    rate_rad_s: Array
    """(n, N)"""
    reaction_N: Array
    """(n, N-1, 2) force on bar j from bar j+1"""
    torque_N_m: Array
    """(n, P)"""

    def first(self, n: int) -> SensorReadings:
        """The first `n` samples."""
        return SensorReadings(*(getattr(self, name)[:n] for name in self.__dataclass_fields__))

    @property
    def finite(self) -> Array:
        """(n,) whether all readings of a sample are finite."""
        parts = [getattr(self, name) for name in self.__dataclass_fields__]
        good: Array = np.all([np.isfinite(p).reshape(len(p), -1).all(axis=1) for p in parts], axis=0)
        return good


def landing(scene: Scene, axes: FrameAxes, readings: SensorReadings) -> int | None:
    """Index of the first sample with a point of a bar below the surface; None if there is none.

    Exudyn does not stop at the surface, and the samples below it have no meaning.
    """
    with np.errstate(invalid="ignore", over="ignore"):  # numbers below the surface may overflow
        below = np.flatnonzero(least_distance(scene, axes, readings) <= scene.central_body.radius_m)
    return int(below[0]) if len(below) else None


def least_distance(scene: Scene, axes: FrameAxes, readings: SensorReadings) -> Array:
    """Distance of the nearest point of any bar from the centre of the body, (n,), m."""
    position = axes.origin_m[:, None] + axes.to_inertial(readings.position_m)
    angle = readings.angle_rad + axes.turn_rad[:, None]
    along = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    # nearest point of the bar, from its centre
    foot = np.clip(-np.sum(position * along, axis=-1), -np.array(scene.chain.left_m), np.array(scene.chain.right_m))
    distance: Array = np.linalg.norm(position + foot[..., None] * along, axis=-1).min(axis=-1)
    return distance


def gaps(scene: Scene, readings: SensorReadings) -> Array:
    """Distance between the two bar ends at each joint, (n, N-1), m, in Exudyn's own coordinates."""
    along = np.stack([np.cos(readings.angle_rad), np.sin(readings.angle_rad)], axis=-1)
    left, right = (np.array(lever_m)[:, None] * along for lever_m in (scene.chain.left_m, scene.chain.right_m))
    between = np.diff(readings.position_m, axis=1) - left[:, 1:] - right[:, :-1]
    distance: Array = np.linalg.norm(between, axis=-1)
    return distance


def weights(scene: Scene) -> Array:
    """Each bar's mass over the chain's, (N,)."""
    share: Array = np.array(scene.chain.mass_kg) / scene.mass_kg
    return share


def positions(scene: Scene, axes: FrameAxes, readings: SensorReadings) -> Array:
    """Centres of the bars relative to the chain's centre of mass, (n, N, 2), m, inertial axes.

    The subtraction precedes the rotation: a rotation rounds its argument, and the frame's origin may be far away.
    """
    com = np.einsum("j,njk->nk", weights(scene), readings.position_m)
    return axes.to_inertial(readings.position_m - com[:, None])


def trajectory(
    scene: Scene, axes: FrameAxes, readings: SensorReadings, *, ended: str, info: dict[str, float | str]
) -> Trajectory:
    """Trajectory of the samples in `readings`; engines whose joints can open add gaps and positions."""
    weight = weights(scene)
    position = axes.to_inertial(readings.position_m)
    motion = axes.inertial_velocity(readings.position_m, readings.velocity_m_s)
    return Trajectory(
        t_s=scene.times_s[: len(readings.angle_rad)],
        com_m=axes.origin_m + np.einsum("j,njk->nk", weight, position),
        com_velocity_m_s=axes.origin_velocity_m_s + np.einsum("j,njk->nk", weight, motion),
        angle_rad=readings.angle_rad + axes.turn_rad[:, None],
        rate_rad_s=readings.rate_rad_s + axes.rate_rad_s[:, None],
        reaction_N=axes.to_inertial(readings.reaction_N),
        torque_N_m=readings.torque_N_m,
        ended=ended,
        info=info,
    )
