"""Axes of Exudyn's coordinates, and the transformation to inertial axes.

Three frames: one that follows the chain's Kepler orbit and rotates with its radius (x outwards, y along the motion),
one in uniform motion where there is no gravity, and the inertial axes of the central body.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from adapters.exudyn.frames.orbit import KeplerOrbit
from scenarios import Gravity

if TYPE_CHECKING:
    from adapters.trajectory import Array
    from scenarios import Scene


@dataclass(frozen=True)
class FrameAxes:
    """A frame at n instants."""

    origin_m: Array
    """(n, 2) in inertial axes"""
    origin_velocity_m_s: Array
    """(n, 2) in inertial axes"""
    turn_rad: Array
    """(n,) angle of the frame's x axis from z1, unwrapped"""
    rate_rad_s: Array
    """(n,)"""
    longitude_rad: Array
    """(n,) longitude on the Kepler (or uniform) orbit, unwrapped; each bar's own longitude is near it"""

    def to_inertial(self, vector: Array) -> Array:
        """Components in inertial axes of (n, k, 2) vectors given in the frame's."""
        return turned(vector, self.turn_rad[:, None])

    def to_frame(self, vector: Array) -> Array:
        """Components in the frame's axes of (n, k, 2) vectors given in inertial ones."""
        return turned(vector, -self.turn_rad[:, None])

    def relative(self, position_m: Array, velocity_m_s: Array) -> tuple[Array, Array]:
        """Position and velocity in the frame of (n, k, 2) offsets from the origin, given in inertial axes."""
        readings = self.to_frame(position_m)
        return readings, self.to_frame(velocity_m_s) - self.rate_rad_s[:, None, None] * perpendicular(readings)

    def inertial_velocity(self, position_m: Array, velocity_m_s: Array) -> Array:
        """Velocity relative to the origin, in inertial axes, of (n, k, 2) in the frame."""
        return self.to_inertial(velocity_m_s + self.rate_rad_s[:, None, None] * perpendicular(position_m))


def turned(vector: Array, angle_rad: Array) -> Array:
    """Plane vectors (..., 2) rotated by angles (...)."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    x, y = vector[..., 0], vector[..., 1]
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


def perpendicular(vector: Array) -> Array:
    """Plane vectors (..., 2) rotated by +90 degrees."""
    return np.stack([-vector[..., 1], vector[..., 0]], axis=-1)


class ReferenceFrame(ABC):
    """Axes as functions of time."""

    @abstractmethod
    def at(self, t_s: Array) -> FrameAxes:
        """Axes at the instants `t_s`, (n,)."""


@final
class OrbitFrame(ReferenceFrame):
    """Rotating axes on the Kepler orbit of the chain's initial centre of mass."""

    def __init__(self, orbit: KeplerOrbit) -> None:
        self.orbit = orbit

    def at(self, t_s: Array) -> FrameAxes:
        """Axes along the radius."""
        track = self.orbit.at(t_s)
        along = np.stack([track.radius_m, np.zeros_like(track.radius_m)], axis=-1)
        motion = np.stack([track.radial_velocity_m_s, track.radius_m * track.rate_rad_s], axis=-1)
        turn = track.longitude_rad
        return FrameAxes(turned(along, turn), turned(motion, turn), turn, track.rate_rad_s, turn)


@final
class UniformFrame(ReferenceFrame):
    """Non-rotating axes that move with the chain's centre of mass where there is no gravity."""

    def __init__(self, radius_m: float, speed_m_s: float, longitude_rad: float) -> None:
        self.radius_m, self.speed_m_s, self.longitude_rad = radius_m, speed_m_s, longitude_rad

    def at(self, t_s: Array) -> FrameAxes:
        """Axes parallel to the inertial ones."""
        zero = np.zeros_like(t_s)
        start = np.stack([zero + self.radius_m, self.speed_m_s * t_s], axis=-1)
        speed = np.stack([zero, zero + self.speed_m_s], axis=-1)
        longitude = self.longitude_rad + np.arctan2(start[:, 1], start[:, 0])
        return FrameAxes(
            turned(start, zero + self.longitude_rad),
            turned(speed, zero + self.longitude_rad),
            zero,
            zero,
            longitude,
        )


@final
class FixedFrame(ReferenceFrame):
    """Inertial axes; the orbit only serves to unwrap longitudes."""

    def __init__(self, track: ReferenceFrame) -> None:
        self.track = track

    def at(self, t_s: Array) -> FrameAxes:
        """Axes at rest in the centre of the body."""
        zero, still = np.zeros_like(t_s), np.zeros((len(t_s), 2))
        return FrameAxes(still, still, zero, zero, self.track.at(t_s).longitude_rad)


def orbit_of(scene: Scene) -> KeplerOrbit:
    """Kepler orbit of the chain's initial centre of mass."""
    return KeplerOrbit(
        scene.central_body.mu_m3_s2, scene.radius0_m, scene.orbit.speed_factor, scene.orbit.longitude_rad
    )


def moving_frame(scene: Scene) -> OrbitFrame | UniformFrame:
    """Frame that follows the chain's centre of mass."""
    if scene.effects.gravity is Gravity.NONE:
        return UniformFrame(scene.radius0_m, scene.speed0_m_s, scene.orbit.longitude_rad)
    return OrbitFrame(orbit_of(scene))


def frame_of(scene: Scene, *, absolute: bool) -> ReferenceFrame:
    """Frame of a scene."""
    follower = moving_frame(scene)
    return FixedFrame(follower) if absolute else follower
