"""Random scenes such as a user may write on an ordinary day.

They are chains that somebody might fly, with every kind of effect. Nobody tuned them, and no engine should be accused
on them. `tests/support/random_scenes.py` looks for what the reference does not survive, far beyond what anybody would
fly.
"""

from __future__ import annotations

import math
from dataclasses import fields, is_dataclass, replace
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from scenarios import Scene
from scenarios.effect_types import (
    Actuator,
    Axes,
    Course,
    Drag,
    Effects,
    End,
    Frame,
    Gravity,
    Impulse,
    JointSpringDamper,
    JointTorque,
    Oblateness,
    PrescribedRotation,
    SolarPressure,
    ThirdBody,
    Thrust,
)
from scenarios.scene import CentralBody, Chain, Orbit, Run
from scenarios.toml.alignment import on_sample
from scenarios.toml.effect_tables import EARTH_J2, EARTH_ROTATION_RAD_S, SUN_RATE_RAD_S, SUNLIGHT_PA, THIRD_BODIES
from scenarios.toml.resolve import ANGLES

if TYPE_CHECKING:
    from numpy.random import Generator

    from adapters.trajectory import Array

EARTH = CentralBody(3.986004418e14, 6378e3)
LENGTH_M = (0.1, 200.0)
MASS_KG = (0.1, 1e3)
ALTITUDE_M = (300e3, 2000e3)
RUN_PERIODS = (0.01, 0.5)
SAMPLES = (2, 300)
LONG_SHARE = 0.1
"""Share of the scenes that last for many orbits, most of them far beyond the predictability limit"""
LONG_PERIODS, LONG_SAMPLES = (2.0, 100.0), (5, 2000)
PLAIN = 0.15  # share of the scenes with gravity alone
POINTS = (Gravity.POINT, Gravity.GRADIENT)
SETS: tuple[tuple[tuple[Gravity, ...], frozenset[str]], ...] = (
    (POINTS, frozenset({"oblateness"})),
    (POINTS, frozenset({"third_body"})),
    (POINTS, frozenset({"drag"})),
    (POINTS, frozenset({"solar_pressure"})),
    ((*POINTS, Gravity.NONE), frozenset({"joint_spring_damper"})),
    ((*POINTS, Gravity.NONE), frozenset({"thrust"})),
    ((*POINTS, Gravity.NONE), frozenset({"impulse"})),
    ((*POINTS, Gravity.NONE), frozenset({"prescribed_rotation"})),
    ((Gravity.QUADRUPOLE,), frozenset()),
    ((Gravity.SLENDER,), frozenset()),
    ((Gravity.QUADRUPOLE,), frozenset({"oblateness", "third_body"})),
    ((Gravity.SLENDER,), frozenset({"drag", "solar_pressure", "joint_spring_damper"})),
    (POINTS, frozenset({"drag", "impulse", "thrust", "prescribed_rotation"})),
    ((Gravity.SLENDER,), frozenset({"oblateness", "third_body", "thrust", "impulse", "prescribed_rotation"})),
    (POINTS, frozenset({"oblateness", "drag"})),
    ((Gravity.QUADRUPOLE,), frozenset({"joint_spring_damper", "prescribed_rotation"})),
    (POINTS, frozenset({"solar_pressure", "third_body"})),
)
"""Gravity models and effects that go together. Compiled engines compile once for each set, so that there are few."""
NEWER_FROM = 10_000
"""Number of the first scene that may have what came later; those before stay as they were"""
NEWER_SHARE = 0.6
LOW_AIR_M = 500e3  # scenes with drag start below

T = TypeVar("T")


