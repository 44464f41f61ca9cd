"""Errors of Exudyn's multipliers that do not depend on the step's order: derived here and declared to the judge."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.departure import departure
from adapters.exudyn.effects import jumps_s

if TYPE_CHECKING:
    from adapters.exudyn.solver import Method
    from adapters.trajectory import Array
    from scenarios import Scene

DIFFERENCING = 1e-8  # Exudyn's increment in (C_q q')_q relative to `minimumCoordinateSize` or the coordinate
BARS_OF_A_JOINT = 2.0  # both are differenced; together they cause up to 1.3 times one bar's share in 300 random chains
TRANSIENT = 4.0  # error of index 3's first multipliers over h w times the chain's inertia forces; measured up to 2
TREE_ROUNDINGS = 16.0  # a few for each entry of the tree's mass matrix
ELIMINATION = 2.0  # roundings of the mass matrix's largest entry: one in elimination, one in back substitution
DISPLACED_ACCELERATION = (
    7.0  # of a constant push along the orbit: the largest acceleration against the frame, 4 cos(nt) - 3
)
LAW_PEAK = 18.0 / 16.0  # bound of the law's second derivative, eq. (28), over its amplitude and (pi/t_m)²
ACCUMULATION = 4.0  # of a residual's noise: successive steps' add up while they are being damped
ACCUMULATION_ABSOLUTE = (
    10.0  # the same in absolute coordinates, where Newton often accepts its first guess; measured: 9
)


def engine_noise(scene: Scene, step_s: float, method: Method, t_s: Array) -> dict[str, float | Array]:
    """Errors beyond the method's own: ``reaction``, ``torque`` (n,), ``attitude``, ``rate``, and ``gap`` at index 3.

    *Index 2* needs (C_q q')_q, which Exudyn differences forward. The error is half the second derivative times the
    increment: DIFFERENCING min(coordinate size) of l w² across each of a joint's two bars. A force of m l w² for each
    bar makes up for the error, or of J w²/l where a bar's inertia resists its rotation. Newton stops at a residual, a
    velocity at index 2. Accelerations are then wrong by residual/h, a few times over, as the trapezoidal rule has no
    damping.

    *Index 3.* The residual is a position (and so a gap): over h for velocities, over h² for forces. Generalized-alpha
    damps it by rho per step only, so that 1/(1 - rho) of them add up. The first multipliers have an error of first
    order in the step. Its three stiff roots are all rho: the transient decays as (1 + n (1 - rho))² rho^n in n steps. A
    manoeuvre's start or end excites it again, smaller by one order of h w: the law's fourth derivative jumps there, so
    that the multipliers and their first derivative are continuous. A thrust's start or end restarts the run, and so the
    transient.

    *Torques.* Newton also accepts torques that are wrong by the residual. A bar's angular acceleration is then wrong by
    residual/J with constant sign for about a radian of the motion, and its angle by residual/(J w²). In absolute
    coordinates the residual is as large as the round-off of velocities of kilometres a second, which turns small bars
    noticeably.

    Parameters
    ----------
    scene : Scene
    step_s : float
    method : Method
    t_s : ndarray, shape (n,)
    """
    chain, mass, length = scene.chain, max(scene.chain.mass_kg), max(scene.chain.length_m)
    rate = scene.fastest_rate_rad_s
    differenced = BARS_OF_A_JOINT * DIFFERENCING * max(method.difference_m, 1.0)
    force = np.full(len(t_s), differenced * turning_mass(scene) * rate**2)
    slow = 2.0 * math.pi / scene.step_period_s  # gravity's torques go with the orbit
    wrong = method.residual_N / min(chain.inertia_kg_m2)
    turned: Array = np.minimum(wrong * t_s**2, wrong / slow**2)
    wrong_rate: Array = np.minimum(wrong * t_s, wrong / slow)
    if not method.index3:
        piles_up = ACCUMULATION_ABSOLUTE if method.absolute else ACCUMULATION
        force += piles_up * mass * method.residual_N / step_s
        rate_noise = ACCUMULATION * method.residual_N / min(chain.length_m) + wrong_rate
        lever = scene.size_m if method.absolute else length  # it takes up the forces of all joints beyond
        return {"reaction": force, "torque": force * lever, "rate": rate_noise, "attitude": turned}
    force += ACCUMULATION * mass * method.residual_N / step_s**2 / (1.0 - method.spectral_radius)
    transient = transients(scene, step_s, method, t_s)
    residual = ACCUMULATION * method.residual_N / (min(chain.length_m) * step_s)
    return {
        "reaction": force + transient,
        "torque": (force + transient) * length,
        # change of the chain's rates by one step of the transient
        "rate": residual + transient * step_s / (mass * scene.size_m) + wrong_rate,
        "attitude": turned,
        "gap": ACCUMULATION * method.residual_N,
    }


def turning_mass(scene: Scene, length_m: float | None = None) -> float:
    """Largest force of inertia at a joint over w², kg m: m l, or J/l of a bar with a large moment of inertia.

    `length_m` replaces l in the first expression; the longest bar by default.
    """
    chain = scene.chain
    turning = max(j / length for j, length in zip(chain.inertia_kg_m2, chain.length_m, strict=True))
    return max(max(chain.mass_kg) * (length_m or max(chain.length_m)), turning)


def transients(scene: Scene, step_s: float, method: Method, t_s: Array) -> Array:
    """Bound of index 3's transients, at the start and at each end of a manoeuvre, (n,), N.

    At the start no manoeuvre has an acceleration yet: the forces are those of the free motion. A manoeuvre turns one
    bar and moves the ends of its neighbours.
    """
    chain = scene.chain
    rate = max(2.0 * math.pi / scene.step_period_s, scene.orbital_rate_rad_s * max(1.0, *map(abs, chain.rate_factor)))
    thrusts = scene.effects.thrust
    if thrusts:
        rate = max(rate, thrust_rate_rad_s(scene))
    force_N = turning_mass(scene, scene.size_m) * rate**2
    found = start_transient(force_N, rate, step_s, method, t_s)
    for start in jumps_s(scene) if thrusts else ():
        found = np.maximum(found, start_transient(force_N, rate, step_s, method, t_s - start))
    for p in scene.effects.prescribed_rotation:
        own, rate = p.bar - 1, math.pi / p.duration_s
        moved = max(chain.mass_kg[max(own - 1, 0) : own + 2]) * chain.length_m[own]
        turning = max(moved, chain.inertia_kg_m2[own] / chain.length_m[own])
        force_N = turning * LAW_PEAK * abs(p.amplitude_rad) * rate**2
        for start in p.breaks_s:
            again = start_transient(force_N * step_s * rate, rate, step_s, method, t_s - start)
            found = np.maximum(found, again)
    return found


def thrust_rate_rad_s(scene: Scene) -> float:
    """Rate at which the strongest thrust, normal to its bar, turns the bar by a radian."""
    chain = scene.chain
    return max(
        math.sqrt(max(map(abs, p.force_N)) * 0.5 * chain.length_m[p.bar - 1] / chain.inertia_kg_m2[p.bar - 1])
        for p in scene.effects.thrust
    )


def start_transient(force_N: float, rate_rad_s: float, step_s: float, method: Method, t_s: Array) -> Array:
    """Bound of the error of index 3's first multipliers and its decay, (n,), N; zero before the start."""
    n, rho = np.maximum(t_s / step_s, 0.0), method.spectral_radius
    bound = TRANSIENT * step_s * rate_rad_s * force_N * (1.0 + n * (1.0 - rho)) ** 2 * rho**n
    return np.where(t_s < -step_s, 0.0, bound)


def tree_noise(scene: Scene) -> float:
    """Error of the reactions from a tree's accelerations, N.

    The accelerations come from a dense mass matrix in joint coordinates, whose condition number grows at least as N³.
    Its entries range from the chain's mass to its moment of inertia about the first end, in SI units. Elimination
    leaves a residual of the largest entry times the largest acceleration in every row, including the rows of forces.
    Measured: 2e-10 N relative to a rounding of 9e-10 N on effects/oblateness, 6e-10 N relative to 4e-10 N on
    effects/tip_masses.
    """
    chain, rate = scene.chain, scene.fastest_rate_rad_s
    force = turning_mass(scene, scene.size_m) * rate**2
    ends = np.cumsum(chain.length_m)
    inertia = float(
        np.sum(np.array(chain.mass_kg) * (ends - 0.5 * np.array(chain.length_m)) ** 2 + chain.inertia_kg_m2)
    )
    acceleration = scene.size_m * rate**2 + DISPLACED_ACCELERATION * departure(scene).acceleration_m_s2
    residual = float(np.finfo(float).eps) * ELIMINATION * inertia * acceleration
    return residual + float(np.finfo(float).eps) * TREE_ROUNDINGS * scene.bars**3 * force
