"""Random scenes with extreme parameters, to find failures of the reference."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from scenarios.effect_types import Actuator, Effects, Frame, Gravity, JointSpringDamper, PrescribedRotation
from scenarios.scene import CentralBody, Chain, Orbit, Run, Scene

if TYPE_CHECKING:
    from numpy.random import Generator

    from adapters.trajectory import Array

EARTH = CentralBody(3.986004418e14, 6378e3)
MOST_BARS = 12
MOTION_RAD = 60.0  # of the fastest motion of a scene: some hundreds of steps for every scene
SAMPLES = 21
MIN_ALTITUDE_OVER_LENGTH = 1.1  # heights over the chain's length
SLEW_SHARE = (1e-3, 1.0)  # duration of a slew over that of the run
SLEW_LIMIT = 0.25  # of the angle that the fastest motion covers during the slew; the draw multiplies it by up to 2
EFFECT_SHARE = 0.25  # of the scenes have springs; the same share has prescribed rotations


def draw(seed: int) -> Scene:
    """Random scene of a seed, independent of barchain's version.

    Bars of 1e-6 to 1e4 m, masses up to 1e8 apart, moments of inertia down to 1e-8 of a uniform bar's, spins up to 1e4
    times the orbit's rate, starts from rest to twice the escape speed, straight, folded and any other chains, all
    models of gravity, springs and dampers, prescribed rotations.
    """
    random = np.random.default_rng(seed)
    gravity = Gravity(random.choice([str(g) for g in Gravity]))
    chain = draw_chain(random, gravity)
    size = math.fsum(chain.length_m)
    altitude = max(MIN_ALTITUDE_OVER_LENGTH * size, 10.0 ** random.uniform(4.0, 9.0))
    orbit = Orbit(altitude, float(draw_speed(random)), float(random.uniform(-np.pi, np.pi)))
    name, title = f"random/{seed}", f"Random scene {seed}"
    base = Scene(name, title, "drawn", "", (), EARTH, orbit, chain, Effects(gravity), Run(1.0, SAMPLES))
    springs = draw_springs(random, base)
    duration = MOTION_RAD / fastest_rad_s(base, Effects(gravity, joint_spring_damper=springs))
    laws = draw_laws(random, base, duration)
    effects = Effects(gravity, prescribed_rotation=laws, joint_spring_damper=springs)
    return replace(base, effects=effects, run=Run(duration, SAMPLES))


def draw_speed(random: Generator) -> float:
    """Speed over the circular speed: now and then exactly at rest, circular or parabolic."""
    return float(random.choice([0.0, 1.0, math.sqrt(2.0), random.uniform(0.0, 3.0), random.uniform(0.9, 1.1)]))


def draw_chain(random: Generator, gravity: Gravity) -> Chain:
    """Bars of any sizes and shapes."""
    n = int(random.integers(1, MOST_BARS + 1))
    typical = 10.0 ** random.uniform(-6.0, 4.0)
    length = typical * 10.0 ** random.uniform(-1.0, 0.0, n)
    mass = 10.0 ** random.uniform(-3.0, 5.0) * mass_factors(random, n)
    compact = np.ones(n) if gravity is Gravity.SLENDER else 10.0 ** -random.choice([0.0, random.uniform(0.0, 8.0)])
    inertia = mass * length**2 / 12.0 * compact
    return Chain(
        tuple(mass.tolist()),
        tuple(length.tolist()),
        tuple(inertia.tolist()),
        tuple(draw_angles(random, n).tolist()),
        str(random.choice(["chain", "bar"])) if typical < 1e3 else "chain",
        tuple(draw_rates(random, n).tolist()),
    )


def mass_factors(random: Generator, bars: int) -> Array:
    """Factors of the masses: alike, of one order, or up to 1e8 apart."""
    decades = random.choice([0.0, 1.0, 8.0])
    found: Array = 10.0 ** (decades * random.uniform(-0.5, 0.5, bars))
    return found


def draw_angles(random: Generator, bars: int) -> Array:
    """Initial angles: random, straight, along an axis, or folded."""
    kind, one = random.integers(4), random.uniform(-np.pi, np.pi)
    kinds = (
        random.uniform(-np.pi, np.pi, bars),
        np.full(bars, one),
        np.full(bars, random.choice([0.0, 0.5 * np.pi])),
        one + np.pi * (np.arange(bars) % 2),
    )
    found: Array = np.asarray(kinds[kind], float)
    return found


def draw_rates(random: Generator, bars: int) -> Array:
    """Initial rates over the orbital rate: 1, 0, random, or fast in equal or alternating senses."""
    kind, fast = random.integers(5), 10.0 ** random.uniform(0.0, 4.0)
    kinds = (
        np.ones(bars),
        np.zeros(bars),
        random.uniform(-3.0, 3.0, bars),
        np.full(bars, fast),
        fast * (-1.0) ** np.arange(bars),
    )
    found: Array = np.asarray(kinds[kind], float)
    return found


def draw_springs(random: Generator, scene: Scene) -> JointSpringDamper | None:
    """Springs and dampers in one scene of four, within a factor of 1e3 of the other torques on the bars."""
    joints = scene.bars - 1
    if joints == 0 or random.random() > EFFECT_SHARE:
        return None
    rate = fastest_rad_s(scene, scene.effects)
    inertia = min(scene.chain.inertia_kg_m2)
    stiffness = inertia * rate**2 * 10.0 ** random.uniform(-3.0, 3.0, joints)
    damping = inertia * rate * 10.0 ** random.uniform(-3.0, 3.0, joints) * random.choice([0.0, 1.0])
    rest = random.uniform(-0.1, 0.1, joints) + np.diff(scene.chain.angle_rad)
    return JointSpringDamper(tuple(stiffness.tolist()), tuple(damping.tolist()), tuple(rest.tolist()))


def draw_laws(random: Generator, scene: Scene, duration_s: float) -> tuple[PrescribedRotation, ...]:
    """External prescribed rotations in one scene of four, slow enough that no joint accelerates a bar without end."""
    if random.random() > EFFECT_SHARE:
        return ()
    count = int(random.integers(1, min(scene.bars, 3) + 1))
    turned = sorted(random.choice(scene.bars, size=count, replace=False).tolist())
    most_rad = MOTION_RAD / rate_amplification(scene)
    return tuple(draw_law(random, bar + 1, duration_s, most_rad=most_rad) for bar in turned)


def draw_law(random: Generator, bar: int, duration_s: float, *, most_rad: float) -> PrescribedRotation:
    """Slew over a share of the run, at a mean rate of at most half of that which turns a bar by `most_rad` in the run.

    The largest rate of the law is 12 pi/16 = 2.36 times its mean.
    """
    low, high = np.log10(SLEW_SHARE)
    share = 10.0 ** random.uniform(low, high)
    amplitude = random.uniform(-2.0, 2.0) * min(1.0, SLEW_LIMIT * share * most_rad)
    return PrescribedRotation(
        bar,
        float(amplitude),
        float(duration_s * share),
        float(duration_s * random.uniform(0.0, 0.9)),
        Frame(random.choice([str(f) for f in Frame if f.of_bar])),
        Actuator.EXTERNAL,
    )


def fastest_rad_s(scene: Scene, effects: Effects) -> float:
    """Estimate of the fastest rate in a scene, rad/s: orbit, bars, compact or unequal bars in their joints, springs."""
    orbit = math.sqrt(scene.central_body.mu_m3_s2 / scene.radius0_m**3)
    spin = max(abs(a) for a in scene.chain.rate_factor) * scene.orbital_rate_rad_s
    springs = 0.0
    if effects.joint_spring_damper is not None:
        springs = replace(scene, effects=effects).spring_rate_rad_s
    return max(orbit, spin) * rate_amplification(scene) + springs


def rate_amplification(scene: Scene) -> float:
    """Largest rate of a single bar, with all of the chain's energy, relative to the chain's rate."""
    if scene.bars == 1:
        return 1.0
    chain = scene.chain
    largest = max(0.25 * length**2 / j for length, j in zip(chain.length_m, chain.inertia_kg_m2, strict=True))
    return math.sqrt(1.0 + largest * math.fsum(chain.mass_kg))
