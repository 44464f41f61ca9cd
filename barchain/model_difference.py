"""How far the centre of mass of a chain leaves the orbit of a particle: the model difference of CM-only engines.

Each bar is pulled where it is, so the mean pull differs from the pull at the centre of mass by
O((L/r)²). To first order the track is displaced by

    delta'' = G(Z0) delta + (g_mean - g(Z0)),   G = mu/r³ (3 r̂ r̂ᵀ - I),

driven along the truth's own attitude. It is independent of the engine judged by it.
"""

from __future__ import annotations

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
    from adapters.engine import Array, Trajectory
    from scenarios import Scene

QUADRATURE_RTOL = 1e-6  # of the displacement; far below what interpolating the attitude leaves


@dataclass(frozen=True)
class Displacement:
    """Predicted displacement of the chain's centre of mass from a particle's track; n samples."""

    vector_m: Array
    """(n, 2)"""
    uncertainty_m: Array
    """(n,), never falling: interpolation, and the second order left out"""


def com_displacement(scene: Scene, truth: Trajectory) -> Displacement:
    """Displacement of the chain's centre of mass from a particle's track.

    Its uncertainty is the change on halving the samples used (a bound for cubic interpolation, whose
    error falls 16 times), and the next order: the displacement times L/r and times its own size over r,
    each amplified as Kepler motion does, 1 + 3 n t.
    """
    n = len(truth.t_s)
    if scene.effects.gravity is Gravity.NONE or truth.angle_rad is None:
        return Displacement(np.zeros((n, 2)), np.zeros(n))
    full = integrate(scene, truth, 1)
    coarse = integrate(scene, truth, 2) if n > 4 else np.zeros_like(full)
    interpolation = np.maximum.accumulate(np.linalg.norm(full - coarse, axis=1))
    size = np.maximum.accumulate(np.linalg.norm(full, axis=1))
    radius = np.linalg.norm(truth.com_m, axis=1).min()
    second_order = size * (scene.size_m + size) / radius * (1.0 + 3.0 * scene.orbital_rate_rad_s * truth.t_s)
    return Displacement(full, interpolation + second_order)


def integrate(scene: Scene, truth: Trajectory, every: int) -> Array:
    """Displacement (n, 2) with the attitude interpolated through every `every`-th sample."""
    assert truth.angle_rad is not None
    assert truth.rate_rad_s is not None
    model, mu, t = chain_model(scene), scene.central_body.mu_m3_s2, truth.t_s
    knots = np.unique(np.append(np.arange(0, len(t), every), len(t) - 1))
    angle = CubicHermiteSpline(t[knots], truth.angle_rad[knots], truth.rate_rad_s[knots])
    com = CubicHermiteSpline(t, truth.com_m, truth.com_velocity_m_s)

    def rhs(time: float, y: Array) -> Array:
        z = com(time)
        r = np.linalg.norm(z)
        pull = model.weight @ field_differences(mu, z, relative_positions(model, angle(time)))
        tide = mu / r**3 * (3.0 * z * (z @ y[:2]) / r**2 - y[:2])
        return np.concatenate([y[2:], tide + pull])

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
    displacement: Array = found.y[:2].T
    return displacement
