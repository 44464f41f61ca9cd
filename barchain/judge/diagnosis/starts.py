"""Wrong starts: the first sample shows them, and the motion from there obeys the right equations."""

from __future__ import annotations

import dataclasses
import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.common.initial_state import initial_state
from barchain.judge.diagnosis.mistake import Mistake
from barchain.judge.diagnosis.motion.words import factor_words
from barchain.metrics.quantities import FIELDS
from scenarios.orbits import orbit_of_elements, true_anomaly_rad
from scenarios.toml.scene_tables import EARTH_MU_M3_S2, EARTH_RADIUS_M

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from adapters.common.initial_state import InitialState
    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene
    from scenarios.scene import Orbit

    SceneChange = Callable[[Scene], Scene]

ANGLES, RATES, ORBIT = "initial-angles", "initial-rates", "orbit"
QUARTER_RAD = 0.5 * math.pi
STATE = ("com", "com_velocity", "attitude", "rate")
"""Quantities of a state"""
SAME = 1e-9
"""Relative difference of two starts that are the same: an engine may close its joints, or start on its own grid"""
MOST_FITTED = 2
"""Fitted starts that are told: a speed follows from its factor and from the gravitational parameter"""
RADIUS_M = (
    ("mean", "the mean radius, 6371 km", 6.371e6),
    ("equatorial", "the equatorial radius, 6378.137 km", 6378137.0),
    ("equatorial-rounded", "the equatorial radius, 6378 km", 6.378e6),
)


@dataclass(frozen=True)
class Start(Mistake):
    """Another start than the scene's."""

    change: SceneChange


def part(name: str, **values: Callable[[Scene], Any]) -> SceneChange:
    """Change of some fields of a part of a scene, each by a function of the scene."""

    def change(scene: Scene) -> Scene:
        new = {field: value(scene) for field, value in values.items()}
        return dataclasses.replace(scene, **{name: dataclasses.replace(getattr(scene, name), **new)})

    return change


def constant(value: float) -> Callable[[Scene], float]:
    """A value that does not depend on the scene."""
    return lambda _: value


def angles(value: Callable[[Scene, float], float]) -> SceneChange:
    """New initial angle of each bar, rad."""
    return part("chain", angle_rad=lambda s: tuple(value(s, a) for a in s.chain.angle_rad))


def rates(value: Callable[[float], float]) -> SceneChange:
    """New initial rate of each bar over the orbital rate."""
    return part("chain", rate_factor=lambda s: tuple(map(value, s.chain.rate_factor)))


def in_order(field: str, order: Callable[[tuple[float, ...]], Any]) -> SceneChange:
    """Values of all bars in another order, or summed."""
    return part("chain", **{field: lambda s: tuple(order(getattr(s.chain, field)))})


def clockwise(scene: Scene) -> Scene:
    """Scene whose initial horizontal velocity and initial rates are of the opposite direction."""
    opposite = part(
        "orbit", speed_factor=lambda s: -s.orbit.speed_factor, flight_path_rad=lambda s: -s.orbit.flight_path_rad
    )
    return opposite(rates(lambda a: -a)(scene))


def at_anomaly(anomaly_rad: Callable[[Orbit], float]) -> SceneChange:
    """Scene that starts elsewhere on its orbit; ValueError where there is no such start."""

    def change(scene: Scene) -> Scene:
        orbit, e = scene.orbit, scene.orbit.eccentricity
        periapsis_m = scene.radius0_m * orbit.onward**2 / (1.0 + e)
        argument_rad = orbit.longitude_rad - orbit.true_anomaly_rad
        moved = orbit_of_elements(scene.central_body, periapsis_m, e, argument_rad, anomaly_rad(orbit))
        return dataclasses.replace(scene, orbit=moved)

    return change


