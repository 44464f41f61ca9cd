"""Displacement of a chain's centre of mass from a particle's orbit: model difference of engines without attitude.

Gravity acts on each bar at its own place, so the mean acceleration differs from that at the centre of mass by
O((L/r)²). To first order the track is displaced by

    delta'' = G(Z0) delta + (g_mean - g(Z0)),   G = mu/r³ (3 r̂ r̂ᵀ - I),

with the attitude of the judging solution. The displacement is independent of the judged engine.

Oblateness and third bodies contribute to the mean acceleration and to G. The force on the bars' second moments is of
the same order (l/r)² of gravity as the effect of their places, and is in the mean acceleration. Its contribution to G,
(l/r)² of G, is neglected.
Drag, solar pressure, thrust and impulses are assumed to accelerate a particle as they accelerate the chain. They are
therefore not in the displacement. They are in the response of the track to the attitude. There the change of drag with
place and velocity is neglected in G: for a drag a it is a/H and a/v, in 1/s², a thousandth of the orbit's own terms
where the air is thin enough for an orbit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline

from adapters.common.initial_state import chain_model
from barchain.metrics.mean_acceleration import (
    NON_FIELD_EFFECTS,
    every_nth,
    excess_acceleration,
    impulse_velocities,
    tides,
)
from reference_impl.model.kinematics import relative_positions
from scenarios import Gravity

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from barchain.metrics.mean_acceleration import AccelerationField, TidalGradient
    from scenarios import Scene

RESPONSE_STEPS_PER_RADIAN = 60.0  # of the orbit: oscillations of the chain are up to ten times as fast
PUSHED_STEPS_PER_RADIAN = 20.0  # of the fastest bar, whose direction decides the force and its kinks
SPARSE_RAD = 1.0  # of the orbit between samples: beyond it nothing is interpolated, and the displacement is bounded
SECOND_MOMENT_ACCELERATION, SECOND_MOMENT_SENSITIVITY = 3.0, 9.0
"""Over mu I/(M r⁴), I about the centre of the stretched chain: the largest acceleration by a second moment, upright,
and its largest change per radian: 9/2 for a chain that turns as one body, twice that for joints that turn too"""
QUADRATURE_RTOL = 1e-10  # of the displacement of a chain along the radius; far below what interpolation leaves


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

    The uncertainty has two parts. One is the change on halving the samples, a bound for cubic interpolation, whose
    error falls 16 times. The other is the second order of the field, which is neglected: the displacement times its
    size over r, amplified by Kepler motion, 1 + 3 n t; in velocities it is multiplied by the orbit's rate.
    With samples too sparse for interpolation the displacement is zero, and its uncertainty a bound.
    """
    n = len(solution.t_s)
    if not has_extended_gravity(scene, solution):
        return Displacement(np.zeros((n, 2)), np.zeros(n), np.zeros((n, 2)), np.zeros(n))
    if sparse(scene, solution):
        most = displacement_bound(scene, solution.t_s, SECOND_MOMENT_ACCELERATION)
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


def track_response(scene: Scene, solution: Trajectory, perturbed: Trajectory) -> dict[str, Array]:
    """Departure of a perturbed run's centre of mass: ``com`` (m), ``com_velocity`` (m/s), each (n,).

    The difference of the two displacements is integrated directly. The difference of the two tracks is smaller than
    their errors: the attitudes differ by 1e-10 rad only.
    """
    n = min(len(solution.t_s), len(perturbed.t_s))
    driven = any(e.name in NON_FIELD_EFFECTS for e in chain_model(scene).effects) or scene.effects.impulse
    if (
        solution.angle_rad is None
        or perturbed.angle_rad is None
        or not (has_extended_gravity(scene, solution) or driven)
    ):
        return {"com": np.zeros(n), "com_velocity": np.zeros(n)}
    t = solution.t_s[:n]
    if sparse(scene, solution) and not driven:
        perturbation_rad = np.maximum.accumulate(np.abs(solution.angle_rad[:n] - perturbed.angle_rad[:n]).max(axis=1))
        return {
            name: perturbation_rad * size
            for name, size in displacement_bound(scene, t, SECOND_MOMENT_SENSITIVITY).items()
        }
    count = math.ceil((t[-1] - t[0]) * 2.0 * math.pi / scene.step_period_s * RESPONSE_STEPS_PER_RADIAN)
    if driven and solution.rate_rad_s is not None:
        count = max(
            count, math.ceil((t[-1] - t[0]) * float(np.abs(solution.rate_rad_s).max()) * PUSHED_STEPS_PER_RADIAN)
        )
    accelerations = [excess_acceleration(scene, each, 1, include_non_fields=True) for each in (solution, perturbed)]
    times, seen = integrate_difference(
        scene, solution, accelerations, max(count, 1), impulse_differences(scene, solution, perturbed)
    )
    apart = {"com": seen[:, :2], "com_velocity": seen[:, 2:]}
    return {name: np.interp(t, times, np.linalg.norm(d, axis=1)) for name, d in apart.items()}


