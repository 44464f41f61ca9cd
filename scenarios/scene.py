"""Scene: a complete problem in SI units and radians, the same for every engine.

A :class:`Scene` holds physics only. :func:`scenarios.load.load_scene` makes and validates it from a TOML file,
:func:`scenarios.load.check_scene` validates one that was made in Python.
Every scene is complete: one value per bar, defaults filled in, degrees turned into radians.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from scenarios.effect_types import COM_SHARE, Course, Effects, Gravity
from scenarios.hooks import html, renderer
from scenarios.plural import plural
from scenarios.text import check_scene_name

if TYPE_CHECKING:
    from collections.abc import Mapping

Array = NDArray[np.float64]
ENDS = ("first", "last")
"""Ends of a chain"""


@dataclass(frozen=True)
class CentralBody:
    """Central body.

    Attributes
    ----------
    mu_m3_s2 : float
        Gravitational parameter, m³/s².
    radius_m : float
        Radius of its surface, m.
    """

    mu_m3_s2: float
    radius_m: float


@dataclass(frozen=True)
class Orbit:
    """Injection of the chain's centre of mass, counter-clockwise; at an apsis if the velocity is horizontal.

    Attributes
    ----------
    altitude_m : float
        Initial height of the centre of mass above the surface, m.
    speed_factor : float
        The paper's beta: initial speed over the local circular speed.
    longitude_rad : float
        Initial direction of the centre of mass from the z1 axis, rad.
    flight_path_rad : float
        Initial angle of the velocity above the local horizontal, rad.
    """

    altitude_m: float
    speed_factor: float
    longitude_rad: float
    flight_path_rad: float = 0.0

    @property
    def onward(self) -> float:
        """Horizontal velocity over the local circular speed."""
        return self.speed_factor * math.cos(self.flight_path_rad)

    @property
    def upward(self) -> float:
        """Radial velocity over the local circular speed."""
        return self.speed_factor * math.sin(self.flight_path_rad)

    @property
    def eccentricity(self) -> float:
        """Eccentricity of the osculating orbit at t = 0: its vector along the radius, and across it."""
        return math.hypot(self.onward**2 - 1.0, self.onward * self.upward)

    @property
    def true_anomaly_rad(self) -> float:
        """Angle of the start from the periapsis of the osculating orbit, rad; 0 on a circular orbit."""
        return math.atan2(self.onward * self.upward, self.onward**2 - 1.0)

    @property
    def mean_anomaly_rad(self) -> float:
        """Mean anomaly of the start on an ellipse, rad, by Kepler's equation from e sin E and e cos E."""
        sine = self.upward * math.sqrt(2.0 - self.speed_factor**2)
        return math.atan2(sine, self.speed_factor**2 - 1.0) - sine


@dataclass(frozen=True)
class Chain:
    """The bars, first to last; every tuple has one value per bar.

    Attributes
    ----------
    mass_kg : tuple of float
        Masses, kg.
    length_m : tuple of float
        Lengths, m.
    inertia_kg_m2 : tuple of float
        Moments of inertia about each bar's own centre of mass, kg m².
    angle_rad : tuple of float
        Initial angles from the horizontal that `angle_from` names, rad.
    angle_from : str
        ``"chain"``: the horizontal through the chain's centre of mass; ``"bar"``: through each bar's own.
    rate_factor : tuple of float
        The paper's alpha: initial inertial rate over v0/r0.
    end_bodies : tuple of str
        Ends whose bar is an end body, ``"first"``, ``"last"``: its length is twice the distance of its joint from its
        centre of mass. It moves as a bar, and is shown as a body.
    com_share : tuple of float
        Shares of the lengths from each bar's left end to its centre of mass; empty where all are midway.
    """

    mass_kg: tuple[float, ...]
    length_m: tuple[float, ...]
    inertia_kg_m2: tuple[float, ...]
    angle_rad: tuple[float, ...]
    angle_from: str
    rate_factor: tuple[float, ...]
    end_bodies: tuple[str, ...] = ()
    com_share: tuple[float, ...] = ()

    @property
    def left_m(self) -> tuple[float, ...]:
        """Distances of the bars' left ends from their centres of mass, m."""
        shares = self.com_share or (0.5,) * self.bars
        return tuple(share * length for share, length in zip(shares, self.length_m, strict=True))

    @property
    def right_m(self) -> tuple[float, ...]:
        """Distances of the bars' right ends from their centres of mass, m."""
        shares = self.com_share or (0.5,) * self.bars
        return tuple((1.0 - share) * length for share, length in zip(shares, self.length_m, strict=True))

    @property
    def bodies(self) -> tuple[int, ...]:
        """Bars that are end bodies, counted from 1."""
        return tuple(1 if end == "first" else self.bars for end in self.end_bodies)

    @property
    def bars(self) -> int:
        """Number of bars N."""
        return len(self.mass_kg)