def draw(seed: int) -> Scene:
    """Scene number `seed`: the same for ever.

    Two to eight unequal bars of 0.1 to 200 m at any angles and longitudes, turning at 0 to 3 times the orbital rate,
    injected at 0.9 to 1.3 times the circular speed, seen at 2 to 300 samples; effects alone and together (`SETS`). One
    scene in ten lasts for 2 to 100 orbits, seen at 5 to 2000 samples. From :data:`NEWER_FROM` on three in five have
    unequal levers, a motor in a joint, or a joint that follows a law as well.
    """
    random = np.random.default_rng([seed, 13])
    models, called = choose(random, list(SETS)) if random.random() > PLAIN else (tuple(Gravity)[:3], frozenset())
    gravity = choose(random, list(models))
    highest = LOW_AIR_M if "drag" in called else ALTITUDE_M[1]
    altitude = log_uniform(random, (ALTITUDE_M[0], highest))
    orbit = Orbit(altitude, random.uniform(0.9, 1.3), random.uniform(-np.pi, np.pi))
    base = Scene(
        f"random/{seed}", f"Random scene {seed}", "drawn", "", (), EARTH, orbit, draw_chain(random, gravity),
        Effects(gravity), Run(1.0, round(log_uniform(random, SAMPLES))),
    )  # fmt: skip
    periods, samples = log_uniform(random, RUN_PERIODS), base.run.samples
    longer = np.random.default_rng([seed, 14])
    if longer.random() < LONG_SHARE:
        periods, samples = log_uniform(longer, LONG_PERIODS), round(log_uniform(longer, LONG_SAMPLES))
    timed = replace(base, run=Run(periods * base.period_s, samples))
    scene = replace(timed, effects=draw_effects(random, timed, called))
    return writable(with_newer(np.random.default_rng([seed, 15]), scene) if seed >= NEWER_FROM else scene)


def writable(part: T) -> T:
    """A scene, or a part of one, whose angles are numbers of degrees: moved in their last digit where they are not."""
    changes: dict[str, Any] = {}
    for field in fields(part):
        value = getattr(part, field.name)
        if field.name in ANGLES:
            changes[field.name] = snapped(value)
        elif is_dataclass(value):
            changes[field.name] = writable(value)
        elif isinstance(value, tuple) and value and is_dataclass(value[0]):
            changes[field.name] = tuple(map(writable, value))
    return replace(part, **changes)


def snapped(value: Any) -> Any:
    """Angle, or each of several, as degrees give it."""
    return tuple(map(snapped, value)) if isinstance(value, tuple) else math.radians(math.degrees(value))


def draw_chain(random: Generator, gravity: Gravity) -> Chain:
    """Unequal bars: free angles or nearly in line, rates alike or each of its own."""
    n = int(random.integers(2, 9))
    typical = log_uniform(random, LENGTH_M)
    length = np.clip(typical * random.uniform(0.4, 1.6, n), *LENGTH_M)
    mass = log_uniform(random, MASS_KG) * random.uniform(0.3, 1.7, n)
    shape = 1.0 if gravity is Gravity.SLENDER else choose(random, [1.0, random.uniform(0.3, 3.0)])
    angle = choose(random, [random.uniform(-np.pi, np.pi, n), random.uniform(-np.pi, np.pi) + random.normal(0, 0.2, n)])
    rate = choose(random, [np.full(n, random.uniform(0.0, 3.0)), random.uniform(0.0, 3.0, n)])
    inertia = mass * length**2 / 12.0 * shape
    angle_from = choose(random, ["chain", "bar"])
    return Chain(listed(mass), listed(length), listed(inertia), listed(angle), angle_from, listed(rate))


def draw_effects(random: Generator, scene: Scene, called: frozenset[str]) -> Effects:
    """Effects of these names, as strong as they are in an orbit."""
    struck = "impulse" in called and scene.run.samples > 2
    return Effects(
        scene.effects.gravity,
        prescribed_rotation=draw_rotations(random, scene) if "prescribed_rotation" in called else (),
        oblateness=Oblateness(EARTH_J2, scene.central_body.radius_m) if "oblateness" in called else None,
        third_body=draw_bodies(random) if "third_body" in called else (),
        drag=draw_drag(random, scene) if "drag" in called else None,
        solar_pressure=draw_light(random, scene) if "solar_pressure" in called else None,
        joint_spring_damper=draw_springs(random, scene) if "joint_spring_damper" in called else None,
        thrust=(draw_thrust(random, scene),) if "thrust" in called else (),
        impulse=(draw_impulse(random, scene),) if struck else (),
    )


