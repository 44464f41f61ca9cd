"""Errors of Exudyn's multipliers that do not depend on the step's order: derived here and declared to the judge."""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import lfilter

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
    16.0  # the same in absolute coordinates, where Newton accepts some of its first guesses; measured: 13
)
DEVIATIONS = 4.0  # standard deviations: one sample of a normal distribution in 16 000 is farther out
UNIFORM = 1.0 / math.sqrt(3.0)  # standard deviation of a uniform distribution over its half width
ROUNDED_PLACES = math.sqrt(2.0)  # a joint joins the places of two bars, each rounded
SOME_GUESSES = 4.0  # of the tolerance: where forces change by less in a step, lighter bars' change by less than it
RESPONSE_STEPS = 1000  # after which the response of generalized-alpha has decayed: rho^1000 is 1e-46


def engine_noise(scene: Scene, step_s: float, method: Method, t_s: Array) -> dict[str, float | Array]:
    """Errors beyond the method's own: ``reaction``, ``torque`` (n,), ``attitude``, ``rate``, and ``gap`` at index 3.

    *Index 2* needs (C_q q')_q, which Exudyn differences forward. The error is half the second derivative times the
    increment: DIFFERENCING min(coordinate size) of l w² across each of a joint's two bars. A force of m l w² for each
    bar makes up for the error, or of J w²/l where a bar's inertia resists its rotation. Newton stops at a residual, a
    velocity at index 2. Accelerations are then wrong by residual/h, a few times over, as the trapezoidal rule has no
    damping. Where Newton accepts every first guess (:func:`change_in_step`), each step leaves a velocity anywhere
    inside the residual. a_n = 2 (v_n - v_n-1)/h - a_n-1 never forgets one, so that they add up as a random walk.

    *Index 3.* The residual is a position (and so a gap): over h for velocities, over h² for forces. Generalized-alpha
    answers errors of successive places with :func:`index3_gain` times their standard deviation, 619 for rho = 0.9.
    Where Newton iterates in each step these are roundings of places; where it accepts some first guesses, they are
    anywhere inside the residual. The residual of a prescribed angle moves the ends of its bar by l/2 times as much.

    The first multipliers have an error of first order in the step. Its three stiff roots are all -rho: the transient
    decays as (1 + n (1 - rho))² rho^n in n steps. A manoeuvre's start or end excites it again, smaller by one order of
    h w: the law's fourth derivative jumps there, so that the multipliers and their first derivative are continuous. A
    thrust's start or end restarts the run, and so the transient.

    Errors of all joints add up in a long chain (:func:`chain_sum`).

    *Torques.* Newton also accepts torques that are wrong by the residual, or by l/2 of it in bars shorter than 2 m: the
    torque of a wrong force at an end, or of a wrong acceleration on J, is that small. A law's own torque is not. A
    bar's angular acceleration is then wrong by residual/J with constant sign for about a radian of the motion, and its
    angle by residual/(J w²). In absolute coordinates the residual is as large as the round-off of velocities of
    kilometres a second, which turns small bars noticeably.

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
    lever_m = 1.0 if scene.effects.prescribed_rotation else min(1.0, 0.5 * length)
    wrong = lever_m * method.residual_N / min(chain.inertia_kg_m2)
    turned: Array = np.minimum(wrong * t_s**2, wrong / slow**2)
    wrong_rate: Array = np.minimum(wrong * t_s, wrong / slow)
    if not method.index3:
        force += index2_sum(scene, step_s, method, t_s) * mass * method.residual_N / step_s
        rate_noise = ACCUMULATION * method.residual_N / min(chain.length_m) + wrong_rate
        lever = scene.size_m if method.absolute else length  # it takes up the forces of all joints beyond
        return {"reaction": force, "torque": force * lever, "rate": rate_noise, "attitude": turned}
    gain = DEVIATIONS * index3_gain(method.spectral_radius) * chain_sum(scene.bars)
    force += gain * mass * place_error_m(scene, step_s, method) / step_s**2
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


def chain_sum(bars: int) -> float:
    """Standard deviation of the largest joint force over that of m a, for independent errors a of N - 1 joints.

    Of a straight chain of equal bars, pulled along its line, the force of joint j from an error of joint k is
    m min(j, k) (N - max(j, k))/N. In the middle the norm over k is N^(3/2)/sqrt(48). Across the line it is smaller.
    """
    return max(1.0, math.sqrt(bars**3 / 48.0))


def change_in_step(scene: Scene, step_s: float, method: Method) -> float:
    """Change of forces in a step, m l w³ h, over Newton's tolerance: below 1 it accepts its first guesses.

    Before and after a manoeuvre the chain turns at the rates that it started with.
    """
    return turning_mass(scene) * free_rate_rad_s(scene) ** 3 * step_s / method.residual_N


def free_rate_rad_s(scene: Scene) -> float:
    """Fastest rate of the free chain: the orbit's, or that of a bar at the start."""
    return max(
        2.0 * math.pi / scene.step_period_s, scene.orbital_rate_rad_s * max(1.0, *map(abs, scene.chain.rate_factor))
    )


def index2_sum(scene: Scene, step_s: float, method: Method, t_s: Array) -> Array:
    """Error of an acceleration over residual/h, (n,).

    A velocity that is off by v in one step changes all later accelerations by 4 v/h, with alternating signs.
    """
    some = np.full(len(t_s), ACCUMULATION_ABSOLUTE if method.absolute else ACCUMULATION)
    if change_in_step(scene, step_s, method) > 1.0:
        return some
    walk: Array = chain_sum(scene.bars) * DEVIATIONS * 4.0 * UNIFORM * np.sqrt(t_s / step_s)
    found: Array = np.maximum(some, walk)
    return found