MU_M3_S2 = (
    ("km3", "398600 km^3/s^2", 3.986e14),
    ("g-times-mass", "G times the Earth's mass, 6.674e-11 times 5.972e24", 6.674e-11 * 5.972e24),
    ("of-g", "g = 9.81 m/s^2 at the Earth's radius", 9.81 * EARTH_RADIUS_M**2),
)
"""Gravitational parameters that engines take; without gravity they show in the start alone"""
ANGLE_CHANGES: tuple[tuple[str, str, SceneChange], ...] = (
    ("from-radial", "count from the radial direction", angles(lambda _, a: a + QUARTER_RAD)),
    ("towards-radial", "count from the direction to the Earth", angles(lambda _, a: a - QUARTER_RAD)),
    ("opposite", "have the opposite sign", angles(lambda _, a: -a)),
    ("clockwise-from-radial", "count clockwise from the radial direction", angles(lambda _, a: QUARTER_RAD - a)),
    ("from-backward-horizontal", "count from the opposite horizontal", angles(lambda _, a: a + math.pi)),
    ("degrees-as-radians", "in degrees are taken as radians", angles(lambda _, a: math.degrees(a))),
    ("converted-twice", "are converted to radians twice", angles(lambda _, a: math.radians(a))),
    ("inertial", "count from the z1 axis", angles(lambda s, a: a - s.orbit.longitude_rad + QUARTER_RAD)),
    ("without-longitude", "lack the initial longitude", angles(lambda s, a: a - s.orbit.longitude_rad)),
    ("relative", "count from the previous bar", in_order("angle_rad", itertools.accumulate)),
    ("in-reversed-order", "are in reversed order", in_order("angle_rad", reversed)),
    ("other-horizontal", "count from the other horizontal, chain's or bars'",
     part("chain", angle_from=lambda s: "bar" if s.chain.angle_from == "chain" else "chain")),
)  # fmt: skip
RATE_CHANGES: tuple[tuple[str, str, SceneChange], ...] = (
    ("against-orbit", "have the opposite sign", rates(lambda a: -a)),
    ("missing-orbital", "lack the orbital rate", rates(lambda a: a - 1.0)),
    ("adding-orbital", "contain the orbital rate twice", rates(lambda a: a + 1.0)),
    ("zero", "are zero", rates(lambda _: 0.0)),
    ("orbital", "all equal the orbital rate", rates(lambda _: 1.0)),
    ("in-degrees", "are in degrees per second", rates(math.degrees)),
    ("all-positive", "lack their sign", rates(abs)),
    ("half", "are half the right values", rates(lambda a: 0.5 * a)),
    ("twice", "are twice the right values", rates(lambda a: 2.0 * a)),
    ("relative", "are relative to the previous bar", in_order("rate_factor", itertools.accumulate)),
    ("in-reversed-order", "are in reversed order", in_order("rate_factor", reversed)),
)
ORBIT_CHANGES: tuple[tuple[str, str, SceneChange], ...] = (
    ("orbit-clockwise", "the orbit and the initial rates are clockwise", clockwise),
    ("longitude-zero", "the initial longitude is zero", part("orbit", longitude_rad=lambda _: 0.0)),
    ("longitude-opposite", "the initial longitude has the opposite sign",
     part("orbit", longitude_rad=lambda s: -s.orbit.longitude_rad)),
    ("longitude-in-degrees", "the initial longitude is taken in degrees where radians are meant",
     part("orbit", longitude_rad=lambda s: math.degrees(s.orbit.longitude_rad))),
    ("central-body-earth", "the central body is the Earth, not the given one",
     part("central_body", mu_m3_s2=lambda _: EARTH_MU_M3_S2, radius_m=lambda _: EARTH_RADIUS_M)),
    ("speed-circular", "the speed factor is missing", part("orbit", speed_factor=lambda _: 1.0)),
    ("speed-factor-squared", "the speed factor is squared",
     part("orbit", speed_factor=lambda s: s.orbit.speed_factor**2)),
    ("speed-factor-rooted", "the speed factor is taken under the root",
     part("orbit", speed_factor=lambda s: math.sqrt(abs(s.orbit.speed_factor)))),
    ("flight-path-zero", "the initial velocity is horizontal", part("orbit", flight_path_rad=lambda _: 0.0)),
    ("flight-path-opposite", "the initial radial velocity has the opposite sign",
     part("orbit", flight_path_rad=lambda s: -s.orbit.flight_path_rad)),
    ("anomaly-zero", "the chain starts at the periapsis", at_anomaly(lambda _: 0.0)),
    ("mean-anomaly-as-true", "the mean anomaly is taken as the true one", at_anomaly(lambda o: o.mean_anomaly_rad)),
    ("true-anomaly-as-mean", "the true anomaly is taken as the mean one",
     at_anomaly(lambda o: true_anomaly_rad(o.eccentricity, o.true_anomaly_rad))),
    *((f"radius-{name}", f"the altitude counts from {words}", part("central_body", radius_m=constant(value)))
      for name, words, value in RADIUS_M),
    *((f"mu-{name}", f"the gravitational parameter is that of {words}",
       part("central_body", mu_m3_s2=constant(value))) for name, words, value in MU_M3_S2),
)  # fmt: skip
STARTS = (
    *(Start(f"initial-angles-{n}", f"the initial angles {words}", ANGLES, c) for n, words, c in ANGLE_CHANGES),
    *(Start(f"initial-rates-{n}", f"the initial rates {words}", RATES, c) for n, words, c in RATE_CHANGES),
    *(Start(n, words, ORBIT, c) for n, words, c in ORBIT_CHANGES),
)


def off_start(first: Trajectory, right: InitialState) -> dict[str, Array]:
    """Difference of the first sample of a trajectory from a start, for each quantity that it has."""
    given = {quantity: getattr(first, FIELDS[quantity]) for quantity in STATE}
    return {q: values[0] - getattr(right, FIELDS[q]) for q, values in given.items() if values is not None}


