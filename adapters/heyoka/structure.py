"""Structure of a scene's equations in heyoka, and their parameters.

A structure determines the expressions; numbers are parameters. Each parameter has a name. The structure gives the names
and their order, so that an effect outside the scene has no parameter.

Units are powers of two, near the initial radius and the fastest rate. The change of units rounds no number, and all
unknowns are of order one, as heyoka's tolerance relative to the largest unknown requires.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.common.initial_state import initial_state
from scenarios import Actuator, Axes, Course, Gravity

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from scenarios import (
        Drag,
        Impulse,
        JointSpringDamper,
        JointTorque,
        Oblateness,
        Scene,
        SolarPressure,
        ThirdBody,
        Thrust,
        Turn,
    )
    from scenarios.scene import Chain

    Named = Iterator[tuple[str, Any]]
    Number = Callable[[Any], Any]

PI = "3.14159265358979323846264338327950288419716939937510582097494459"
BAR = ("mass", "share", "half", "inertia", "end_inertia", "slender")
"""Parameters of a bar: m, m/M, l/2, J about its centre and about its left end, and 3 J/(l/2)², a slender bar's mass"""
LEVERS = ("left", "right", "lean")
"""Further ones where levers are unequal: a and b, the ends' distances from the centre of mass, and m a over l/2"""
LAW = ("rate", "start", "amplitude")
"""Parameters of a law's present turn: pi/t_m, start, amplitude over 16 (zero while the bar is held)"""
SPLINE = ("rate", "start", "constant", "linear", "square", "cube")
"""Parameters of a piece of a spline: acceleration by powers of the share of its duration"""
BODY = ("pull", "distance", "longitude", "rate")
AIR = ("density", "radius", "height", "turn", "normal", "tangential")
SUN = ("absorbed", "mirrored", "longitude", "rate")
SPRING = ("stiffness", "damping", "rest")
SIZE = ("size", "slope", "since")
"""Parameters of a size that is linear in time; zeros outside its table"""
THRUST = ("direction", *SIZE)
IMPULSE = ("direction", "size")
Numbers = Any
"""Array in the working precision"""


@dataclass(frozen=True)
class HeyokaUnits:
    """Powers of two."""

    length_m: float
    time_s: float

    @property
    def force(self) -> float:
        """Unit of force, N; masses stay in kg."""
        return self.length_m / self.time_s**2


def units_of(scene: Scene) -> HeyokaUnits:
    """Units near the initial radius and the fastest rate."""
    return HeyokaUnits(2.0 ** round(math.log2(scene.radius0_m)), 2.0 ** -round(math.log2(scene.fastest_rate_rad_s)))


@dataclass(frozen=True)
class LawShape:
    """Form of a prescribed rotation in the equations."""

    bar: int
    """Counted from 0"""
    frame: str
    joint: bool
    """Whether a motor in a joint exerts the torque"""
    courses: frozenset[str]
    """Courses of its turns; parameters are in the order of their names"""


@dataclass(frozen=True)
class EndForceShape:
    """Form of a force or an impulse on a bar's end in the equations."""

    bar: int
    """Counted from 0"""
    side: float
    """1 for the right end, -1 for the left"""
    body: bool
    """Whether the direction turns with the bar"""
    sloped: bool = False
    """Whether the force changes linearly in time"""