def place_error_m(scene: Scene, step_s: float, method: Method) -> float:
    """Standard deviation of the error that each step leaves in a joint's place at index 3, m."""
    if change_in_step(scene, step_s, method) <= SOME_GUESSES:
        lever_m = 0.5 * max(scene.chain.length_m) if scene.effects.prescribed_rotation else 0.0
        return UNIFORM * method.residual_N * max(1.0, lever_m)
    rounding_m = 0.5 * float(np.spacing(method.position_m))
    return UNIFORM * min(ROUNDED_PLACES * rounding_m, method.residual_N)


@functools.cache
def index3_gain(spectral_radius: float) -> float:
    """Standard deviation of the acceleration, times h², over that of independent errors of places.

    Newmark's formulas give P(z) a = (z - 1)² q / h², P = beta z² + (1/2 + gamma - 2 beta) z + 1/2 - gamma + beta.
    Generalized-alpha adds ((1 - alpha_f) z + alpha_f) q'' = ((1 - alpha_m) z + alpha_m) a. The multipliers go with q''.
    The gain is the norm of the response to a single error.
    """
    rho = spectral_radius
    alpha_m, alpha_f = (2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)
    gamma = 0.5 - alpha_m + alpha_f
    beta = 0.25 * (0.5 + gamma) ** 2
    newmark = [beta, 0.5 + gamma - 2.0 * beta, 0.5 - gamma + beta]
    single = np.zeros(RESPONSE_STEPS)
    single[0] = 1.0
    response = lfilter(
        np.polymul([1.0, -2.0, 1.0], [1.0 - alpha_m, alpha_m]), np.polymul(newmark, [1.0 - alpha_f, alpha_f]), single
    )
    return float(np.linalg.norm(response))


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
    rate = free_rate_rad_s(scene)
    if scene.effects.tables:
        rate = max(rate, pushed_rate_rad_s(scene))
    force_N = turning_mass(scene, scene.size_m) * rate**2
    found = start_transient(force_N, rate, step_s, method, t_s)
    for start in jumps_s(scene):
        found = np.maximum(found, start_transient(force_N, rate, step_s, method, t_s - start))
    for own, turn in ((p.bar - 1, turn) for p in scene.effects.prescribed_rotation for turn in p.turns):
        rate = math.pi / turn.duration_s
        moved = max(chain.mass_kg[max(own - 1, 0) : own + 2]) * chain.length_m[own]
        turning = max(moved, chain.inertia_kg_m2[own] / chain.length_m[own])
        force_N = turning * LAW_PEAK * turn.reach_rad * rate**2
        for start, passing in zip((turn.start_s, turn.end_s), turn.rates_rad_s, strict=True):
            if passing:  # the next piece of a spline goes on smoothly
                continue
            again = start_transient(force_N * step_s * rate, rate, step_s, method, t_s - start)
            found = np.maximum(found, again)
    return found


def pushed_rate_rad_s(scene: Scene) -> float:
    """Rate at which the strongest thrust, normal to its bar, or torque of a joint's motor turns a bar by a radian."""
    chain, effects = scene.chain, scene.effects
    levers = [max(pair) for pair in zip(chain.left_m, chain.right_m, strict=True)]
    torques = [(p.bar - 1, levers[p.bar - 1] * max(map(abs, p.force_N))) for p in effects.thrust]
    torques += [(p.joint - 1 + k, max(map(abs, p.torque_N_m))) for p in effects.joint_torque for k in (0, 1)]
    return max(math.sqrt(torque / chain.inertia_kg_m2[bar]) for bar, torque in torques)


def start_transient(force_N: float, rate_rad_s: float, step_s: float, method: Method, t_s: Array) -> Array:
    """Bound of the error of index 3's first multipliers and its decay, (n,), N; zero before the start."""
    n, rho = np.maximum(t_s / step_s, 0.0), method.spectral_radius
    bound = TRANSIENT * step_s * rate_rad_s * force_N * (1.0 + n * (1.0 - rho)) ** 2 * rho**n
    return np.where(t_s < -step_s, 0.0, bound)


def tree_noise(scene: Scene) -> float:
    """Error of the reactions from a tree's accelerations, N.

    The accelerations come from a dense mass matrix in joint coordinates. Its condition number grows as the chain's
    moment of inertia about its first end over the least one of a bar: 4 N³ for equal bars, more with a light body at
    an end. Forces lose that many digits. Measured in 80 random chains with end bodies: up to 0.66 of what is declared.
    Its entries range from the chain's mass to its moment of inertia about the first end, in SI units. Elimination
    leaves a residual of the largest entry times the largest acceleration in every row, including the rows of forces.
    Measured: 2e-10 N relative to a rounding of 9e-10 N on effects/oblateness, 6e-10 N relative to 4e-10 N on
    effects/tip_masses.
    """
    chain, rate = scene.chain, scene.fastest_rate_rad_s
    force = turning_mass(scene, scene.size_m) * rate**2
    centres = np.cumsum(chain.length_m) - np.array(chain.right_m)
    inertia = float(np.sum(np.array(chain.mass_kg) * centres**2 + chain.inertia_kg_m2))
    acceleration = scene.size_m * rate**2 + DISPLACED_ACCELERATION * departure(scene).acceleration_m_s2
    residual = float(np.finfo(float).eps) * ELIMINATION * inertia * acceleration
    condition = max(scene.bars**3, inertia / (4.0 * min(chain.inertia_kg_m2)))
    return residual + float(np.finfo(float).eps) * TREE_ROUNDINGS * condition * force
