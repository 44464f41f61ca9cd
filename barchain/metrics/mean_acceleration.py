"""What moves the centre of mass of a chain and not a particle in its place: the bars' mean pull, and the field's tide.

Composed of what a scene calls for: with point or gradient gravity alone, nothing of an effect is evaluated.
"""

from __future__ import annotations

import cmath
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from adapters.common.initial_state import chain_model
from reference_impl.model.gravity import field_differences
from reference_impl.model.kinematics import joined_state, relative_positions
from scenarios import Axes, Gravity

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from adapters.trajectory import Array, Trajectory
    from reference_impl.model.chain import ChainModel
    from reference_impl.model.effect import ChainEffect
    from scenarios import Scene, ThirdBody

    Pull = Callable[[float, Array], Array]

FIELDS = frozenset({"quadrupole", "slender", "oblateness", "third_body"})
"""Effects that pull on a bar by where it is"""
PUSHES = frozenset({"drag", "solar_pressure", "thrust"})
"""Effects that push it by how it is turned, or along a fixed direction; what is left acts inside the chain"""


def pull_along(scene: Scene, trajectory: Trajectory, every: int, *, pushed: bool = False) -> Pull:
    """Mean pull less that at the centre of mass (m/s²), along the attitude through every `every`-th sample.

    Parameters
    ----------
    scene : Scene
    trajectory : Trajectory
        With attitude and rates.
    every : int
    pushed : bool
        Whether what is no field (drag, light, thrust) counts too: all of it, as a centre of mass feels it.

    Returns
    -------
    callable
        Of an instant and the place (2,) of the centre of mass.
    """
    assert trajectory.angle_rad is not None
    assert trajectory.rate_rad_s is not None
    model, mu, t = chain_model(scene), scene.central_body.mu_m3_s2, trajectory.t_s
    knots = every_nth(len(t), every)
    angle = CubicHermiteSpline(t[knots], trajectory.angle_rad[knots], trajectory.rate_rad_s[knots])

    def pull(time: float, z: Array) -> Array:
        found: Array = model.weight @ field_differences(mu, z, relative_positions(model, angle(time)))
        return found

    acting = [e for e in model.effects if e.name in FIELDS or (pushed and e.name in PUSHES)]
    if not acting:
        return pull
    more = push_along(model, acting, CubicHermiteSpline(t, trajectory.com_m, trajectory.com_velocity_m_s), angle)
    return more if model.gravity == "none" else lambda time, z: pull(time, z) + more(time, z)


def every_nth(count: int, every: int) -> NDArray[np.intp]:
    """Every `every`-th of so many samples, and the last one."""
    return np.unique(np.append(np.arange(0, count, every), count - 1))


def push_along(
    model: ChainModel, acting: list[ChainEffect], com: CubicHermiteSpline, angle: CubicHermiteSpline
) -> Pull:
    """Mean of what some effects do to the bars, less what they do to all alike, along a motion, m/s²."""
    from reference_impl.model.complex_vectors import unit_along  # noqa: PLC0415
    from reference_impl.model.effect import EffectState  # noqa: PLC0415 - only where an effect acts

    velocity, rate = com.derivative(), angle.derivative()

    def push(time: float, z: Array) -> Array:
        state = joined_state(model, z, velocity(time), angle(time), rate(time))
        at = EffectState(model, time, state, unit_along(state.angle_rad))
        mean = sum((effect.accelerations(at, None).difference @ model.weight for effect in acting), 0j)
        return np.array([mean.real, mean.imag])

    return push


@dataclass(frozen=True)
class TidalGradient:
    """Change of an attraction k Y/|Y|^(p+1) towards a mass with the place."""

    strength: float
    """k, m^(p+1)/s²"""
    power: int
    """p + 1"""
    body: ThirdBody | None = None
    """Where the mass is; None: at the centre"""

    def __call__(self, t_s: float, place_m: Array, aside_m: Array) -> Array:
        """How much more is pulled what is a little aside of a place, (2,) m/s², to first order."""
        y = place_m
        if self.body is not None:
            x = cmath.rect(self.body.distance_m, self.body.longitude_rad + self.body.rate_rad_s * t_s)
            y = place_m - np.array([x.real, x.imag])
        r = np.linalg.norm(y)
        found: Array = self.strength / r**self.power * (self.power * y * (y @ aside_m) / r**2 - aside_m)
        return found


def tides(scene: Scene) -> list[TidalGradient]:
    """Of all that a particle feels: the central body, its oblateness, third bodies."""
    mu, oblate = scene.central_body.mu_m3_s2, scene.effects.oblateness
    found = [] if scene.effects.gravity is Gravity.NONE else [TidalGradient(mu, 3)]
    if oblate is not None:
        found.append(TidalGradient(1.5 * mu * oblate.j2 * oblate.radius_m**2, 5))
    return found + [TidalGradient(body.mu_m3_s2, 3, body) for body in scene.effects.third_body]


def blows_along(scene: Scene, trajectory: Trajectory) -> list[tuple[float, Array]]:
    """Instants of blows along a bar's own axes, and the velocities (2,) they give to the centre of mass, m/s."""
    turning = [blow for blow in scene.effects.impulse if blow.axes is Axes.BODY]
    if not turning:
        return []
    assert trajectory.angle_rad is not None
    assert trajectory.rate_rad_s is not None
    angle = CubicHermiteSpline(trajectory.t_s, trajectory.angle_rad, trajectory.rate_rad_s)
    found = []
    for blow in turning:
        jump = cmath.rect(blow.impulse_N_s / scene.mass_kg, blow.direction_rad + angle(blow.at_s)[blow.bar - 1])
        found.append((blow.at_s, np.array([jump.real, jump.imag])))
    return found
