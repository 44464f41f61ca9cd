"""Frames of Exudyn's coordinates: their motion, the transformation to inertial axes, and a bar's motion in them.

Three frames: one that follows the chain's Kepler orbit and rotates with its radius (x outwards, y along the motion),
one in uniform motion where there is no gravity, and the inertial axes of the central body.

Numbers in the loads' expressions are floats, arrays, or Exudyn's symbolic numbers: all have the same arithmetic.
"""

from __future__ import annotations

import dataclasses
import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, final

import numpy as np

from adapters.common.kepler import universal_anomaly, universal_functions
from scenarios import Gravity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.trajectory import Array
    from scenarios import Scene
    from scenarios.scene import Orbit

Number = Any


@dataclass(frozen=True)
class BarMotion:
    """Position and motion of a bar in a frame's axes: from the frame's origin, or from the body and inertial."""

    x_m: Number
    y_m: Number
    vx_m_s: Number
    vy_m_s: Number
    cosine: Number
    """of the bar's angle from the frame's x axis"""
    sine: Number
    rate_rad_s: Number = 0.0

    @property
    def square_m2(self) -> Number:
        """|Z|²."""
        return self.x_m * self.x_m + self.y_m * self.y_m

    @property
    def along_m(self) -> Number:
        """P = u·Z."""
        return self.cosine * self.x_m + self.sine * self.y_m

    @property
    def across_m(self) -> Number:
        """Q = n·Z."""
        return self.cosine * self.y_m - self.sine * self.x_m

    def to_frame(self, along: Number, across: Number) -> tuple[Number, Number]:
        """Components in the frame's axes of a vector given along the bar and across it."""
        return self.cosine * along - self.sine * across, self.sine * along + self.cosine * across

    def to_bar(self, x: Number, y: Number) -> tuple[Number, Number]:
        """Components along the bar and across it of a vector given in the frame's axes."""
        return self.cosine * x + self.sine * y, self.cosine * y - self.sine * x

    def relative_to(self, x_m: Number, y_m: Number) -> BarMotion:
        """The same motion with its position from another point."""
        return dataclasses.replace(self, x_m=self.x_m - x_m, y_m=self.y_m - y_m)


@dataclass(frozen=True)
class OrbitNumbers:
    """The orbit at an instant, or at n of them, in polar coordinates; all but the longitude."""

    radius_m: Number
    """r"""
    rate_rad_s: Number
    """omega, rate of the longitude"""
    spin_up_rad_s2: Number
    """omega' = -2 r' omega/r"""
    pull_s2: Number
    """mu/r³, 1/s²"""
    shape: Number
    """e cos f = omega² r³/mu - 1, without the cancellation"""
    radial_velocity_m_s: Number = None
    """r'; None on a circular orbit"""


@dataclass(frozen=True)
class KeplerOrbit:
    """Kepler's orbit of a point.

    The closed form of :mod:`adapters.common.kepler`, with lengths in units of the initial radius r0 and times in units
    of sqrt(r0³/mu). The initial velocity is h across the radius and sigma along it. With kappa = beta² - 1 (at an
    apsis the eccentricity, negative for the apogee) and alpha = 2 - beta², the universal functions s = G1 and c = G2
    of alpha give

        r = 1 + kappa c + sigma s,   x = 1 - c + sigma (s + sigma c),   y = h (s + sigma c).
    """

    mu_m3_s2: float
    radius0_m: float
    start: Orbit

    @property
    def circular(self) -> bool:
        """Whether every number but the longitude is constant."""
        return self.start.eccentricity == 0.0

    def at(self, t_s: Array) -> tuple[OrbitNumbers, Array]:
        """Orbit at the instants `t_s`, (n,), and its longitude, (n,) rad, unwrapped."""
        unit_s = math.sqrt(self.radius0_m**3 / self.mu_m3_s2)
        beta, h, sigma = self.start.speed_factor, self.start.onward, self.start.upward
        kappa = (beta - 1.0) * (beta + 1.0)  # a product keeps the digits of a nearly circular orbit
        alpha = 1.0 - kappa
        tau = np.asarray(t_s, dtype=float) / unit_s
        turns = np.zeros_like(tau)
        if alpha > 0.0:
            period = 2.0 * math.pi / alpha**1.5
            turns = np.round(tau / period)
            tau = tau - turns * period
        g0, s, c, _ = universal_functions(alpha, universal_anomaly(1.0, 1.0, sigma, alpha, tau))
        along = s + sigma * c
        with np.errstate(divide="ignore", invalid="ignore"):  # a radial fall reaches r = 0, below the surface
            r = 1.0 + kappa * c + sigma * s
            climb, rate = (kappa * s + sigma * g0) / r, h / r**2
            numbers = OrbitNumbers(
                radius_m=self.radius0_m * r,
                rate_rad_s=rate / unit_s,
                spin_up_rad_s2=-2.0 * climb * rate / r / unit_s**2,
                pull_s2=1.0 / (r**3 * unit_s**2),
                shape=(kappa * (1.0 - c) - sigma * (sigma + s)) / r,
                radial_velocity_m_s=self.radius0_m / unit_s * climb,
            )
            turned_rad = turned_from_start(h * along, 1.0 - c + sigma * along, tau)
            return numbers, self.start.longitude_rad + 2.0 * math.pi * turns + turned_rad