@dataclass(frozen=True)
class Run:
    """Duration and samples of a run.

    Attributes
    ----------
    duration_s : float
        Duration, s.
    samples : int
        Number of equally spaced samples, both ends included.
    """

    duration_s: float
    samples: int

    @property
    def times_s(self) -> Array:
        """Sample instants, (samples,)."""
        return np.linspace(0.0, self.duration_s, self.samples)


@dataclass(frozen=True)
class RunAt(Run):
    """Run whose samples are at given instants, as those of a table that somebody else wrote.

    With fewer samples than instants the first ones count; with more, parts of the intervals are equally long.

    Attributes
    ----------
    instants_s : tuple of float
        Sample instants, s, increasing from 0.
    """

    instants_s: tuple[float, ...] = (0.0,)

    @property
    def times_s(self) -> Array:
        """Sample instants, (samples,)."""
        own = np.array(self.instants_s)
        if self.samples <= len(own):
            return own[: self.samples]
        between: Array = np.interp(np.linspace(0.0, len(own) - 1.0, self.samples), np.arange(len(own)), own)
        return between


def start_radius_m(body: CentralBody, orbit: Orbit) -> float:
    """Initial distance r0 of the centre of mass from the centre of the body, m."""
    return body.radius_m + orbit.altitude_m


def orbital_rate_rad_s(body: CentralBody, orbit: Orbit) -> float:
    """Initial rate of the longitude of the centre of mass, rad/s; v0/r0 from an apsis."""
    r0 = start_radius_m(body, orbit)
    return orbit.speed_factor * math.sqrt(body.mu_m3_s2 / r0) * math.cos(orbit.flight_path_rad) / r0


def is_bound(speed_factor: float, gravity: Gravity) -> bool:
    """Whether the osculating orbit at t = 0 is an ellipse."""
    return gravity is not Gravity.NONE and speed_factor**2 < 2.0


def semi_major_axis_m(body: CentralBody, orbit: Orbit) -> float:
    """Semi-major axis of a bound osculating orbit at t = 0, m."""
    return start_radius_m(body, orbit) / (2.0 - orbit.speed_factor**2)


def period_s(body: CentralBody, orbit: Orbit, gravity: Gravity) -> float:
    """Period of the osculating orbit at t = 0, s, by Kepler's third law; of the circular orbit at r0 if not bound."""
    bound = is_bound(orbit.speed_factor, gravity)
    axis_m = semi_major_axis_m(body, orbit) if bound else start_radius_m(body, orbit)
    return 2.0 * math.pi * math.sqrt(axis_m**3 / body.mu_m3_s2)


