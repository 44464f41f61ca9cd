"""How far the centre of mass of a chain leaves the orbit of a particle: the model difference of CM-only engines.

Each bar is pulled where it is, so the mean pull differs from the pull at the centre of mass by
O((L/r)²). To first order the track is displaced by

    delta'' = G(Z0) delta + (g_mean - g(Z0)),   G = mu/r³ (3 r̂ r̂ᵀ - I),

driven along the truth's own attitude. It is independent of the engine judged by it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline

from adapters.initial_state import chain_model
from reference_impl.gravity import field_differences
from reference_impl.kinematics import relative_positions
from scenarios import Gravity

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.engine import Array, Trajectory
    from scenarios import Scene

    Pull = Callable[[float, Array], Array]

RESPONSE_STEPS_PER_RADIAN = 60.0  # of the orbit: the chain's own oscillations are up to ten times as fast
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


def com_displacement(scene: Scene, truth: Trajectory) -> Displacement:
    """Displacement of the chain's centre of mass from a particle's track, and its time derivative.

    Its uncertainty is the change on halving the samples used (a bound for cubic interpolation, whose
    error falls 16 times), and the next order: the displacement times L/r and times its own size over r,
    each amplified as Kepler motion does, 1 + 3 n t; in velocities that counts at the orbit's rate.
    """
    n = len(truth.t_s)
    if not pulled_apart(scene, truth):
        return Displacement(np.zeros((n, 2)), np.zeros(n), np.zeros((n, 2)), np.zeros(n))
    full = integrate(scene, truth, pull_along(scene, truth, 1))
    coarse = integrate(scene, truth, pull_along(scene, truth, 2)) if n > 4 else np.zeros_like(full)
    interpolation = np.maximum.accumulate(np.linalg.norm((full - coarse).reshape(n, 2, 2), axis=2))
    size = np.maximum.accumulate(np.linalg.norm(full[:, :2], axis=1))
    distance = np.linalg.norm(truth.com_m, axis=1)
    rate = float((np.linalg.norm(truth.com_velocity_m_s, axis=1) / distance).max())
    growth = 1.0 + 3.0 * scene.orbital_rate_rad_s * truth.t_s
    second_order = size * (scene.size_m + size) / distance.min() * growth
    return Displacement(
        full[:, :2], interpolation[:, 0] + second_order, full[:, 2:], interpolation[:, 1] + rate * second_order
    )


def track_response(scene: Scene, truth: Trajectory, aside: Trajectory) -> dict[str, Array]:
    """How far the centre of mass of a twin goes aside: ``com`` (m), ``com_velocity`` (m/s), each (n,).

    The difference of the two displacements, integrated as one: that of the two tracks themselves drowns in
    their own errors, which are larger than what an attitude 1e-10 rad aside can do.
    """
    n = min(len(truth.t_s), len(aside.t_s))
    if not pulled_apart(scene, truth):
        return {"com": np.zeros(n), "com_velocity": np.zeros(n)}
    assert truth.angle_rad is not None
    assert aside.angle_rad is not None
    t = truth.t_s[:n]
    count = math.ceil((t[-1] - t[0]) * 2.0 * math.pi / scene.step_period_s * RESPONSE_STEPS_PER_RADIAN)
    times, seen = walk(scene, truth, [pull_along(scene, truth, 1), pull_along(scene, aside, 1)], max(count, 1))
    apart = {"com": seen[:, :2], "com_velocity": seen[:, 2:]}
    return {name: np.interp(t, times, np.linalg.norm(d, axis=1)) for name, d in apart.items()}


def walk(scene: Scene, truth: Trajectory, pulls: list[Pull], steps: int) -> tuple[Array, Array]:
    """Instants, and what the second pull moves beyond the first, (steps + 1, 4): Runge and Kutta's equal steps.

    A method that chooses its steps would chase the rounding of a difference of two pulls.
    """
    mu = scene.central_body.mu_m3_s2
    com = CubicHermiteSpline(truth.t_s, truth.com_m, truth.com_velocity_m_s)
    times = np.linspace(truth.t_s[0], truth.t_s[-1], 2 * steps + 1)  # with the middles
    places = com(times)
    forced = [pulls[1](t, z) - pulls[0](t, z) for t, z in zip(times, places, strict=True)]
    h, y, seen = times[2] - times[0], np.zeros(4), [np.zeros(4)]
    for k in range(0, 2 * steps, 2):
        a = moved(mu, places[k], forced[k], y)
        b = moved(mu, places[k + 1], forced[k + 1], y + 0.5 * h * a)
        c = moved(mu, places[k + 1], forced[k + 1], y + 0.5 * h * b)
        d = moved(mu, places[k + 2], forced[k + 2], y + h * c)
        y = y + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
        seen.append(y)
    return times[::2], np.array(seen)


def pulled_apart(scene: Scene, truth: Trajectory) -> bool:
    """Whether the bars' places matter to the centre of mass."""
    return scene.effects.gravity is not Gravity.NONE and truth.angle_rad is not None


def pull_along(scene: Scene, seen: Trajectory, every: int) -> Pull:
    """Mean pull less that at the centre of mass (m/s²), along the attitude through every `every`-th sample."""
    assert seen.angle_rad is not None
    assert seen.rate_rad_s is not None
    model, mu, t = chain_model(scene), scene.central_body.mu_m3_s2, seen.t_s
    knots = np.unique(np.append(np.arange(0, len(t), every), len(t) - 1))
    angle = CubicHermiteSpline(t[knots], seen.angle_rad[knots], seen.rate_rad_s[knots])

    def pull(time: float, z: Array) -> Array:
        found: Array = model.weight @ field_differences(mu, z, relative_positions(model, angle(time)))
        return found

    return pull


def moved(mu_m3_s2: float, place_m: Array, pull_m_s2: Array, y: Array) -> Array:
    """Time derivative of a displacement and its velocity, (4,)."""
    r = np.linalg.norm(place_m)
    tide = mu_m3_s2 / r**3 * (3.0 * place_m * (place_m @ y[:2]) / r**2 - y[:2])
    return np.concatenate([y[2:], tide + pull_m_s2])


def integrate(scene: Scene, truth: Trajectory, pull: Pull) -> Array:
    """Displacement and its velocity, (n, 4), driven by `pull`."""
    mu, t = scene.central_body.mu_m3_s2, truth.t_s
    com = CubicHermiteSpline(t, truth.com_m, truth.com_velocity_m_s)

    def rhs(time: float, y: Array) -> Array:
        z = com(time)
        return moved(mu, z, pull(time, z), y)

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