def turned_from_start(y: Array, x: Array, tau: Array) -> Array:
    """Angle of (x, y) from the start, with the sign of `tau`: less than a revolution within half a period.

    Half a revolution after the start, round-off in y must not decide the sign.
    """
    angle = np.arctan2(y, x)
    wrong = angle * tau < 0.0
    unwrapped: Array = np.where(wrong, angle + 2.0 * math.pi * np.sign(tau), angle)
    return unwrapped


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
    """Axes as functions of time, and a bar's inertial motion in them."""

    time_input_count = 0
    """Number of quantities of the frame in the loads' expressions that depend on time alone"""

    @abstractmethod
    def at(self, t_s: Array) -> FrameAxes:
        """Axes at the instants `t_s`, (n,)."""

    def time_inputs(self, at_s: Array, inside_s: Array) -> Array:
        """Values of the time inputs, see :data:`adapters.exudyn.time_inputs.TimeInputs`."""
        del inside_s
        return np.empty((len(at_s), 0))

    @abstractmethod
    def inertial(self, m: BarMotion, inputs: Sequence[Number]) -> BarMotion:
        """Position from the centre of the body and inertial motion of a bar, from its motion in the frame."""


@final
class OrbitFrame(ReferenceFrame):
    """Rotating axes on the Kepler orbit of the chain's initial centre of mass.

    Kepler's equation has no closed solution. Exudyn evaluates a symbolic expression once for each occurrence, so that
    the cost of an unrolled Newton iteration would triple with every iteration. The exact orbit is therefore tabulated
    when the model is built, see :mod:`adapters.exudyn.time_inputs`; on a circular orbit its numbers are constants.
    """

    def __init__(self, orbit: KeplerOrbit) -> None:
        """Axes on `orbit`."""
        self.orbit = orbit
        self.time_input_count = 0 if orbit.circular else len(dataclasses.fields(OrbitNumbers))

    def at(self, t_s: Array) -> FrameAxes:
        """Axes along the radius."""
        track, turn = self.orbit.at(t_s)
        along = np.stack([track.radius_m, np.zeros_like(track.radius_m)], axis=-1)
        motion = np.stack([track.radial_velocity_m_s, track.radius_m * track.rate_rad_s], axis=-1)
        return FrameAxes(turned(along, turn), turned(motion, turn), turn, track.rate_rad_s, turn)

    def time_inputs(self, at_s: Array, inside_s: Array) -> Array:
        """The orbit's numbers."""
        if self.orbit.circular:
            return super().time_inputs(at_s, inside_s)
        return np.stack(dataclasses.astuple(self.orbit.at(at_s)[0]), axis=1)

    def numbers(self, inputs: Sequence[Number]) -> OrbitNumbers:
        """The orbit in the loads' expressions."""
        if not self.orbit.circular:
            return OrbitNumbers(*inputs)
        first = [float(value[0]) for value in dataclasses.astuple(self.orbit.at(np.zeros(1))[0])]
        return OrbitNumbers(*first[:-1])

    def inertial(self, m: BarMotion, inputs: Sequence[Number]) -> BarMotion:
        """Position (r + x, y), and its rate in rotating axes."""
        orbit = self.numbers(inputs)
        w, x, y, climb = orbit.rate_rad_s, orbit.radius_m + m.x_m, m.y_m, orbit.radial_velocity_m_s
        vx = m.vx_m_s - w * y
        return BarMotion(
            x, y, vx if climb is None else climb + vx, m.vy_m_s + w * x, m.cosine, m.sine, m.rate_rad_s + w
        )


