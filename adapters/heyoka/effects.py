"""Effects of a scene in heyoka's equations: their shapes and their parameters.

A shape determines the expressions; numbers are parameters. Each parameter has a name. The shape gives the names and
their order, so that an effect outside the scene has no parameter.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenarios import Axes

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from adapters.heyoka.units import HeyokaUnits
    from scenarios import Drag, Impulse, JointSpringDamper, Oblateness, Scene, SolarPressure, ThirdBody, Thrust

    Named = Iterator[tuple[str, Any]]
    Number = Callable[[Any], Any]


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
class EffectShapes:
    """Forms of the effects besides gravity and prescribed rotations."""

    bars: int = 0
    oblate: bool = False
    third_bodies: int = 0
    drag: bool = False
    light: bool = False
    shadow: bool = False
    springs: bool = False
    thrusts: tuple[EndForceShape, ...] = ()
    impulses: tuple[EndForceShape, ...] = ()

    @property
    def modes(self) -> tuple[str, ...]:
        """Names of the parameters that events change: faces (1 or -1), then light (1 or 0)."""
        found = [f"drag_face_{j}" for j in range(self.bars) if self.drag]
        found += [f"light_face_{j}" for j in range(self.bars) if self.light]
        return (*found, *(("lit",) if self.shadow else ()))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all parameters in their order."""
        found = ["oblateness"] if self.oblate else []
        found += [f"body_{k}_{x}" for k in range(self.third_bodies) for x in BODY]
        found += [f"drag_{x}" for x in AIR if self.drag]
        found += [f"drag_{x}_{j}" for x in ("area", "second", "fourth") for j in range(self.bars) if self.drag]
        found += [f"light_{x}" for x in SUN if self.light]
        found += [f"light_area_{j}" for j in range(self.bars) if self.light]
        found += [f"spring_{x}_{j}" for x in SPRING for j in range(self.bars - 1) if self.springs]
        found += self.modes
        found += [f"thrust_{k}_{x}" for k in range(len(self.thrusts)) for x in THRUST]
        return (*found, *(f"impulse_{k}_{x}" for k in range(len(self.impulses)) for x in IMPULSE))


BODY = ("pull", "distance", "longitude", "rate")
AIR = ("density", "radius", "height", "turn", "normal", "tangential")
SUN = ("absorbed", "mirrored", "longitude", "rate")
SPRING = ("stiffness", "damping", "rest")
THRUST = ("direction", "size", "slope", "since")
IMPULSE = ("direction", "size")


def shapes_of(scene: Scene) -> EffectShapes:
    """Shapes of the effects of `scene`; a central body without a radius casts no shadow."""
    effects = scene.effects
    if not effects.beyond_basic:
        return EffectShapes()
    light = effects.solar_pressure
    return EffectShapes(
        bars=scene.bars,
        oblate=effects.oblateness is not None,
        third_bodies=len(effects.third_body),
        drag=effects.drag is not None,
        light=light is not None,
        shadow=light is not None and light.shadow and scene.central_body.radius_m > 0.0,
        springs=effects.joint_spring_damper is not None,
        thrusts=tuple(end_force_shape(p, sloped=len(set(p.force_N)) > 1) for p in effects.thrust),
        impulses=tuple(end_force_shape(p) for p in effects.impulse),
    )


def end_force_shape(push: Thrust | Impulse, *, sloped: bool = False) -> EndForceShape:
    """Shape of a thrust or an impulse."""
    return EndForceShape(push.bar - 1, push.end.sign, push.axes is Axes.BODY, sloped)


def perturbs_orbit(scene: Scene) -> bool:
    """Whether any force besides the central body's own gravity acts on the chain's centre of mass."""
    e = scene.effects
    return bool(e.oblateness or e.third_body or e.drag or e.solar_pressure or e.thrust or e.impulse)


def effect_parameters(scene: Scene, units: HeyokaUnits, number: Number) -> dict[str, Any]:
    """Parameters by name, in order, in the working precision and units; modes, thrusts and impulses are 0."""
    e = scene.effects
    found: dict[str, Any] = dict.fromkeys(shapes_of(scene).names, number(0.0))
    if e.oblateness:
        found |= oblateness_parameters(e.oblateness, scene, units, number)
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
    return found


def oblateness_parameters(oblate: Oblateness, scene: Scene, units: HeyokaUnits, number: Number) -> dict[str, Any]:
    """Parameter B = mu J2 R²/2."""
    radius = number(oblate.radius_m / units.length_m)
    mu = number(scene.central_body.mu_m3_s2 * units.time_s**2 / units.length_m**3)
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


def thrust_segment(thrust: Thrust, middle_s: float, units: HeyokaUnits, number: Number) -> tuple[Any, Any, Any]:
    """Force, slope and start of the straight segment of a thrust's table around an instant; zeros outside the table."""
    zero, table = number(0.0), list(zip(thrust.times_s, thrust.force_N, strict=True))
    force = units.time_s**2 / units.length_m
    for (t0, f0), (t1, f1) in itertools.pairwise(table):
        if t0 < middle_s < t1:
            since, until = number(t0 / units.time_s), number(t1 / units.time_s)
            size = number(f0 * force)
            return size, (number(f1 * force) - size) / (until - since), since
    return zero, zero, zero


def impulse_size(impulse: Impulse, units: HeyokaUnits, number: Number) -> Any:
    """Magnitude of an impulse in the working precision and units."""
    return number(impulse.impulse_N_s * units.time_s / units.length_m)
