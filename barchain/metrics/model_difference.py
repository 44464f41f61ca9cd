"""How far the centre of mass of a chain leaves the orbit of a particle: the model difference of CM-only engines.

Each bar is pulled where it is, so the mean pull differs from the pull at the centre of mass by
O((L/r)²). To first order the track is displaced by

    delta'' = G(Z0) delta + (g_mean - g(Z0)),   G = mu/r³ (3 r̂ r̂ᵀ - I),

driven along the truth's own attitude. It is independent of the engine judged by it. Oblateness and third bodies have
their shares in the mean pull and in G; the force on the bars' second moments, of the same order (l/r)² of gravity as
what their places do, is in the mean pull, and what it changes of G, (l/r)² of that, is left out. What is no field
(drag, light, thrust, a blow) is taken to push a particle as it pushes the chain, and so is not in the displacement; in
how the track answers to the attitude it is. There the change of drag with place and velocity is left out of G: a/H and
a/v of a drag a against the orbit's own 1/s², a thousandth where the air is as thin as an orbit needs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline

from adapters.common.initial_state import chain_model
from barchain.metrics.mean_acceleration import PUSHES, blows_along, every_nth, pull_along, tides
from reference_impl.model.kinematics import relative_positions
from scenarios import Gravity

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from barchain.metrics.mean_acceleration import Pull, TidalGradient
    from scenarios import Scene

RESPONSE_STEPS_PER_RADIAN = 60.0  # of the orbit: the chain's own oscillations are up to ten times as fast
PUSHED_STEPS_PER_RADIAN = 20.0  # of the fastest bar, where a push goes with its direction and has kinks in it
SPARSE_RAD = 1.0  # of the orbit between samples: farther apart, nothing can be interpolated, and all is bounded
PULLED, TURNED = 3.0, 9.0
"""Times mu I/(M r⁴), I about the centre of the stretched chain: the largest pull that a second moment adds, upright,
and its largest change per radian, 9/2 where the chain turns as one and twice that where its joints turn too"""
QUADRATURE_RTOL = 1e-6  # of the displacement; far below what interpolating the attitude leaves


@dataclass(frozen=True)
class Displacement:
    """Predicted departure of the chain's centre of mass from a particle's track; n samples."""

    vector_m: Array
    """(n, 2)"""
    uncertainty_m: Array
    """(n,), never falling: interpolation, and the second order left out"""
    vector_m_s: Array
    """(n, 2) its time derivative"""
    uncertainty_m_s: Array
    """(n,), never falling, alike"""


def com_displacement(scene: Scene, solution: Trajectory) -> Displacement:
    """Displacement of the chain's centre of mass from a particle's track, and its time derivative.

    Its uncertainty is the change on halving the samples used (a bound for cubic interpolation, whose
    error falls 16 times), and the second order of the field it is carried in, the only one left out: the
    displacement times its own size over r, amplified as Kepler motion does, 1 + 3 n t; in velocities that
    counts at the orbit's rate. Where samples are too far apart to be interpolated, nothing is predicted: all of it
    is uncertain.
    """
    n = len(solution.t_s)
    if not pulled_apart(scene, solution):
        return Displacement(np.zeros((n, 2)), np.zeros(n), np.zeros((n, 2)), np.zeros(n))
    if sparse(scene, solution):
        most = bounded(scene, solution.t_s, PULLED)
        return Displacement(np.zeros((n, 2)), most["com"], np.zeros((n, 2)), most["com_velocity"])
    full = integrate(scene, solution, 1)
    coarse = integrate(scene, solution, 2) if n > 4 else np.zeros_like(full)
    interpolation = np.maximum.accumulate(np.linalg.norm((full - coarse).reshape(n, 2, 2), axis=2))
    size = np.maximum.accumulate(np.linalg.norm(full[:, :2], axis=1))
    distance = np.linalg.norm(solution.com_m, axis=1)
    rate = float((np.linalg.norm(solution.com_velocity_m_s, axis=1) / distance).max())
    amplification = 1.0 + 3.0 * scene.orbital_rate_rad_s * solution.t_s
    second_order = size * size / distance.min() * amplification
    return Displacement(
        full[:, :2], interpolation[:, 0] + second_order, full[:, 2:], interpolation[:, 1] + rate * second_order
    )


def track_response(scene: Scene, solution: Trajectory, aside: Trajectory) -> dict[str, Array]:
    """How far the centre of mass of a twin goes aside: ``com`` (m), ``com_velocity`` (m/s), each (n,).

    The difference of the two displacements, integrated as one: that of the two tracks themselves drowns in
    their own errors, which are larger than what an attitude 1e-10 rad aside can do.
    """
    n = min(len(solution.t_s), len(aside.t_s))
    struck = any(e.name in PUSHES for e in chain_model(scene).effects) or scene.effects.impulse
    if solution.angle_rad is None or aside.angle_rad is None or not (pulled_apart(scene, solution) or struck):
        return {"com": np.zeros(n), "com_velocity": np.zeros(n)}
    t = solution.t_s[:n]
    if sparse(scene, solution) and not struck:
        aside_rad = np.maximum.accumulate(np.abs(solution.angle_rad[:n] - aside.angle_rad[:n]).max(axis=1))
        return {name: aside_rad * size for name, size in bounded(scene, t, TURNED).items()}
    count = math.ceil((t[-1] - t[0]) * 2.0 * math.pi / scene.step_period_s * RESPONSE_STEPS_PER_RADIAN)
    if struck and solution.rate_rad_s is not None:
        count = max(
            count, math.ceil((t[-1] - t[0]) * float(np.abs(solution.rate_rad_s).max()) * PUSHED_STEPS_PER_RADIAN)
        )
    pulls = [pull_along(scene, each, 1, pushed=True) for each in (solution, aside)]
    times, seen = walk(scene, solution, pulls, max(count, 1), kicks(scene, solution, aside))
    apart = {"com": seen[:, :2], "com_velocity": seen[:, 2:]}
    return {name: np.interp(t, times, np.linalg.norm(d, axis=1)) for name, d in apart.items()}


def sparse(scene: Scene, solution: Trajectory) -> bool:
    """Whether samples of an orbit that returns are too far apart to be interpolated."""
    spacing = (solution.t_s[-1] - solution.t_s[0]) / max(1, len(solution.t_s) - 1)
    return scene.bound and bool(spacing * 2.0 * math.pi / scene.step_period_s > SPARSE_RAD)


def bounded(scene: Scene, t_s: Array, factor: float) -> dict[str, Array]:
    """Bound of what a pull of at most `factor` mu I/(M r⁴) moves: ``com`` (m), ``com_velocity`` (m/s), each (n,).

    A constant pull a along the track moves 3/2 a t² and swings by 8 a/n² beside it; what it moves goes round with n.
    """
    model = chain_model(scene)
    place = relative_positions(model, np.zeros(model.bars))[:, 0]
    inertia = float(model.mass_kg @ place**2 + model.inertia_kg_m2.sum())
    r0 = scene.radius0_m
    lowest = min(r0, 2.0 * r0 / (2.0 - scene.orbit.speed_factor**2) - r0)
    pull = factor * scene.central_body.mu_m3_s2 * inertia / (scene.mass_kg * lowest**4)
    rate = math.sqrt(scene.central_body.mu_m3_s2 / lowest**3)
    moved_m = pull * (1.5 * t_s**2 + 8.0 / scene.mean_motion_rad_s**2)
    return {"com": moved_m, "com_velocity": rate * moved_m}


def kicks(scene: Scene, solution: Trajectory, aside: Trajectory) -> list[tuple[float, Array]]:
    """Instants of blows, and how much more velocity (2,) they give to the centre of mass of a twin, m/s."""
    both = zip(blows_along(scene, solution), blows_along(scene, aside), strict=True)
    return [(at_s, other - jump) for (at_s, jump), (_, other) in both]


def walk(
    scene: Scene, solution: Trajectory, pulls: list[Pull], steps: int, jumps: list[tuple[float, Array]]
) -> tuple[Array, Array]:
    """Instants, and what the second pull moves beyond the first, (steps + 1, 4): Runge and Kutta's equal steps.

    A method that chooses its steps would chase the rounding of a difference of two pulls. Velocities jump at the
    start of the step that `jumps` fall in.
    """
    acting = tides(scene)
    com = CubicHermiteSpline(solution.t_s, solution.com_m, solution.com_velocity_m_s)
    times = np.linspace(solution.t_s[0], solution.t_s[-1], 2 * steps + 1)  # with the middles
    places = com(times)
    forced = [pulls[1](t, z) - pulls[0](t, z) for t, z in zip(times, places, strict=True)]
    h, y, seen = times[2] - times[0], np.zeros(4), [np.zeros(4)]
    for k in range(0, 2 * steps, 2):
        for jump in (jump for at_s, jump in jumps if times[k] <= at_s < times[k + 2]):
            y = y + np.append(np.zeros(2), jump)
        a = moved(acting, times[k], places[k], forced[k], y)
        b = moved(acting, times[k + 1], places[k + 1], forced[k + 1], y + 0.5 * h * a)
        c = moved(acting, times[k + 1], places[k + 1], forced[k + 1], y + 0.5 * h * b)
        d = moved(acting, times[k + 2], places[k + 2], forced[k + 2], y + h * c)
        y = y + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
        seen.append(y)
    return times[::2], np.array(seen)


def pulled_apart(scene: Scene, solution: Trajectory) -> bool:
    """Whether the bars' places matter to the centre of mass."""
    return scene.effects.gravity is not Gravity.NONE and solution.angle_rad is not None