@dataclass(frozen=True)
class Structure:
    """Properties that two scenes must share to share one compiled code."""

    bars: int
    gravity: str
    laws: tuple[LawShape, ...] = ()
    levers: bool = False
    """Whether any bar's ends are at unequal distances from its centre of mass"""
    lands: bool = False
    """Whether events watch the surface"""
    oblate: bool = False
    third_bodies: int = 0
    drag: bool = False
    light: bool = False
    shadow: bool = False
    springs: bool = False
    motors: tuple[int, ...] = ()
    """Joints with torques, counted from 0"""
    thrusts: tuple[EndForceShape, ...] = ()
    impulses: tuple[EndForceShape, ...] = ()

    @property
    def surfaces(self) -> int:
        """Number of events of the surface: one for each end, and one for each bar between its ends."""
        return 2 * self.bars + 1 if self.lands else 0

    @property
    def modes(self) -> tuple[str, ...]:
        """Names of the parameters that events change: faces (1 or -1), then light (1 or 0)."""
        found = [f"drag_face_{j}" for j in range(self.bars) if self.drag]
        found += [f"light_face_{j}" for j in range(self.bars) if self.light]
        return (*found, *(("lit",) if self.shadow else ()))

    @cached_property
    def slots(self) -> dict[str, int]:
        """Index of each parameter by its name, in order."""
        bars = range(self.bars)
        names = ["mu", "surface", *(f"{x}_{j}" for x in BAR for j in bars)]
        names += [f"{x}_{j}" for x in LEVERS for j in bars if self.levers]
        for k, law in enumerate(self.laws):
            names += [f"law_{k}_{c}_{x}" for c in sorted(law.courses) for x in law_parts(c)]
        names += ["oblateness"] if self.oblate else []
        names += [f"body_{k}_{x}" for k in range(self.third_bodies) for x in BODY]
        names += [f"drag_{x}" for x in AIR if self.drag]
        names += [f"drag_{x}_{j}" for x in ("area", "second", "fourth") for j in bars if self.drag]
        names += [f"light_{x}" for x in SUN if self.light]
        names += [f"light_area_{j}" for j in bars if self.light]
        names += [f"spring_{x}_{j}" for x in SPRING for j in range(self.bars - 1) if self.springs]
        names += self.modes
        names += [f"motor_{k}_{x}" for k in range(len(self.motors)) for x in SIZE]
        names += [f"thrust_{k}_{x}" for k in range(len(self.thrusts)) for x in THRUST]
        names += [f"impulse_{k}_{x}" for k in range(len(self.impulses)) for x in IMPULSE]
        return {name: i for i, name in enumerate(names)}

    def parameter(self, name: str) -> Any:
        """Expression of a parameter."""
        import heyoka as hy

        return hy.par[self.slots[name]]

    def of_bars(self, part: str) -> list[Any]:
        """Expressions of a parameter of each bar."""
        return [self.parameter(f"{part}_{j}") for j in range(self.bars)]


def structure_of(scene: Scene) -> Structure:
    """Structure of `scene`; a central body without a radius casts no shadow."""
    effects, light = scene.effects, scene.effects.solar_pressure
    return Structure(
        scene.bars,
        str(effects.gravity),
        laws=tuple(
            LawShape(p.bar - 1, str(p.frame), p.actuator is Actuator.JOINT, frozenset(str(t.course) for t in p.turns))
            for p in effects.prescribed_rotation
        ),
        levers=bool(scene.chain.com_share),
        lands=may_land(scene),
        oblate=effects.oblateness is not None,
        third_bodies=len(effects.third_body),
        drag=effects.drag is not None,
        light=light is not None,
        shadow=light is not None and light.shadow and scene.central_body.radius_m > 0.0,
        springs=effects.joint_spring_damper is not None,
        motors=tuple(motor.joint - 1 for motor in effects.joint_torque),
        thrusts=tuple(end_force_shape(p, sloped=len(set(p.force_N)) > 1) for p in effects.thrust),
        impulses=tuple(end_force_shape(p) for p in effects.impulse),
    )


def end_force_shape(push: Thrust | Impulse, *, sloped: bool = False) -> EndForceShape:
    """Shape of a thrust or an impulse."""
    return EndForceShape(push.bar - 1, push.end.sign, push.axes is Axes.BODY, sloped)


def may_land(scene: Scene) -> bool:
    """Whether a bar might reach the surface: lowest point of the osculating orbit less twice the chain's length.

    The chain extends half of its length beyond its centre of mass, and its whole length if its masses are very unequal.
    The remainder allows for the departure from that orbit, of order (L/r)² r. Where other forces than the central
    body's gravity act on the centre of mass, its orbit at t = 0 gives no bound, and events watch the surface.
    """
    e = scene.effects
    if scene.central_body.radius_m <= 0.0:
        return False
    if e.oblateness or e.third_body or e.drag or e.solar_pressure or e.thrust or e.impulse:
        return True
    if e.gravity is Gravity.NONE and scene.orbit.upward >= 0.0:
        return False  # without gravity an injection that does not fall leads away from the surface
    return scene.lowest_radius_m - 2.0 * scene.size_m <= scene.central_body.radius_m


def start_of(scene: Scene, units: HeyokaUnits, number: Number) -> Numbers:
    """State [Z0, Z0', theta, theta'] at t = 0 in the working precision: the initial state of every engine."""
    at = initial_state(scene)
    length, time = units.length_m, units.time_s
    parts = [at.com_m / length, at.com_velocity_m_s * time / length, at.angle_rad, at.rate_rad_s * time]
    return np.array([number(float(x)) for x in np.concatenate(parts)])


