"""What acts on a chain besides its joints: one frozen dataclass for each effect, in SI units and radians."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from enum import StrEnum


class Gravity(StrEnum):
    """How the central body pulls on a bar."""

    NONE = "none"
    """No gravity: the centre of mass moves uniformly."""
    POINT = "point"
    """A point mass at the bar's centre of mass, no torque."""
    GRADIENT = "gradient"
    """The paper's: the point-mass force, and the gravity-gradient torque of eq. (17)."""
    QUADRUPOLE = "quadrupole"
    """The potential to the bar's second moment: force and torque belong together."""
    SLENDER = "slender"
    """The exact pull on a uniform slender bar."""

    @property
    def turns(self) -> bool:
        """Whether a field's gradient turns a bar."""
        return self in (Gravity.GRADIENT, Gravity.QUADRUPOLE, Gravity.SLENDER)

    @property
    def has_potential(self) -> bool:
        """Whether forces and torques come from one potential."""
        return self is not Gravity.GRADIENT


class Frame(StrEnum):
    """Against what a prescribed angle is measured."""

    INERTIAL = "inertial"
    LOCAL_HORIZONTAL = "local_horizontal"
    """The horizontal through the bar's own centre of mass (the paper's phi)."""


class Actuator(StrEnum):
    """What exerts the torque of a prescribed rotation."""

    EXTERNAL = "external"
    """From outside, on the bar alone (the paper's Fig. 18)."""
    JOINT = "joint"
    """A motor in the joint to the bar before it (for bar 1, to bar 2): equal and opposite on that neighbour."""


class End(StrEnum):
    """An end of a bar."""

    LEFT = "left"
    """Where the bar before it is tied."""
    RIGHT = "right"
    """Where the next bar is tied."""

    @property
    def sign(self) -> float:
        """Side of the bar's centre along its own direction."""
        return 1.0 if self is End.RIGHT else -1.0


class Axes(StrEnum):
    """Axes in which the direction of a thrust is given."""

    BODY = "body"
    """From the bar's own direction: it turns with the bar."""
    INERTIAL = "inertial"
    """From the z1 axis."""


@dataclass(frozen=True)
class PrescribedRotation:
    """Bar `bar` follows the law of eq. (28): held, turned by `amplitude_rad` in `duration_s`, held."""

    bar: int
    """Counted from 1, as in the paper."""
    amplitude_rad: float
    duration_s: float
    start_s: float
    frame: Frame
    actuator: Actuator

    @property
    def breaks_s(self) -> tuple[float, float]:
        """Start and end: a high derivative jumps there."""
        return self.start_s, self.start_s + self.duration_s

    def law(self, t_s: float) -> tuple[float, float, float]:
        """Angle gained since the start (rad), its rate (rad/s) and acceleration (rad/s²), eq. (28)."""
        s = (t_s - self.start_s) / self.duration_s
        if s <= 0.0:
            return 0.0, 0.0, 0.0
        if s >= 1.0:
            return self.amplitude_rad, 0.0, 0.0
        a, w, x = self.amplitude_rad / 16.0, math.pi / self.duration_s, math.pi * s
        return (
            a * (math.cos(3 * x) - 9 * math.cos(x) + 8),
            a * w * (9 * math.sin(x) - 3 * math.sin(3 * x)),
            a * w * w * (9 * math.cos(x) - 9 * math.cos(3 * x)),
        )


@dataclass(frozen=True)
class Oblateness:
    """The central body's flattening, seen in its equatorial plane."""

    j2: float
    radius_m: float
    """To which `j2` belongs"""


@dataclass(frozen=True)
class ThirdBody:
    """A point mass on a circular orbit about the centre, in the plane of motion."""

    name: str
    mu_m3_s2: float
    distance_m: float
    longitude_rad: float
    """At t = 0, from the z1 axis"""
    rate_rad_s: float
    """Counter-clockwise, of its longitude"""


@dataclass(frozen=True)
class Drag:
    """Free-molecular drag in an exponential atmosphere that turns with the central body."""

    density_kg_m3: float
    """At `altitude_m`"""
    altitude_m: float
    """Above the surface of the central body"""
    scale_height_m: float
    rotation_rad_s: float
    """Of the atmosphere, counter-clockwise"""
    width_m: tuple[float, ...]
    """(N,)"""
    normal_coefficient: float
    tangential_coefficient: float