def with_newer(random: Generator, scene: Scene) -> Scene:
    """Scene with unequal levers, a motor or a law of a joint; as it is if its effects exclude what is drawn."""
    effects, chain = scene.effects, scene.chain
    kind = choose(random, ["levers", "motor", "law"]) if random.random() < NEWER_SHARE else ""
    if kind == "levers" and not (effects.drag or effects.solar_pressure or effects.gravity is Gravity.SLENDER):
        return replace(scene, chain=replace(chain, com_share=listed(random.uniform(0.3, 0.7, scene.bars))))
    if kind == "motor":
        return replace(scene, effects=replace(effects, joint_torque=(draw_motor(random, scene),)))
    if kind == "law" and not effects.prescribed_rotation:
        law = draw_rotation(random, scene, int(random.integers(2, scene.bars + 1)))
        course = choose(random, [Course.PAPER, Course.QUINTIC])
        of_joint = replace(law, frame=Frame.PREVIOUS_BAR, actuator=Actuator.JOINT, course=course)
        return replace(scene, effects=replace(effects, prescribed_rotation=(of_joint,)))
    return scene


def draw_motor(random: Generator, scene: Scene) -> JointTorque:
    """A torque that could turn the lighter bar of a joint at up to twice the orbital rate squared."""
    joint = int(random.integers(1, scene.bars))
    start, end = sorted(moment(random, scene, s) for s in random.uniform(0.0, 1.0, 2))
    if end <= start:
        start, end = 0.0, scene.run.duration_s
    lighter = min(scene.chain.inertia_kg_m2[joint - 1 : joint + 1])
    torque = lighter * (scene.orbital_rate_rad_s * random.uniform(0.2, 2.0)) ** 2
    return JointTorque(joint, (start, end), (torque, random.uniform(-1.0, 1.0) * torque))


def draw_rotations(random: Generator, scene: Scene) -> tuple[PrescribedRotation, ...]:
    """One bar or two, slewed in a part of the run."""
    bars = random.choice(scene.bars, size=int(random.integers(1, 3)), replace=False) + 1
    return tuple(draw_rotation(random, scene, int(bar)) for bar in sorted(bars))


def draw_rotation(random: Generator, scene: Scene, bar: int) -> PrescribedRotation:
    """A slew of at most 90 degrees at no more than five times the rate of the orbit."""
    amplitude = random.uniform(-0.5, 0.5) * math.pi
    share = max(random.uniform(0.2, 0.8), abs(amplitude) / (5.0 * scene.orbital_rate_rad_s * scene.run.duration_s))
    start = random.uniform(0.0, 0.3)
    return PrescribedRotation(
        bar,
        amplitude,
        share * scene.run.duration_s,
        moment(random, scene, start),
        choose(random, [frame for frame in Frame if frame.of_bar]),
        Actuator.EXTERNAL,
    )


def draw_bodies(random: Generator) -> tuple[ThirdBody, ...]:
    """The Moon, the Sun, or both."""
    names = choose(random, [("moon",), ("sun",), ("moon", "sun")])
    found = []
    for name in names:
        mu, distance = THIRD_BODIES[name]
        rate = math.sqrt((EARTH.mu_m3_s2 + mu) / distance**3)
        found.append(ThirdBody(name, mu, distance, random.uniform(-np.pi, np.pi), rate))
    return tuple(found)


def draw_drag(random: Generator, scene: Scene) -> Drag:
    """Air as thin as at 300 to 600 km, given at the height of the start."""
    return Drag(
        10.0 ** random.uniform(-13.0, -10.5), scene.orbit.altitude_m, random.uniform(40e3, 80e3),
        EARTH_ROTATION_RAD_S, draw_widths(random, scene), random.uniform(1.0, 2.5), random.uniform(0.1, 2.0),
    )  # fmt: skip


