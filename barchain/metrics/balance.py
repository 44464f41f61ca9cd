"""Balance of energy and angular momentum about the centre of mass: their changes less the work and torque of gravity.

Beside the orbit's, the energy and the angular momentum about the centre of mass vanish: of 1e13 N m s a slowly turning
bar has 0.03. The balance is of the order of the bars, and holds for the paper's gravity gradient too, which conserves
neither energy nor angular momentum as a whole:

    dL/dt = sum of m_j d_j x (g_j - g) + K_j,   dE/dt = sum of m_j d_j' . (g_j - g) + K_j theta_j',

with g_j the field at bar j, K_j the torque on it, and d_j from the centre of mass. Eqs. (13), (15).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from adapters.common.initial_state import chain_model
from barchain.metrics.mean_acceleration import FIELDS, every_nth
from barchain.metrics.rates import orbit_rate
from reference_impl.model import invariants
from reference_impl.model.complex_vectors import as_complex, unit_along
from reference_impl.model.effect import EffectState
from reference_impl.model.gravity import complex_field_differences, gradient_angular_accelerations
from reference_impl.model.kinematics import bar_centres, consistent_state
from scenarios import Gravity

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from reference_impl.model.chain import ChainModel
    from scenarios import Scene

GAUSS, WEIGHTS = np.polynomial.legendre.leggauss(3)
"""Nodes of an interval: of a higher degree than the splines between samples"""
LEAST_SAMPLES = 3
"""Samples of which every second can be left out"""
MOST_TURNED_RAD = 0.5
"""Largest turn of a bar, or of the centre of mass about the body, between samples: torques turn twice as far, and twice
that without every second sample"""


def balanced(scene: Scene) -> bool:
    """Whether only fields, and springs between bars, act beside gravity, so that the balance can be computed."""
    called, springs = scene.effects, scene.effects.joint_spring_damper
    damped = springs is not None and any(springs.damping_N_m_s_rad)
    driven = called.prescribed_rotation or called.impulse or called.thrust or called.drag or called.solar_pressure
    return called.gravity is not Gravity.NONE and not driven and not damped


@np.errstate(divide="ignore", invalid="ignore")  # at the body's centre nothing is resolved
def imbalance(scene: Scene, trajectory: Trajectory) -> dict[str, Array]:
    """Changes of energy (J) and angular momentum (N m s) about the centre of mass that gravity does not explain, (n,).

    Between samples the motion is a cubic spline through angles and rates. Its error falls 16 times with twice the
    samples: the change on leaving out every second sample, in an interval and its neighbours without regard to sign,
    bounds it and is subtracted. Nothing shows from the first interval on in which a bar, or the orbit, turns too far.
    """
    model, t = chain_model(scene), trajectory.t_s
    angle, rate = trajectory.angle_rad, trajectory.rate_rad_s
    assert angle is not None
    assert rate is not None
    energy = invariants.relative_kinetic_energy(model, angle, rate)
    for effect in model.effects:
        if effect.internal:
            energy = energy + effect.energy(model, trajectory.com_m, angle)
    held: dict[str, Array] = {
        "energy_about_com": energy,
        "angular_momentum_about_com": invariants.relative_angular_momentum(model, angle, rate),
    }
    if len(t) < LEAST_SAMPLES:
        return {name: np.zeros(len(t)) for name in held}
    fastest = np.maximum(np.abs(rate).max(axis=1), np.abs(orbit_rate(trajectory)))
    turning = np.diff(t) * np.maximum(fastest[1:], fastest[:-1])
    turned = np.maximum(np.abs(np.diff(angle, axis=0)).max(axis=1), turning)
    resolved = np.append(True, np.logical_and.accumulate(turned <= MOST_TURNED_RAD))
    full, coarse = (gained(model, trajectory, t, every) for every in (1, 2))
    found = {}
    for name, values in held.items():
        left = np.abs(values - values[0] - np.append(0.0, np.cumsum(full[name])))
        unknown = np.append(0.0, np.cumsum(np.convolve(np.abs(full[name] - coarse[name]), np.ones(3), "same")))
        found[name] = np.where(resolved, np.maximum(left - unknown, 0.0), 0.0)
    return found


def gained(model: ChainModel, trajectory: Trajectory, t_s: Array, every: int) -> dict[str, Array]:
    """Work and angular impulse of gravity in each interval, (n-1,), along splines through every `every`-th sample."""
    assert trajectory.angle_rad is not None
    assert trajectory.rate_rad_s is not None
    knots, half_s = every_nth(len(t_s), every), 0.5 * np.diff(t_s)
    nodes = (t_s[:-1] + half_s)[:, None] + half_s[:, None] * GAUSS
    times = nodes.ravel()
    angle = CubicHermiteSpline(t_s[knots], trajectory.angle_rad[knots], trajectory.rate_rad_s[knots])
    com = CubicHermiteSpline(t_s[knots], trajectory.com_m[knots], trajectory.com_velocity_m_s[knots])
    power, torque = power_and_torque(model, times, com(times), com(times, 1), angle(times), angle(times, 1))

    def summed(values: Array) -> Array:
        total: Array = half_s * (values.reshape(nodes.shape) @ WEIGHTS)
        return total

    return {"energy_about_com": summed(power), "angular_momentum_about_com": summed(torque)}


def power_and_torque(
    model: ChainModel, t_s: Array, com_m: Array, com_velocity_m_s: Array, angle_rad: Array, rate_rad_s: Array
) -> tuple[Array, Array]:
    """Power (W) and torque (N m) of all fields about the centre of mass at k instants, (k,) each."""
    along, com = unit_along(angle_rad), as_complex(com_m)[:, None]
    place = bar_centres(model, model.half_m * along)
    velocity = bar_centres(model, 1j * model.half_m * rate_rad_s * along)
    pull = complex_field_differences(model.mu_m3_s2, com, place)
    turn = np.zeros_like(angle_rad)
    if model.gravity == "gradient":
        turn = gradient_angular_accelerations(model, com + place, along)
    fields = [effect for effect in model.effects if effect.name in FIELDS]
    for k, instant in enumerate(t_s if fields else ()):
        state = consistent_state(model, com_m[k], com_velocity_m_s[k], angle_rad[k], rate_rad_s[k])
        at = EffectState(model, float(instant), state, along[k])
        for field in fields:
            added = field.accelerations(at, None)
            pull[k] += added.difference
            turn[k] += added.angular
    force = model.mass_kg * pull
    moment = turn * model.inertia_kg_m2
    power: Array = np.sum((velocity.conj() * force).real + rate_rad_s * moment, axis=1)
    torque: Array = np.sum((place.conj() * force).imag + moment, axis=1)
    return power, torque