def parameters_of(scene: Scene, units: HeyokaUnits, number: Number) -> Numbers:
    """Parameters of the equations in the working precision and units; modes, tables in time and impulses are 0.

    `number` converts a float or a decimal string.
    """
    e, found = scene.effects, dict.fromkeys(structure_of(scene).slots, number(0.0))
    found |= chain_parameters(scene, units, number)
    if e.oblateness:
        found |= oblateness_parameters(e.oblateness, found["mu"], units, number)
    for k, body in enumerate(e.third_body):
        found |= {f"body_{k}_{x}": v for x, v in body_parameters(body, units, number)}
    if e.drag:
        found |= drag_parameters(e.drag, scene, units, number)
    if e.solar_pressure:
        found |= light_parameters(e.solar_pressure, scene, units, number)
    if e.joint_spring_damper:
        found |= spring_parameters(e.joint_spring_damper, units, number)
    found |= {f"thrust_{k}_direction": number(p.direction_rad) for k, p in enumerate(e.thrust)}
    found |= {f"impulse_{k}_direction": number(p.direction_rad) for k, p in enumerate(e.impulse)}
    return np.array(list(found.values()))


def chain_parameters(scene: Scene, units: HeyokaUnits, number: Number) -> dict[str, Any]:
    """Parameters of the central body and the bars."""
    length, time, chain = units.length_m, units.time_s, scene.chain
    mass = [number(m) for m in chain.mass_kg]
    total = sum(mass[1:], mass[0])
    half = [number(0.5 * x / length) for x in chain.length_m]
    inertia = [number(j / length**2) for j in chain.inertia_kg_m2]
    parts = (
        mass,
        [m / total for m in mass],
        half,
        inertia,
        [j + m * h * h for j, m, h in zip(inertia, mass, half, strict=True)],
        [number(3.0) * j / (h * h) for j, h in zip(inertia, half, strict=True)],
    )
    found = {
        "mu": number(scene.central_body.mu_m3_s2 * time**2 / length**3),
        "surface": number(scene.central_body.radius_m / length),
    }
    found |= {f"{name}_{j}": v for name, values in zip(BAR, parts, strict=True) for j, v in enumerate(values)}
    if chain.com_share:
        found |= lever_parameters(chain, length, number)
    return found


def lever_parameters(chain: Chain, unit_m: float, number: Number) -> dict[str, Any]:
    """Parameters of bars with unequal levers, and their moments of inertia about their left ends."""
    found: dict[str, Any] = {}
    for j, (mass, length, share) in enumerate(zip(chain.mass_kg, chain.length_m, chain.com_share, strict=True)):
        size, part = number(length / unit_m), number(share)
        left = part * size
        found |= {f"left_{j}": left, f"right_{j}": size - left, f"lean_{j}": number(2.0) * part * number(mass)}
        found[f"end_inertia_{j}"] = number(chain.inertia_kg_m2[j] / unit_m**2) + number(mass) * left * left
    return found


def law_parts(course: str) -> tuple[str, ...]:
    """Parameters of turns of one course."""
    return SPLINE if course == Course.SPLINE else LAW


def turns_of(scene: Scene, middle_s: float, units: HeyokaUnits, number: Number) -> Named:
    """Parameters of the turns that prescribed bars make at an instant."""
    for k, law in enumerate(scene.effects.prescribed_rotation):
        for turn in law.turns:
            if turn.start_s < middle_s < turn.end_s:
                length = number(turn.duration_s / units.time_s)
                start, name = number(turn.start_s / units.time_s), f"law_{k}_{turn.course}"
                if turn.course is Course.SPLINE:
                    values = spline_acceleration(turn, length, units, number)
                    yield from zip((f"{name}_{x}" for x in SPLINE), (number(1.0) / length, start, *values), strict=True)
                    continue
                paper = turn.course is Course.PAPER
                whole, rate = (1.0 / 16.0, number(PI) / length) if paper else (1.0, number(1.0) / length)
                yield from zip(
                    (f"{name}_{x}" for x in LAW), (rate, start, number(turn.amplitude_rad * whole)), strict=True
                )


def spline_acceleration(turn: Turn, length: Any, units: HeyokaUnits, number: Number) -> list[Any]:
    """Acceleration of a piece of a spline by the powers 0 to 3 of the share of its duration.

    From the step, rates and accelerations at the ends, by the quintic that has them.
    """
    step = number(turn.amplitude_rad) / (length * length)
    r0, r1 = (number(rate * units.time_s) / length for rate in turn.rates_rad_s)
    a0, a1 = (number(acceleration * units.time_s**2) for acceleration in turn.accelerations_rad_s2)
    return [
        a0,
        number(60.0) * step - number(36.0) * r0 - number(24.0) * r1 - number(9.0) * a0 + number(3.0) * a1,
        number(-180.0) * step + number(96.0) * r0 + number(84.0) * r1 + number(18.0) * a0 - number(12.0) * a1,
        number(120.0) * step - number(60.0) * (r0 + r1) + number(10.0) * (a1 - a0),
    ]