def same_start(first: Trajectory, right: InitialState, scene: Scene) -> bool:
    """Whether the first sample of a trajectory is a given start."""
    sizes = {"com": scene.radius0_m, "com_velocity": 0.0, "attitude": 1.0, "rate": scene.fastest_rate_rad_s}
    return all(
        bool(np.all(np.abs(off) <= SAME * max(sizes[q], float(np.abs(getattr(right, FIELDS[q])).max()))))
        for q, off in off_start(first, right).items()
    )


def starts(first: Trajectory, scene: Scene) -> list[Mistake]:
    """Mistakes whose start is the first sample of a trajectory; empty if that is right."""
    if same_start(first, initial_state(scene), scene):
        return []
    every: list[Start] = [*STARTS, *fitted_starts(first, scene)]
    found: list[Mistake] = [m for m in STARTS if is_start(first, m, scene)]
    if not found:
        found += [m for m in every if is_start(first, m, scene)][:MOST_FITTED]
    return found


def is_start(first: Trajectory, mistake: Start, scene: Scene) -> bool:
    """Whether a mistake changes a start to the first sample of a trajectory."""
    try:
        return same_start(first, initial_state(mistake.change(scene)), scene)
    except (ArithmeticError, ValueError):  # an orbit that there is not
        return False


def fitted_starts(first: Trajectory, scene: Scene) -> Iterator[Start]:
    """Starts with one number that follows from the first sample."""
    right, com, velocity = initial_state(scene), first.com_m[0], first.com_velocity_m_s[0]
    r0, speed = float(np.linalg.norm(com)), float(np.linalg.norm(velocity))
    factor = r0 / scene.radius0_m
    yield Start("initial-radius", f"the initial distance from the body's centre is {factor_words(factor)}", ORBIT,
                part("orbit", altitude_m=lambda s: r0 - s.central_body.radius_m))  # fmt: skip
    if scene.speed0_m_s > 0.0:
        ratio = speed / float(np.linalg.norm(right.com_velocity_m_s))
        yield Start("speed-factor", f"the speed factor is {factor_words(ratio)}", ORBIT,
                    part("orbit", speed_factor=lambda s: ratio * s.orbit.speed_factor))  # fmt: skip
        said = f"the gravitational parameter of the start is {factor_words(ratio**2)}"
        yield Start("gravitational-parameter-of-start", said, ORBIT,
                    part("central_body", mu_m3_s2=lambda s: ratio**2 * s.central_body.mu_m3_s2))  # fmt: skip
    turned = math.remainder(math.atan2(com[1], com[0]) - scene.orbit.longitude_rad, 2.0 * math.pi)
    yield Start("initial-longitude", f"the initial longitude is off by {math.degrees(turned):.4g} degrees", ORBIT,
                part("orbit", longitude_rad=lambda s: s.orbit.longitude_rad + turned))  # fmt: skip
    if first.angle_rad is not None:
        off = first.angle_rad[0] - right.angle_rad
        yield from off_by("initial-angle", ANGLES, "angle_rad", off, np.degrees(off), "degrees")
    if first.rate_rad_s is not None and scene.orbital_rate_rad_s > 0.0:  # the unit of a start's rates
        off = (first.rate_rad_s[0] - right.rate_rad_s) / scene.orbital_rate_rad_s
        yield from off_by("initial-rate", RATES, "rate_factor", off, off, "orbital rates")
        turning = right.rate_rad_s != 0.0
        if turning.any():
            times = float(np.median(first.rate_rad_s[0][turning] / right.rate_rad_s[turning]))
            yield Start("initial-rates-times-a-factor", f"the initial rates are {factor_words(times)}", RATES,
                        part("chain", rate_factor=lambda s: tuple(times * a for a in s.chain.rate_factor)))  # fmt: skip


def off_by(name: str, section: str, field: str, off: Array, shown: Array, unit: str) -> Iterator[Start]:
    """Values of all bars that are off by one amount, and of single bars."""
    noun = name.replace("-", " ")
    mean = float(np.median(off))
    yield Start(f"{name}s", f"the {noun}s are off by {float(np.median(shown)):.4g} {unit}", section,
                part("chain", **{field: lambda s: tuple(v + mean for v in getattr(s.chain, field))}))  # fmt: skip
    bar = int(np.argmax(np.abs(off)))
    yield Start(
        f"{name}-of-bar-{bar + 1}", f"the {noun} of bar {bar + 1} is off by {float(shown[bar]):.4g} {unit}", section,
        part("chain", **{field: lambda s: tuple(v + (float(off[bar]) if j == bar else 0.0)
                                                for j, v in enumerate(getattr(s.chain, field)))}),
    )  # fmt: skip