@dataclass(frozen=True)
class Scene:
    """A complete problem. A file is validated where it is loaded; a scene made in Python, where it is run.

    Attributes
    ----------
    name : str
        Name below ``scenarios/``, e.g. ``paper/fig05``, or of the file.
    title : str
        Title of pages and pictures.
    source : str
        A paper's figure, a closed form, or another origin.
    description : str
        Subject of the scene, in sentences.
    tags : tuple of str
        Words that select scenes, e.g. ``paper``.
    central_body : CentralBody
        Gravitational parameter and radius.
    orbit : Orbit
        Initial motion of the chain's centre of mass.
    chain : Chain
        Masses, lengths, inertias, initial angles and rates of the bars.
    effects : Effects
        Gravity, prescribed rotations and all other effects.
    run : Run
        Duration and samples.
    given : mapping, optional
        Tables of the scene's file, from which values that it leaves out follow; no part of the physics, so scenes are
        equal whatever it is.

    Raises
    ------
    LimitError
        If the name would lead out of a folder of results.
    """

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
    given: Mapping[str, Any] | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        """Check the name, which becomes the name of folders and files."""
        check_scene_name(self.name)

    def __repr__(self) -> str:
        """Name, size, duration and effects in one line; all values would fill a screen."""
        orbits = f"{self.run.duration_s / self.period_s:.4g}"
        lasts = f"{self.run.duration_s:.6g} s ({orbits} orbit{'' if orbits == '1' else 's'})"
        others = sorted({name.partition(".")[0] for name in self.effects.names} - {"gravity"})
        effects = ", ".join([f"gravity {self.effects.gravity}", *others])
        return f"<Scene {self.name}: {plural(self.bars, 'bar')}, {lasts}, {self.run.samples} samples; {effects}>"

    def _repr_html_(self) -> str | None:
        """Picture and physics for a notebook; None, so the text alone, before any public name of barchain is used."""
        return html("scene", self)

    @property
    def bars(self) -> int:
        """Number of bars N."""
        return self.chain.bars

    @property
    def needs(self) -> frozenset[str]:
        """Names that an engine declares to support the scene: those of its effects, and of what its bars are."""
        return self.effects.names | ({COM_SHARE} if self.chain.com_share else set())

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
        return start_radius_m(self.central_body, self.orbit)

    @property
    def speed0_m_s(self) -> float:
        """Initial speed v0 of the centre of mass."""
        return self.orbit.speed_factor * math.sqrt(self.central_body.mu_m3_s2 / self.radius0_m)

    @property
    def orbital_rate_rad_s(self) -> float:
        """Rate of the centre of mass's longitude at t = 0, the unit of `rate_factor`: v0/r0 from an apsis."""
        return orbital_rate_rad_s(self.central_body, self.orbit)

    @property
    def speed_rate_rad_s(self) -> float:
        """Initial speed over r0, which scales changes along the orbit, whatever the direction of the velocity."""
        return self.speed0_m_s / self.radius0_m

    @property
    def mean_motion_rad_s(self) -> float:
        """Mean motion of the osculating orbit if bound; of the circular orbit at r0 if not."""
        return 2.0 * math.pi / self.period_s

    @property
    def bound(self) -> bool:
        """Whether the osculating orbit at t = 0 is an ellipse."""
        return is_bound(self.orbit.speed_factor, self.effects.gravity)

    @property
    def period_s(self) -> float:
        """Period of the osculating orbit at t = 0, s; of the circular orbit at r0 if the osculating orbit is not bound.

        Plots count time in this unit.
        """
        return period_s(self.central_body, self.orbit, self.effects.gravity)

    @property
    def lowest_height_m(self) -> float:
        """Lowest height on the osculating orbit from t = 0 on above the surface, m; negative below it.

        An ellipse comes to its periapsis. On an open orbit, and without gravity on a straight path, a chain that rises
        leaves its lowest point.
        """
        return self.lowest_radius_m - self.central_body.radius_m

    @property
    def lowest_radius_m(self) -> float:
        """Least distance from the centre of the body on the osculating orbit from t = 0 on, m."""
        orbit, r0 = self.orbit, self.radius0_m
        if orbit.upward >= 0.0 and not self.bound:
            return r0
        if self.effects.gravity is Gravity.NONE:
            return r0 * math.cos(orbit.flight_path_rad)
        return min(r0, r0 * orbit.onward**2 / (1.0 + orbit.eccentricity))

    @property
    def highest_radius_m(self) -> float:
        """Distance of the osculating orbit's apoapsis from the centre of the body, m; infinite on an open path."""
        if not self.bound:
            return math.inf
        return self.radius0_m * (1.0 + self.orbit.eccentricity) / (2.0 - self.orbit.speed_factor**2)

    @property
    def step_period_s(self) -> float:
        """Unit of time of `steps_per_orbit`, s: the period, or the period of the circular orbit at r0 if shorter.

        From a perigee, the perigee needs the steps, and the period of a nearly parabolic orbit has no bound.
        """
        circular_s = 2.0 * math.pi * math.sqrt(self.radius0_m**3 / self.central_body.mu_m3_s2)
        return min(self.period_s, circular_s)

    @property
    def fastest_rate_rad_s(self) -> float:
        """Largest of the orbital, the circular, the bars' initial rates, and those of manoeuvres and end bodies."""
        turning = max(1.0, *(abs(a) for a in self.chain.rate_factor)) * self.orbital_rate_rad_s
        slews = [math.pi / turn.duration_s for p in self.effects.prescribed_rotation for turn in p.turns]
        return max(2.0 * math.pi / self.step_period_s, turning, self.spring_rate_rad_s, self.swing_rate_rad_s, *slews)

    @property
    def swing_rate_rad_s(self) -> float:
        """Rate at which an end body swings about its joint under the pull of the chain, rad/s; 0 without one.

        As a pendulum of length l, the distance of the joint, the pull T = 3 n² M L at most, with the mass M and the
        length L of all bars: (T l/J)^(1/2).
        """
        chain = self.chain
        levers = [
            (chain.right_m if bar == 1 else chain.left_m)[bar - 1] / chain.inertia_kg_m2[bar - 1]
            for bar in chain.bodies
        ]
        if not levers or self.effects.gravity is Gravity.NONE:
            return 0.0
        pull_N = 3.0 * (2.0 * math.pi / self.step_period_s) ** 2 * self.mass_kg * sum(chain.length_m)
        return math.sqrt(pull_N * max(levers))

    @property
    def spring_rate_rad_s(self) -> float:
        """Bound of the joint springs' fastest oscillation and of the dampers' decay, rad/s; 0 without either.

        Without joint forces, the bars' rotations are a chain of springs between inertias. The eigenvalues of its matrix
        are at most twice the largest of sum k/J over a bar's joints. Joints only add inertia.
        """
        springs = self.effects.joint_spring_damper
        if springs is None:
            return 0.0

        def largest(each: tuple[float, ...]) -> float:
            beside = [abs(a) + abs(b) for a, b in zip((0.0, *each), (*each, 0.0), strict=True)]
            return 2.0 * max(k / j for k, j in zip(beside, self.chain.inertia_kg_m2, strict=True))

        return max(math.sqrt(largest(springs.stiffness_N_m_rad)), largest(springs.damping_N_m_s_rad))

    @property
    def times_s(self) -> Array:
        """Sample instants, (samples,)."""
        return self.run.times_s

    def to_toml(self, path: str | Path) -> None:
        """Write the scene as a file that is read back as the same scene; its name is the file's.

        Parameters
        ----------
        path : str or Path
            A file that is there is replaced.

        Raises
        ------
        ValueError
            If an angle in the scene is no number of degrees, so that no file holds it digit for digit.
        """
        text = renderer("scene_file")
        assert text is not None
        Path(path).write_text(text(self), encoding="utf-8")

    @property
    def digest(self) -> str:
        """Hash of the physics without name, title and tags: equal for scenes that must run equally."""
        return self.digest_of("central_body", "orbit", "chain", "effects", "run")

    def digest_of(self, *parts: str) -> str:
        """Hash of some parts; absent effects are left out, so that a new kind of effect changes no digest."""
        physics = {k: dataclasses.asdict(getattr(self, k)) for k in parts}
        if "orbit" in physics and not self.orbit.flight_path_rad:  # as before there was another start than an apsis
            del physics["orbit"]["flight_path_rad"]
        if "chain" in physics:  # a body moves as a bar
            del physics["chain"]["end_bodies"]
            if not self.chain.com_share:
                del physics["chain"]["com_share"]
        if "effects" in physics:
            called = physics["effects"]
            for law in called["prescribed_rotation"]:
                for turn in (law, *law["further"]):  # as before there were splines
                    if turn["course"] != Course.SPLINE:
                        del turn["rates_rad_s"], turn["accelerations_rad_s2"]
                if law["course"] == Course.PAPER and not law["further"]:  # as before there were others
                    del law["course"], law["further"]
            always = ("gravity", "prescribed_rotation")
            physics["effects"] = {k: v for k, v in called.items() if v or k in always}
        return hashlib.sha256(json.dumps(physics, sort_keys=True).encode()).hexdigest()[:16]
