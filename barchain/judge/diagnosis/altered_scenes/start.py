"""Wrong initial angles, rates and orbit."""

from __future__ import annotations

import itertools
import math
from operator import neg
from typing import TYPE_CHECKING

from barchain.judge.diagnosis.altered_scenes.changes import part, per_bar, reversed_tuple
from barchain.judge.diagnosis.mistake import SceneMistake
from scenarios.toml.scene_tables import EARTH_MU_M3_S2, EARTH_RADIUS_M

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenarios import Scene

    PartChange = Callable[[Scene], tuple[float, ...]]

ANGLES, RATES, ORBIT = "initial-angles", "initial-rates", "orbit"
QUARTER_RAD = 0.5 * math.pi


def accumulated(field: str) -> PartChange:
    """Sums of the values up to each bar: given values taken as relative to the previous bar."""

    def values(scene: Scene) -> tuple[float, ...]:
        return tuple(itertools.accumulate(getattr(scene.chain, field)))

    return values


def angles(value: Callable[[Scene, float], float]) -> PartChange:
    """New initial angle of each bar, rad, from the scene and the right angle."""
    return per_bar(lambda scene, j: value(scene, scene.chain.angle_rad[j]))


def rates(value: Callable[[float], float]) -> PartChange:
    """New initial rate of each bar over the orbital rate, from the right one."""
    return per_bar(lambda scene, j: value(scene.chain.rate_factor[j]))


def other_horizontal(scene: Scene) -> str:
    """The horizontal that the angles do not count from."""
    return "bar" if scene.chain.angle_from == "chain" else "chain"


def clockwise(scene: Scene) -> Scene:
    """Scene with an initial velocity and initial rates of the opposite direction."""
    return part("orbit", speed_factor=lambda s: -s.orbit.speed_factor)(part("chain", rate_factor=rates(neg))(scene))


ANGLE_CHANGES: tuple[tuple[str, str, Callable[[Scene, float], float]], ...] = (
    ("from-radial", "the initial angles count from the radial direction", lambda _, a: a + QUARTER_RAD),
    ("towards-radial", "the initial angles count from the direction to the Earth", lambda _, a: a - QUARTER_RAD),
    ("opposite", "the initial angles have the opposite sign", lambda _, a: -a),
    (
        "clockwise-from-radial",
        "the initial angles count clockwise from the radial direction",
        lambda _, a: QUARTER_RAD - a,
    ),
    ("from-backward-horizontal", "the initial angles count from the opposite horizontal", lambda _, a: a + math.pi),
    ("degrees-as-radians", "the initial angles in degrees are taken as radians", lambda _, a: math.degrees(a)),
    ("converted-twice", "the initial angles are converted to radians twice", lambda _, a: math.radians(a)),
    (
        "inertial",
        "the initial angles count from the z1 axis",
        lambda s, a: a - s.orbit.longitude_rad + QUARTER_RAD,
    ),
    (
        "without-longitude",
        "the initial angles lack the initial longitude",
        lambda s, a: a - s.orbit.longitude_rad,
    ),
)
RATE_CHANGES: tuple[tuple[str, str, Callable[[float], float]], ...] = (
    ("against-orbit", "the initial rates have the opposite sign", lambda a: -a),
    ("missing-orbital", "the initial rates lack the orbital rate", lambda a: a - 1.0),
    ("adding-orbital", "the initial rates contain the orbital rate twice", lambda a: a + 1.0),
    ("zero", "the initial rates are zero", lambda _: 0.0),
    ("orbital", "the initial rates all equal the orbital rate", lambda _: 1.0),
    ("in-degrees", "the initial rates are in degrees per second", math.degrees),
    ("all-positive", "the initial rates lack their sign", abs),
    ("half", "the initial rates are half the right values", lambda a: 0.5 * a),
    ("twice", "the initial rates are twice the right values", lambda a: 2.0 * a),
)
MISTAKES = (
    *(
        SceneMistake(f"initial-angles-{name}", words, ANGLES, part("chain", angle_rad=angles(value)))
        for name, words, value in ANGLE_CHANGES
    ),
    SceneMistake(
        "initial-angles-relative",
        "the initial angles count from the previous bar",
        ANGLES,
        part("chain", angle_rad=accumulated("angle_rad")),
    ),
    SceneMistake(
        "initial-angles-in-reversed-order",
        "the initial angles are in reversed order",
        ANGLES,
        part("chain", angle_rad=reversed_tuple("angle_rad")),
    ),
    SceneMistake(
        "initial-angles-other-horizontal",
        "the initial angles count from the other horizontal, chain's or bars'",
        ANGLES,
        part("chain", angle_from=other_horizontal),
    ),
    *(
        SceneMistake(f"initial-rates-{name}", words, RATES, part("chain", rate_factor=rates(value)))
        for name, words, value in RATE_CHANGES
    ),
    SceneMistake(
        "initial-rates-relative",
        "the initial rates are relative to the previous bar",
        RATES,
        part("chain", rate_factor=accumulated("rate_factor")),
    ),
    SceneMistake(
        "initial-rates-in-reversed-order",
        "the initial rates are in reversed order",
        RATES,
        part("chain", rate_factor=reversed_tuple("rate_factor")),
    ),
    SceneMistake("orbit-clockwise", "the orbit and the initial rates are clockwise", ORBIT, clockwise),
    SceneMistake("longitude-zero", "the initial longitude is zero", ORBIT, part("orbit", longitude_rad=lambda _: 0.0)),
    SceneMistake(
        "longitude-opposite",
        "the initial longitude has the opposite sign",
        ORBIT,
        part("orbit", longitude_rad=lambda s: -s.orbit.longitude_rad),
    ),
    SceneMistake(
        "longitude-in-degrees",
        "the initial longitude is taken in degrees where radians are meant",
        ORBIT,
        part("orbit", longitude_rad=lambda s: math.degrees(s.orbit.longitude_rad)),
    ),
    SceneMistake(
        "central-body-earth",
        "the central body is the Earth, not the given one",
        ORBIT,
        part("central_body", mu_m3_s2=lambda _: EARTH_MU_M3_S2, radius_m=lambda _: EARTH_RADIUS_M),
    ),
    SceneMistake("speed-circular", "the speed factor is missing", ORBIT, part("orbit", speed_factor=lambda _: 1.0)),
    SceneMistake(
        "speed-factor-squared",
        "the speed factor is squared",
        ORBIT,
        part("orbit", speed_factor=lambda s: s.orbit.speed_factor**2),
    ),
    SceneMistake(
        "speed-factor-rooted",
        "the speed factor is taken under the root",
        ORBIT,
        part("orbit", speed_factor=lambda s: math.sqrt(abs(s.orbit.speed_factor))),
    ),
)
