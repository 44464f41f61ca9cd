"""Frame that falls freely from the chain's initial centre of mass, with axes of fixed direction."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.common.kepler import propagate
from adapters.engine import EngineError
from scenarios import Gravity

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from adapters.common.initial_state import InitialState
    from adapters.trajectory import Array
    from scenarios import Scene

RTOL = 100.0 * np.finfo(float).eps  # SciPy's smallest
GRAIN = 1e-15  # absolute tolerance relative to radius and speed: rounding dominates below it
STEPS_PER_RADIAN = 16.0  # measured, at that tolerance: 12 to 17 on circular and eccentric orbits
ROUNDINGS = 8.0  # measured: 1 after a circular orbit, up to 3.3 after five eccentric ones
BETWEEN = 2e-13  # error of SciPy's interpolation relative to radius and speed; measured up to 9e-14


def free_fall(scene: Scene, start: InitialState, t_s: Array) -> tuple[Array, Array]:
    """Origin of the frame and its velocity at `t_s` (n,), each (n, 2), m and m/s.

    The orbit of a particle with the initial state of the centre of mass: Kepler's orbit, an integrated orbit where
    other fields act, or uniform motion without gravity. Forces on the chain itself (drag, light, thrust) do not act on
    the particle.

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
    found = solve_ivp(particle(scene), (t_s[0], t_s[-1]), y0, method="DOP853", t_eval=t_s, rtol=RTOL, atol=atol)
    if not found.success:
        raise EngineError(f"the integration of the frame's origin failed: {found.message}")
    return found.y[:2].T, found.y[2:].T


def particle(scene: Scene) -> Callable[[float, Array], Sequence[float]]:
    """Time derivative of a particle's position and velocity."""
    from adapters.bar_loads.fields import InversePowerField
    from adapters.bar_loads.particle import perturbing_fields

    centre, beside = InversePowerField(scene.central_body.mu_m3_s2, 3), perturbing_fields(scene)

    def rate(t_s: float, state: Array) -> Sequence[float]:
        x, y, vx, vy = state.tolist()
        pulls = [centre.pull(x, y), *(field(t_s, x, y) for field in beside)]
        return vx, vy, sum(ax for ax, _ in pulls), sum(ay for _, ay in pulls)

    return rate


def orbit_noise(scene: Scene, t_s: Array) -> dict[str, float | Array]:
    """Error of an integrated origin, m and m/s, which no step of the chain reduces.

    Each step rounds the radius. The roundings add up as a random walk and grow along the orbit by 3 n t. Between steps
    the orbit is interpolated.
    """
    if not (scene.effects.oblateness or scene.effects.third_body):
        return {}
    turned = 2.0 * np.pi * t_s / scene.step_period_s
    walk = ROUNDINGS * np.finfo(float).eps * np.sqrt(1.0 + STEPS_PER_RADIAN * turned)
    position = scene.radius0_m * (walk * (1.0 + 3.0 * turned) + BETWEEN)
    return {"com": position, "com_velocity": position * 2.0 * np.pi / scene.step_period_s}