def draw_light(random: Generator, scene: Scene) -> SolarPressure:
    """Sunlight from anywhere, with the shadow or without."""
    return SolarPressure(
        SUNLIGHT_PA, random.uniform(-np.pi, np.pi), SUN_RATE_RAD_S, draw_widths(random, scene),
        random.uniform(0.0, 1.0), bool(random.random() < 0.5),
    )  # fmt: skip


def draw_widths(random: Generator, scene: Scene) -> tuple[float, ...]:
    """Bars of a hundredth to a tenth of their length."""
    return listed(np.array(scene.chain.length_m) * 10.0 ** random.uniform(-2.0, -1.0))


def draw_springs(random: Generator, scene: Scene) -> JointSpringDamper:
    """Springs and dampers that act within an orbit, not so stiff that they hide the motion."""
    chain, joints = scene.chain, scene.bars - 1
    rate = scene.orbital_rate_rad_s * 10.0 ** random.uniform(-0.5, 1.0)
    inertia = np.minimum(chain.inertia_kg_m2[:-1], chain.inertia_kg_m2[1:])
    damped = choose(random, [0.0, random.uniform(0.0, 1.0)])
    return JointSpringDamper(
        listed(inertia * rate**2 * random.uniform(0.5, 1.5, joints)),
        listed(damped * inertia * rate * random.uniform(0.5, 1.5, joints)),
        listed(np.diff(chain.angle_rad) + random.uniform(-0.5, 0.5, joints)),
    )


def draw_thrust(random: Generator, scene: Scene) -> Thrust:
    """A push that could turn its bar by a few radians in the run."""
    bar = int(random.integers(1, scene.bars + 1))
    start, end = sorted(moment(random, scene, s) for s in random.uniform(0.0, 1.0, 2))
    if end <= start:
        start, end = 0.0, scene.run.duration_s
    rate = scene.orbital_rate_rad_s * random.uniform(0.2, 2.0)
    force = 2.0 * scene.chain.inertia_kg_m2[bar - 1] * rate**2 / scene.chain.length_m[bar - 1]
    return Thrust(
        bar, choose(random, list(End)), choose(random, list(Axes)), random.uniform(-np.pi, np.pi),
        (start, end), (force, choose(random, [force, random.uniform(0.0, 2.0) * force])),
    )  # fmt: skip


def draw_impulse(random: Generator, scene: Scene) -> Impulse:
    """An impulse that turns its bar at up to twice the orbital rate."""
    bar = int(random.integers(1, scene.bars + 1))
    at = int(random.integers(1, scene.run.samples - 1)) / (scene.run.samples - 1)
    largest_N_s = 2.0 * scene.chain.inertia_kg_m2[bar - 1] * scene.orbital_rate_rad_s / scene.chain.length_m[bar - 1]
    return Impulse(
        bar, choose(random, list(End)), choose(random, list(Axes)), random.uniform(-np.pi, np.pi),
        largest_N_s * random.uniform(0.1, 2.0), on_sample(at * scene.run.duration_s, scene.times_s),
    )  # fmt: skip


def moment(random: Generator, scene: Scene, share: float) -> float:
    """Instant of the run: on the nearest sample, mostly, as equal steps ask for it."""
    exact = share * scene.run.duration_s
    if random.random() < 0.2:
        return float(exact)
    times = scene.times_s
    return float(times[np.abs(times - exact).argmin()])


def log_uniform(random: Generator, limits: tuple[float, float]) -> float:
    """Number whose logarithm is uniform."""
    low, high = np.log(limits)
    return float(np.exp(random.uniform(low, high)))


def choose(random: Generator, among: list[T]) -> T:
    """One of several."""
    return among[int(random.choice(len(among)))]


def listed(values: Array) -> tuple[float, ...]:
    """Values as plain floats."""
    return tuple(float(v) for v in values)
