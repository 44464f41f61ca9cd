"""The scene: what is simulated, in SI units and radians, the same for every engine.

A :class:`Scene` holds physics only. It is made from a TOML file by
:func:`scenarios.load.load_scene`, which validates it; here everything is already
complete: one value per bar, defaults filled in, degrees turned into radians.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Gravity(StrEnum):
    """How the central body pulls on a bar."""

    NONE = "none"
    """No gravity: the centre of mass moves uniformly."""
    POINT = "point"
    """A point mass at the bar's centre of mass, no torque."""
    GRADIENT = "gradient"
    """The paper's: the point-mass force, and the gravity-gradient torque of eq. (17)."""


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


@dataclass(frozen=True)
class CentralBody:
    """The body orbited."""

    mu_m3_s2: float
    radius_m: float


@dataclass(frozen=True)
class Orbit:
    """Injection of the chain's centre of mass; its velocity is horizontal, counter-clockwise."""

    altitude_m: float
    speed_factor: float
    """The paper's beta: speed over the local circular speed."""
    longitude_rad: float


@dataclass(frozen=True)
class Chain:
    """The bars, first to last; every tuple has one value per bar."""

    mass_kg: tuple[float, ...]
    length_m: tuple[float, ...]
    inertia_kg_m2: tuple[float, ...]
    """About the bar's own centre of mass."""
    angle_rad: tuple[float, ...]
    """From the horizontal that `angle_from` names."""
    angle_from: str
    """"chain": the horizontal through the chain's centre of mass; "bar": through each bar's own."""
    rate_factor: tuple[float, ...]
    """The paper's alpha: initial inertial rate over v0/r0."""

    @property
    def bars(self) -> int:
        """Number of bars N."""
        return len(self.mass_kg)


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
class Effects:
    """The physical effects this scene calls for; nothing else acts."""

    gravity: Gravity
    prescribed_rotation: tuple[PrescribedRotation, ...] = ()

    @property
    def names(self) -> frozenset[str]:
        """Names by which an engine declares what it can carry, e.g. ``gravity.gradient``."""
        found = {f"gravity.{self.gravity}"}
        for p in self.prescribed_rotation:
            found |= {f"prescribed_rotation.{p.frame}", f"prescribed_rotation.{p.actuator}"}
        return frozenset(found)


@dataclass(frozen=True)
class Run:
    """How long, and at how many equally spaced instants (both ends included) the motion is seen."""

    duration_s: float
    samples: int


@dataclass(frozen=True)
class Scene:
    """A complete, validated problem."""

    name: str
    title: str
    source: str
    description: str
    tags: tuple[str, ...]
    central_body: CentralBody
    orbit: Orbit
    chain: Chain
    effects: Effects
    run: Run

    @property
    def bars(self) -> int:
        """Number of bars N."""
        return self.chain.bars

    @property
    def mass_kg(self) -> float:
        """Mass of the whole chain."""
        return math.fsum(self.chain.mass_kg)

    @property
    def size_m(self) -> float:
        """Length of the whole chain, stretched."""
        return math.fsum(self.chain.length_m)

    @property
    def radius0_m(self) -> float:
        """Initial distance r0 of the centre of mass from the centre of the body."""
        return self.central_body.radius_m + self.orbit.altitude_m

    @property
    def speed0_m_s(self) -> float:
        """Initial speed v0 of the centre of mass."""
        return self.orbit.speed_factor * math.sqrt(self.central_body.mu_m3_s2 / self.radius0_m)

    @property
    def orbital_rate_rad_s(self) -> float:
        """Rate v0/r0, the unit of `rate_factor`."""
        return self.speed0_m_s / self.radius0_m

    @property
    def mean_motion_rad_s(self) -> float:
        """Mean motion of the osculating orbit if bound; of the circular orbit at r0 if not."""
        return 2.0 * math.pi / self.period_s

    @property
    def bound(self) -> bool:
        """Whether the osculating orbit at t = 0 is an ellipse."""
        return self.effects.gravity is not Gravity.NONE and self.orbit.speed_factor**2 < 2.0

    @property
    def period_s(self) -> float:
        """Period of the osculating orbit at t = 0; of the circular orbit at r0 where that is not bound.

        It is the unit in which plots count time.
        """
        r0 = self.radius0_m
        semi_major_m = r0 / (2.0 - self.orbit.speed_factor**2) if self.bound else r0
        return 2.0 * math.pi * math.sqrt(semi_major_m**3 / self.central_body.mu_m3_s2)

    @property
    def step_period_s(self) -> float:
        """Unit in which `steps_per_orbit` counts: the period, or that of the circular orbit at r0 if shorter.

        On an eccentric orbit perigee needs the steps, and a nearly parabolic one has next to no period.
        """
        circular_s = 2.0 * math.pi * math.sqrt(self.radius0_m**3 / self.central_body.mu_m3_s2)
        return min(self.period_s, circular_s)

    @property
    def fastest_rate_rad_s(self) -> float:
        """Largest of the orbital, the circular and the bars' initial rates, and of the manoeuvres' own."""
        turning = max(1.0, *(abs(a) for a in self.chain.rate_factor)) * self.orbital_rate_rad_s
        slews = [math.pi / p.duration_s for p in self.effects.prescribed_rotation]
        return max(2.0 * math.pi / self.step_period_s, turning, *slews)

    @property
    def times_s(self) -> Array:
        """Sample instants, shape (samples,)."""
        return np.linspace(0.0, self.run.duration_s, self.run.samples)

    @property
    def digest(self) -> str:
        """Hash of the physics (not of the name, title, tags): equal for scenes that must run equally."""
        physics = {
            k: dataclasses.asdict(getattr(self, k)) for k in ("central_body", "orbit", "chain", "effects", "run")
        }
        return hashlib.sha256(json.dumps(physics, sort_keys=True).encode()).hexdigest()[:16]