@final
class UniformFrame(ReferenceFrame):
    """Non-rotating axes that move with the chain's centre of mass where there is no gravity."""

    time_input_count = 2

    def __init__(self, radius_m: float, climb_m_s: float, onward_m_s: float, longitude_rad: float) -> None:
        """Axes of a point with a radial and a horizontal velocity at the start."""
        self.radius_m, self.climb_m_s, self.onward_m_s = radius_m, climb_m_s, onward_m_s
        self.longitude_rad = longitude_rad

    def at(self, t_s: Array) -> FrameAxes:
        """Axes parallel to the inertial ones."""
        zero = np.zeros_like(t_s)
        start = np.stack([self.radius_m + self.climb_m_s * t_s, self.onward_m_s * t_s], axis=-1)
        speed = np.stack([zero + self.climb_m_s, zero + self.onward_m_s], axis=-1)
        longitude = self.longitude_rad + np.arctan2(start[:, 1], start[:, 0])
        return FrameAxes(
            turned(start, zero + self.longitude_rad), turned(speed, zero + self.longitude_rad), zero, zero, longitude
        )

    def time_inputs(self, at_s: Array, inside_s: Array) -> Array:
        """Position of the origin."""
        del inside_s
        return self.at(at_s).origin_m

    def inertial(self, m: BarMotion, inputs: Sequence[Number]) -> BarMotion:
        """Sum of origin and offset."""
        (x, y), (vx, vy) = inputs, self.at(np.zeros(1)).origin_velocity_m_s[0].tolist()
        return BarMotion(x + m.x_m, y + m.y_m, vx + m.vx_m_s, vy + m.vy_m_s, m.cosine, m.sine, m.rate_rad_s)


@final
class FixedFrame(ReferenceFrame):
    """Inertial axes; the orbit only serves to unwrap longitudes."""

    def __init__(self, track: ReferenceFrame) -> None:
        """Axes at rest, with the longitudes of `track`."""
        self.track = track

    def at(self, t_s: Array) -> FrameAxes:
        """Axes at rest in the centre of the body."""
        zero, still = np.zeros_like(t_s), np.zeros((len(t_s), 2))
        return FrameAxes(still, still, zero, zero, self.track.at(t_s).longitude_rad)

    def inertial(self, m: BarMotion, inputs: Sequence[Number]) -> BarMotion:
        """The bar's motion itself."""
        del inputs
        return m


def frame_of(scene: Scene, *, absolute: bool) -> ReferenceFrame:
    """Frame of a scene: inertial axes, or one that follows the chain's initial centre of mass."""
    path = scene.orbit.flight_path_rad
    if scene.effects.gravity is Gravity.NONE:
        climb, onward = scene.speed0_m_s * math.sin(path), scene.speed0_m_s * math.cos(path)
        follower: ReferenceFrame = UniformFrame(scene.radius0_m, climb, onward, scene.orbit.longitude_rad)
    else:
        follower = OrbitFrame(KeplerOrbit(scene.central_body.mu_m3_s2, scene.radius0_m, scene.orbit))
    return FixedFrame(follower) if absolute else follower


def directions_of(frame: ReferenceFrame, at_s: Array, angle_rad: Array) -> Array:
    """Unit vectors (k, 2) in the frame's axes at angles (k,) from the z1 axis."""
    angle = angle_rad - frame.at(at_s).turn_rad
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)