@dataclass(frozen=True)
class SolarPressure:
    """Sunlight on flat bars, each turned about its own line to face the Sun as well as it can."""

    pressure_Pa: float
    """On a black surface that faces the Sun"""
    sun_longitude_rad: float
    """Direction to the Sun at t = 0, from the z1 axis"""
    sun_rate_rad_s: float
    """Counter-clockwise, of that direction"""
    width_m: tuple[float, ...]
    """(N,)"""
    reflectivity: float
    """Share of the light that is reflected as by a mirror; the rest is absorbed"""
    shadow: bool
    """Whether the central body's cylindrical shadow darkens the chain while its centre of mass is in it"""


@dataclass(frozen=True)
class JointSpringDamper:
    """A rotational spring and damper in every joint; every tuple has one value per joint."""

    stiffness_N_m_rad: tuple[float, ...]
    damping_N_m_s_rad: tuple[float, ...]
    rest_rad: tuple[float, ...]
    """Angle of bar j+1 less that of bar j at which the spring is at rest"""


@dataclass(frozen=True)
class Thrust:
    """A force on one end of a bar, its size piecewise linear in time and zero outside."""

    bar: int
    """Counted from 1"""
    end: End
    axes: Axes
    direction_rad: float
    """From the bar's direction, or from the z1 axis"""
    times_s: tuple[float, ...]
    """Instants of the table; the force jumps at the first and the last"""
    force_N: tuple[float, ...]
    """Size at those instants"""

    @property
    def breaks_s(self) -> tuple[float, ...]:
        """Where it jumps, or its slope does."""
        return self.times_s

    def size_N(self, t_s: float) -> float:
        """Size at an instant; at the very first and last instants what it is inside."""
        for (t0, f0), (t1, f1) in itertools.pairwise(zip(self.times_s, self.force_N, strict=True)):
            if t0 <= t_s <= t1:
                return f0 + (f1 - f0) * ((t_s - t0) / (t1 - t0))
        return 0.0


@dataclass(frozen=True)
class Impulse:
    """A blow on one end of a bar at an instant."""

    bar: int
    """Counted from 1"""
    end: End
    axes: Axes
    direction_rad: float
    impulse_N_s: float
    at_s: float


@dataclass(frozen=True)
class Effects:
    """The physical effects this scene calls for; nothing else acts."""

    gravity: Gravity
    prescribed_rotation: tuple[PrescribedRotation, ...] = ()
    oblateness: Oblateness | None = None
    third_body: tuple[ThirdBody, ...] = ()
    drag: Drag | None = None
    solar_pressure: SolarPressure | None = None
    joint_spring_damper: JointSpringDamper | None = None
    thrust: tuple[Thrust, ...] = ()
    impulse: tuple[Impulse, ...] = ()

    @property
    def names(self) -> frozenset[str]:
        """Names by which an engine declares what it can carry, e.g. ``gravity.gradient``."""
        found = {f"gravity.{self.gravity}"}
        for p in self.prescribed_rotation:
            found |= {f"prescribed_rotation.{p.frame}", f"prescribed_rotation.{p.actuator}"}
        found |= {name for name in SIMPLE if getattr(self, name)}
        if self.solar_pressure and self.solar_pressure.shadow:
            found.add("solar_pressure.shadow")
        found |= {f"thrust.{thrust.axes}" for thrust in self.thrust}
        return frozenset(found)

    @property
    def breaks_s(self) -> tuple[float, ...]:
        """Instants at which what acts is not smooth in time: no step may straddle them; increasing."""
        found = {t for law in self.prescribed_rotation for t in law.breaks_s}
        found |= {t for thrust in self.thrust for t in thrust.breaks_s}
        return tuple(sorted(found | {p.at_s for p in self.impulse}))

    @property
    def more(self) -> bool:
        """Whether anything acts besides point or gradient gravity and prescribed rotations."""
        return any(getattr(self, name) for name in (*SIMPLE, "thrust")) or self.gravity in NEWER


SIMPLE = ("oblateness", "third_body", "drag", "solar_pressure", "joint_spring_damper", "impulse")
NEWER = (Gravity.QUADRUPOLE, Gravity.SLENDER)
