"""Acceleration of a chain's centre of mass beyond that of a particle in its place, and the tidal gradient of the field.

Only effects of the scene contribute: with point or gradient gravity alone, no effect is evaluated.
"""

from __future__ import annotations

import cmath
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from adapters.common.initial_state import chain_model
from reference_impl.model.gravity import field_differences
from reference_impl.model.kinematics import consistent_state, relative_positions
from scenarios import Axes, Gravity

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from adapters.trajectory import Array, Trajectory
    from reference_impl.model.chain import ChainModel
    from reference_impl.model.effect import ChainEffect
    from scenarios import Scene, ThirdBody

    Instants = float | Array
    AccelerationField = Callable[[Instants, Array], Array]

FIELDS = frozenset({"quadrupole", "slender", "oblateness", "third_body"})
"""Effects whose force on a bar depends on its place"""
NON_FIELD_EFFECTS = frozenset({"drag", "solar_pressure", "thrust"})
"""Effects whose force on a bar depends on its attitude, or has a fixed direction; all others act inside the chain"""


def excess_acceleration(
    scene: Scene, trajectory: Trajectory, every: int, *, include_non_fields: bool = False
) -> AccelerationField:
    """Mean acceleration of the bars less that at the centre of mass, m/s², along a run's attitude.

    Parameters
    ----------
    scene : Scene
    trajectory : Trajectory
        With attitude and rates.
    every : int
        Interpolate the attitude through every `every`-th sample.
    include_non_fields : bool
        Add drag, solar pressure and thrust with their full acceleration of the centre of mass.

    Returns
    -------
    callable
        Function of instants (...), s, and of places of the centre of mass, (..., 2) m; returns (..., 2) m/s².
    """
    assert trajectory.angle_rad is not None
    assert trajectory.rate_rad_s is not None
    model, mu, t = chain_model(scene), scene.central_body.mu_m3_s2, trajectory.t_s
    knots = every_nth(len(t), every)
    angle = CubicHermiteSpline(t[knots], trajectory.angle_rad[knots], trajectory.rate_rad_s[knots])

    def acceleration(time: Instants, z: Array) -> Array:
        found: Array = model.weight @ field_differences(mu, z[..., None, :], relative_positions(model, angle(time)))
        return found

    acting = [e for e in model.effects if e.name in FIELDS or (include_non_fields and e.name in NON_FIELD_EFFECTS)]
    if not acting:
        return acceleration
    more = effect_acceleration(
        model, acting, CubicHermiteSpline(t, trajectory.com_m, trajectory.com_velocity_m_s), angle
    )
    return more if model.gravity == "none" else lambda time, z: acceleration(time, z) + more(time, z)


def every_nth(count: int, every: int) -> NDArray[np.intp]:
    """Indices of every `every`-th of `count` samples, and of the last sample."""
    return np.unique(np.append(np.arange(0, count, every), count - 1))


def effect_acceleration(
    model: ChainModel, acting: list[ChainEffect], com: CubicHermiteSpline, angle: CubicHermiteSpline
) -> AccelerationField:
    """Mean acceleration of the bars by some effects, less the part common to all bars, along a motion, m/s²."""
    from reference_impl.model.complex_vectors import unit_along  # noqa: PLC0415
    from reference_impl.model.effect import EffectState  # noqa: PLC0415 - only where an effect acts

    velocity, rate = com.derivative(), angle.derivative()

    def mean_effect(time: Instants, z: Array) -> Array:
        if isinstance(time, np.ndarray):
            return np.array([mean_effect(float(t), place) for t, place in zip(time, z, strict=True)])
        state = consistent_state(model, z, velocity(time), angle(time), rate(time))
        at = EffectState(model, time, state, unit_along(state.angle_rad))
        mean = sum((effect.accelerations(at, None).difference @ model.weight for effect in acting), 0j)
        return np.array([mean.real, mean.imag])

    return mean_effect


@dataclass(frozen=True)
class TidalGradient:
    """Gradient of an attraction k Y/|Y|^(p+1) towards a mass."""

    strength: float
    """k, m^(p+1)/s²"""
    power: int
    """p + 1"""
    body: ThirdBody | None = None
    """Third body that attracts; None for the central body"""

    def __call__(self, t_s: Instants, place_m: Array) -> Array:
        """Change of the acceleration per small displacement, (..., 2, 2) 1/s², at places (..., 2) and instants."""
        y = place_m
        if self.body is not None:
            longitude = self.body.longitude_rad + self.body.rate_rad_s * np.asarray(t_s)
            y = place_m - self.body.distance_m * np.stack([np.cos(longitude), np.sin(longitude)], axis=-1)
        r = np.linalg.norm(y, axis=-1)[..., None, None]
        outer = y[..., :, None] * y[..., None, :]
        found: Array = self.strength / r**self.power * (self.power * outer / r**2 - np.eye(2))
        return found


def tides(scene: Scene) -> list[TidalGradient]:
    """Tidal gradients of all fields on a particle: central body, oblateness, third bodies."""
    mu, oblate = scene.central_body.mu_m3_s2, scene.effects.oblateness
    found = [] if scene.effects.gravity is Gravity.NONE else [TidalGradient(mu, 3)]
    if oblate is not None:
        found.append(TidalGradient(1.5 * mu * oblate.j2 * oblate.radius_m**2, 5))
    return found + [TidalGradient(body.mu_m3_s2, 3, body) for body in scene.effects.third_body]


def impulse_velocities(scene: Scene, trajectory: Trajectory) -> list[tuple[float, Array]]:
    """Instants of impulses in a bar's own axes, s, and the velocities that they add to the centre of mass, (2,) m/s."""
    turning = [impulse for impulse in scene.effects.impulse if impulse.axes is Axes.BODY]
    if not turning:
        return []
    assert trajectory.angle_rad is not None
    assert trajectory.rate_rad_s is not None
    angle = CubicHermiteSpline(trajectory.t_s, trajectory.angle_rad, trajectory.rate_rad_s)
    found = []
    for impulse in turning:
        velocity_step = cmath.rect(
            impulse.impulse_N_s / scene.mass_kg, impulse.direction_rad + angle(impulse.at_s)[impulse.bar - 1]
        )
        found.append((impulse.at_s, np.array([velocity_step.real, velocity_step.imag])))
    return found