def moved(acting: list[TidalGradient], t_s: float, place_m: Array, pull_m_s2: Array, y: Array) -> Array:
    """Time derivative of a displacement and its velocity, (4,)."""
    tide = sum((tide(t_s, place_m, y[:2]) for tide in acting), np.zeros(2))
    return np.concatenate([y[2:], tide + pull_m_s2])


def integrate(scene: Scene, solution: Trajectory, every: int) -> Array:
    """Displacement and its velocity, (n, 4), along the truth through every `every`-th sample."""
    acting, t, pull = tides(scene), solution.t_s, pull_along(scene, solution, every)
    knots = every_nth(len(t), every)
    com = CubicHermiteSpline(t[knots], solution.com_m[knots], solution.com_velocity_m_s[knots])

    def rhs(time: float, y: Array) -> Array:
        z = com(time)
        return moved(acting, time, z, pull(time, z), y)

    length_unit = scene.size_m**2 / scene.radius0_m
    scales = np.array([1.0, 1.0, scene.mean_motion_rad_s, scene.mean_motion_rad_s]) * length_unit
    found = solve_ivp(
        rhs,
        (t[0], t[-1]),
        np.zeros(4),
        method="DOP853",
        t_eval=t,
        rtol=QUADRATURE_RTOL,
        atol=QUADRATURE_RTOL * scales,
    )
    displacement: Array = found.y.T
    return displacement
