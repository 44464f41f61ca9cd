"""Frame that falls freely from the chain's initial centre of mass, with axes of fixed direction."""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from adapters.bar_loads.fields import InversePowerField, oblateness_field, third_body_position
from adapters.common.kepler import propagate
from adapters.engine import EngineError
from scenarios import Gravity

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.common.initial_state import InitialState
    from adapters.trajectory import Array
    from scenarios import Scene, ThirdBody

RTOL = 100.0 * np.finfo(float).eps  # SciPy's smallest
GRAIN = 1e-15  # absolute tolerance relative to radius and speed: rounding dominates below it
STEPS_PER_RADIAN = 16.0  # measured, at that tolerance: 12 to 17 on circular and eccentric orbits
ROUNDINGS = 8.0  # measured: 1 after a circular orbit, up to 3.3 after five eccentric ones
BETWEEN = 2e-13  # error of SciPy's interpolation relative to radius and speed; measured up to 9e-14


def free_fall(scene: Scene, start: InitialState, t_s: Array) -> tuple[Array, Array]:
    """Origin of the frame and its velocity at the instants `t_s`.

    The orbit of a particle with the initial state of the centre of mass: Kepler's orbit, an integrated orbit where
    other fields act, or uniform motion without gravity. Forces on the chain itself (drag, light, thrust) do not act on
    the particle.

    Parameters
    ----------
    scene : Scene
    start : InitialState
    t_s : ndarray, shape (n,)
        From 0 on, rising.

    Returns
    -------
    origin_m, drift_m_s : ndarray, shape (n, 2)
        From the centre of the central body.

    Raises
    ------
    EngineError
        If the integration of the orbit fails.
    """
    if scene.effects.gravity is Gravity.NONE:
        drift = np.tile(start.com_velocity_m_s, (len(t_s), 1))
        return start.com_m + t_s[:, None] * drift, drift
    if scene.effects.oblateness or scene.effects.third_body:
        return integrated_orbit(scene, start, t_s)
    return propagate(scene.central_body.mu_m3_s2, start.com_m, start.com_velocity_m_s, t_s)


def integrated_orbit(scene: Scene, start: InitialState, t_s: Array) -> tuple[Array, Array]:
    """Orbit of a particle in several fields, to round-off.

    Any smooth orbit near the true one suits the bars, whose loads are differences from the fields at the origin. An
    error of the orbit is an error of the centre of mass, see :func:`orbit_noise`.
    """
    from scipy.integrate import solve_ivp

    y0 = np.concatenate([start.com_m, start.com_velocity_m_s])
    if len(t_s) == 1:  # t = 0
        return y0[None, :2], y0[None, 2:]
    atol = GRAIN * np.repeat([scene.radius0_m, 2.0 * np.pi * scene.radius0_m / scene.step_period_s], 2)
    found = solve_ivp(fall_rate(scene), (t_s[0], t_s[-1]), y0, method="DOP853", t_eval=t_s, rtol=RTOL, atol=atol)
    if not found.success:
        raise EngineError(f"the integration of the frame's origin failed: {found.message}")
    return found.y[:2].T, found.y[2:].T


def fall_rate(scene: Scene) -> Callable[[float, Array], tuple[float, float, float, float]]:
    """Rate of the frame's origin, for engines that integrate it with the chain.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    callable
        From t (s) and the origin with its velocity, (4,) m and m/s, to their time derivative. All fields act; forces
        on the chain itself do not.
    """
    mu = 0.0 if scene.effects.gravity is Gravity.NONE else scene.central_body.mu_m3_s2
    beside = perturbing_fields(scene)

    def rate(t_s: float, state: Array) -> tuple[float, float, float, float]:
        x, y, vx, vy = state.tolist()
        r2 = x * x + y * y
        pull = -mu / (r2 * sqrt(r2))
        ax, ay = pull * x, pull * y
        for field in beside:
            dx, dy = field(t_s, x, y)
            ax, ay = ax + dx, ay + dy
        return vx, vy, ax, ay

    return rate


def perturbing_fields(scene: Scene) -> list[Callable[[float, float, float], tuple[float, float]]]:
    """Fields besides the central body's: acceleration (m/s²) at t (s), x and y (m from its centre)."""
    found: list[Callable[[float, float, float], tuple[float, float]]] = []
    if scene.effects.oblateness:
        j2 = oblateness_field(scene.central_body.mu_m3_s2, scene.effects.oblateness)
        found.append(lambda _, x, y: j2.pull(x, y))
    return found + [tide(body) for body in scene.effects.third_body]


def tide(body: ThirdBody) -> Callable[[float, float, float], tuple[float, float]]:
    """Third body's acceleration of a particle less that of the central body."""
    pull = InversePowerField(body.mu_m3_s2, 3)

    def field(t_s: float, x: float, y: float) -> tuple[float, float]:
        bx, by = third_body_position(body, t_s)
        return pull.difference(-bx, -by, x, y)

    return field


def orbit_noise(scene: Scene, t_s: Array) -> dict[str, float | Array]:
    """Error of an integrated origin, m and m/s, which no step of the chain reduces.

    Each step rounds the radius. The roundings add up as a random walk and grow along the orbit by 3 n t. Between steps
    the orbit is interpolated.

    Parameters
    ----------
    scene : Scene
    t_s : ndarray, shape (n,)

    Returns
    -------
    dict
        As `Engine.noise` returns it: ``com`` (m) and ``com_velocity`` (m/s), each (n,); empty for Kepler's orbit and
        for uniform motion, which are exact.
    """
    if not (scene.effects.oblateness or scene.effects.third_body):
        return {}
    turned = 2.0 * np.pi * t_s / scene.step_period_s
    walk = ROUNDINGS * np.finfo(float).eps * np.sqrt(1.0 + STEPS_PER_RADIAN * turned)
    position = scene.radius0_m * (walk * (1.0 + 3.0 * turned) + BETWEEN)
    return {"com": position, "com_velocity": position * 2.0 * np.pi / scene.step_period_s}