def sparse(scene: Scene, solution: Trajectory) -> bool:
    """Whether the samples of a bound orbit are too far apart for interpolation."""
    spacing = (solution.t_s[-1] - solution.t_s[0]) / max(1, len(solution.t_s) - 1)
    return scene.bound and bool(spacing * 2.0 * math.pi / scene.step_period_s > SPARSE_RAD)


def displacement_bound(scene: Scene, t_s: Array, factor: float) -> dict[str, Array]:
    """Bound of the displacement by an acceleration of at most `factor` mu I/(M r⁴), at `t_s`.

    ``com`` (m) and ``com_velocity`` (m/s) are (n,). A constant acceleration a along the track displaces by 3/2 a t²
    along it, and by up to 8 a/n² across; the displacement rotates with the rate n. The least radius is that of the
    perigee, or the surface, where a run ends.
    """
    model = chain_model(scene)
    place = relative_positions(model, np.zeros(model.bars))[:, 0]
    inertia = float(model.mass_kg @ place**2 + model.inertia_kg_m2.sum())
    r0 = scene.radius0_m
    lowest = max(min(r0, 2.0 * r0 / (2.0 - scene.orbit.speed_factor**2) - r0), scene.central_body.radius_m)
    acceleration = factor * scene.central_body.mu_m3_s2 * inertia / (scene.mass_kg * lowest**4)
    rate = math.sqrt(scene.central_body.mu_m3_s2 / lowest**3)
    moved_m = acceleration * (1.5 * t_s**2 + 8.0 / scene.mean_motion_rad_s**2)
    return {"com": moved_m, "com_velocity": rate * moved_m}


def impulse_differences(scene: Scene, solution: Trajectory, perturbed: Trajectory) -> list[tuple[float, Array]]:
    """Instants of impulses, s, and the additional velocity that they give to a perturbed run, (2,) m/s."""
    both = zip(impulse_velocities(scene, solution), impulse_velocities(scene, perturbed), strict=True)
    return [(at_s, other - velocity_step) for (at_s, velocity_step), (_, other) in both]


def integrate_difference(
    scene: Scene,
    solution: Trajectory,
    accelerations: list[AccelerationField],
    steps: int,
    velocity_steps: list[tuple[float, Array]],
) -> tuple[Array, Array]:
    """Instants, and displacement by the difference of two accelerations, (steps + 1, 4), by fourth-order Runge-Kutta.

    Steps are equal: step control would follow the round-off of the difference. Velocities jump at the start of the
    step that holds the instant of an entry of `velocity_steps`.
    """
    acting = tides(scene)
    com = CubicHermiteSpline(solution.t_s, solution.com_m, solution.com_velocity_m_s)
    times = np.linspace(solution.t_s[0], solution.t_s[-1], 2 * steps + 1)  # with the middles
    places = com(times)
    forced = [accelerations[1](t, z) - accelerations[0](t, z) for t, z in zip(times, places, strict=True)]
    h, y, seen = times[2] - times[0], np.zeros(4), [np.zeros(4)]
    for k in range(0, 2 * steps, 2):
        for velocity_step in (
            velocity_step for at_s, velocity_step in velocity_steps if times[k] <= at_s < times[k + 2]
        ):
            y = y + np.append(np.zeros(2), velocity_step)
        a = displacement_rate(acting, times[k], places[k], forced[k], y)
        b = displacement_rate(acting, times[k + 1], places[k + 1], forced[k + 1], y + 0.5 * h * a)
        c = displacement_rate(acting, times[k + 1], places[k + 1], forced[k + 1], y + 0.5 * h * b)
        d = displacement_rate(acting, times[k + 2], places[k + 2], forced[k + 2], y + h * c)
        y = y + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
        seen.append(y)
    return times[::2], np.array(seen)


def has_extended_gravity(scene: Scene, solution: Trajectory) -> bool:
    """Whether the places of the bars change the acceleration of the centre of mass."""
    return scene.effects.gravity is not Gravity.NONE and solution.angle_rad is not None


def displacement_rate(
    acting: list[TidalGradient], t_s: float, place_m: Array, acceleration_m_s2: Array, y: Array
) -> Array:
    """Time derivative of a displacement and its velocity, (4,)."""
    tide = sum((tide(t_s, place_m, y[:2]) for tide in acting), np.zeros(2))
    return np.concatenate([y[2:], tide + acceleration_m_s2])


def integrate(scene: Scene, solution: Trajectory, every: int) -> Array:
    """Displacement and its velocity along the judging solution, (n, 4), from every `every`-th sample."""
    acting, t, acceleration = tides(scene), solution.t_s, excess_acceleration(scene, solution, every)
    knots = every_nth(len(t), every)
    com = CubicHermiteSpline(t[knots], solution.com_m[knots], solution.com_velocity_m_s[knots])

    def rhs(time: float, y: Array) -> Array:
        z = com(time)
        return displacement_rate(acting, time, z, acceleration(time, z), y)

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