def oblateness_parameters(oblate: Oblateness, mu: Any, units: HeyokaUnits, number: Number) -> dict[str, Any]:
    """Parameter B = mu J2 R²/2."""
    radius = number(oblate.radius_m / units.length_m)
    return {"oblateness": number(0.5) * mu * number(oblate.j2) * radius * radius}


def body_parameters(body: ThirdBody, units: HeyokaUnits, number: Number) -> Named:
    """Pull mu_b/D³, distance D, longitude at t = 0, rate."""
    distance = number(body.distance_m / units.length_m)
    mu = number(body.mu_m3_s2 * units.time_s**2 / units.length_m**3)
    values = (mu / (distance * distance * distance), distance, number(body.longitude_rad))
    yield from zip(BODY, (*values, number(body.rate_rad_s * units.time_s)), strict=True)


def drag_parameters(drag: Drag, scene: Scene, units: HeyokaUnits, number: Number) -> dict[str, Any]:
    """Parameters of the air, and of each bar (b/2) times the integrals of 1, s², s⁴: b h, b h³/3, b h⁵/5."""
    length = units.length_m
    radius = number(scene.central_body.radius_m / length) + number(drag.altitude_m / length)
    air = (
        number(drag.density_kg_m3 * length**3),
        radius,
        number(drag.scale_height_m / length),
        number(drag.rotation_rad_s * units.time_s),
        number(drag.normal_coefficient),
        number(drag.tangential_coefficient),
    )
    found = {f"drag_{x}": v for x, v in zip(AIR, air, strict=True)}
    for j, (width, size) in enumerate(zip(drag.width_m, scene.chain.length_m, strict=True)):
        b, h = number(width / length), number(0.5 * size / length)
        area, square = b * h, h * h
        found |= {f"drag_area_{j}": area, f"drag_second_{j}": area * square / number(3.0)}
        found[f"drag_fourth_{j}"] = area * square * square / number(5.0)
    return found


def light_parameters(light: SolarPressure, scene: Scene, units: HeyokaUnits, number: Number) -> dict[str, Any]:
    """Absorbed (1 - rho) and reflected (2 rho) shares, the Sun's longitude and rate, and P b l of each bar."""
    share, length = number(light.reflectivity), units.length_m
    sun = (number(1.0) - share, number(2.0) * share, number(light.sun_longitude_rad))
    found = dict(zip([f"light_{x}" for x in SUN], (*sun, number(light.sun_rate_rad_s * units.time_s)), strict=True))
    pressure = number(light.pressure_Pa * length * units.time_s**2)
    for j, (width, size) in enumerate(zip(light.width_m, scene.chain.length_m, strict=True)):
        found[f"light_area_{j}"] = pressure * number(width / length) * number(size / length)
    return found


def spring_parameters(springs: JointSpringDamper, units: HeyokaUnits, number: Number) -> dict[str, Any]:
    """Stiffness, damping and rest angle of each joint."""
    stiffness, damping = units.time_s**2 / units.length_m**2, units.time_s / units.length_m**2
    columns = (
        [number(k * stiffness) for k in springs.stiffness_N_m_rad],
        [number(c * damping) for c in springs.damping_N_m_s_rad],
        [number(x) for x in springs.rest_rad],
    )
    return {f"spring_{x}_{j}": v for x, col in zip(SPRING, columns, strict=True) for j, v in enumerate(col)}


def segments_of(scene: Scene, middle_s: float, units: HeyokaUnits, number: Number) -> Named:
    """Parameters of the straight segments of all tables in time around an instant."""
    force = units.time_s**2 / units.length_m
    for k, thrust in enumerate(scene.effects.thrust):
        yield from ((f"thrust_{k}_{x}", v) for x, v in segment_of(thrust, middle_s, units, force, number))
    for k, motor in enumerate(scene.effects.joint_torque):
        torque = force / units.length_m
        yield from ((f"motor_{k}_{x}", v) for x, v in segment_of(motor, middle_s, units, torque, number))


def segment_of(table: Thrust | JointTorque, middle_s: float, units: HeyokaUnits, unit: float, number: Number) -> Named:
    """Size in `unit`, slope and start of the straight segment of a table around an instant; zeros outside the table."""
    for (t0, f0), (t1, f1) in itertools.pairwise(zip(table.times_s, table.sizes, strict=True)):
        if t0 < middle_s < t1:
            since, until, size = number(t0 / units.time_s), number(t1 / units.time_s), number(f0 * unit)
            return zip(SIZE, (size, (number(f1 * unit) - size) / (until - since), since), strict=True)
    return zip(SIZE, (number(0.0),) * 3, strict=True)


def impulse_size(impulse: Impulse, units: HeyokaUnits, number: Number) -> Any:
    """Magnitude of an impulse in the working precision and units."""
    return number(impulse.impulse_N_s * units.time_s / units.length_m)
