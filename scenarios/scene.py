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

import numpy as np
from numpy.typing import NDArray

from scenarios.forces import Effects, Gravity

Array = NDArray[np.float64]


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
        return max(2.0 * math.pi / self.step_period_s, turning, self.spring_rate_rad_s, *slews)

    @property
    def spring_rate_rad_s(self) -> float:
        """Bound of the joint springs' own fastest oscillation, and of the dampers' decay; 0 where there are none.

        The bars' turning alone, joints left out, is a chain of springs between inertias: its matrix has no eigenvalue
        above twice the largest of sum k/J over a bar's joints. Joints only add inertia.
        """
        springs = self.effects.joint_spring_damper
        if springs is None:
            return 0.0

        def largest(each: tuple[float, ...]) -> float:
            beside = [a + b for a, b in zip((0.0, *each), (*each, 0.0), strict=True)]
            return 2.0 * max(k / j for k, j in zip(beside, self.chain.inertia_kg_m2, strict=True))

        return max(math.sqrt(largest(springs.stiffness_N_m_rad)), largest(springs.damping_N_m_s_rad))

    @property
    def times_s(self) -> Array:
        """Sample instants, shape (samples,)."""
        return np.linspace(0.0, self.run.duration_s, self.run.samples)

    @property
    def digest(self) -> str:
        """Hash of the physics (not of the name, title, tags): equal for scenes that must run equally."""
        return self.digest_of("central_body", "orbit", "chain", "effects", "run")

    def digest_of(self, *parts: str) -> str:
        """Hash of some parts; effects that the scene does not call for are not in it, whatever effects there are."""
        physics = {k: dataclasses.asdict(getattr(self, k)) for k in parts}
        if "effects" in physics:
            called = physics["effects"]
            always = ("gravity", "prescribed_rotation")
            physics["effects"] = {k: v for k, v in called.items() if v or k in always}
        return hashlib.sha256(json.dumps(physics, sort_keys=True).encode()).hexdigest()[:16]
