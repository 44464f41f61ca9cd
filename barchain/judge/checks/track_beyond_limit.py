"""The track of the centre of mass beyond the predictability limit of the attitude: bounded, and not chaotic."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import cumulative_trapezoid

from adapters.common.initial_state import chain_model
from barchain.judge.local_errors import kepler_growth, orbit_rate_bound
from barchain.metrics.model_difference import SECOND_MOMENT_ACCELERATION, displacement_bound
from scenarios import Axes, Gravity

if TYPE_CHECKING:
    from collections.abc import Iterator

    from adapters.trajectory import Array
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene, Thrust

EITHER_WAY = 2.0
"""Factor of two parted attitudes, which may accelerate the track in opposite directions"""
ACROSS = 8.0
"""Largest swing beside the secular part by Hill's equations: 8 dv/n of a velocity step, 8 dv of the velocity itself"""


def parted_track_bound(solution: ReferenceSolution, t_s: Array, limit_s: float) -> dict[str, Array]:
    """Largest effect on the track of attitudes that part at the limit, (n,): ``com`` (m), ``com_velocity`` (m/s).

    The pull on a chain differs from that on a particle by mu I/(M r⁴) at most. Forces that depend on the attitude
    differ by their whole strength: drag and sunlight from the limit on, thrusts and impulses in the axes of bars while
    they act. Those of fixed direction move the track alike at any attitude.
    """
    scene = solution.scene
    since = np.maximum(t_s - limit_s, 0.0)
    if not since.any():
        return {}
    n = len(t_s)
    found = {"com": np.zeros(n), "com_velocity": np.zeros(n)}
    if scene.effects.gravity is not Gravity.NONE and scene.bound:
        for name, moved in displacement_bound(scene, since, EITHER_WAY * SECOND_MOMENT_ACCELERATION).items():
            found[name] = np.where(since > 0.0, moved, 0.0)
    rate = orbit_rate_bound(scene, solution.trajectory)
    for gained, since_start in velocity_gains(scene, t_s, limit_s):
        moved, faster = reach_s(scene, since_start), growth_of_velocity(scene, since_start)
        found["com"] += EITHER_WAY * gained * moved
        found["com_velocity"] += EITHER_WAY * gained * (faster + rate * moved)
    return found


def velocity_gains(scene: Scene, t_s: Array, limit_s: float) -> Iterator[tuple[Array, Array]]:
    """Velocity that forces of unknown direction have given by each sample, (n,) m/s, and the time since they began.

    The whole velocity counts from the beginning: a steady acceleration displaces by half as much.
    """
    since, mass = np.maximum(t_s - limit_s, 0.0), scene.mass_kg
    steady = dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, thrust=(), impulse=()))
    model = chain_model(steady)
    push = sum(effect.largest_acceleration_m_s2(model) for effect in model.effects)
    yield push * since, since
    for thrust in scene.effects.thrust:
        if thrust.axes is Axes.BODY:
            start = max(limit_s, thrust.times_s[0])
            yield momentum_N_s(thrust, t_s, start) / mass, np.maximum(t_s - start, 0.0)
    for impulse in scene.effects.impulse:
        if impulse.axes is Axes.BODY and impulse.at_s >= limit_s:
            after = t_s >= impulse.at_s
            yield np.where(after, abs(impulse.impulse_N_s) / mass, 0.0), np.where(after, t_s - impulse.at_s, 0.0)


def momentum_N_s(thrust: Thrust, t_s: Array, start_s: float) -> Array:
    """Largest momentum that a thrust gives from an instant on, (n,): the integral of its size, by trapezoids."""
    inside = t_s[(t_s > start_s) & (t_s < thrust.times_s[-1])]
    knots: Array = np.unique([start_s, *inside, *(t for t in thrust.times_s if t > start_s)])
    sizes: Array = np.array([abs(thrust.size_N(t)) for t in knots])
    total: Array = cumulative_trapezoid(sizes, knots, initial=0)
    gained: Array = np.interp(t_s, knots, total)
    return gained


def reach_s(scene: Scene, since_s: Array) -> Array:
    """Largest displacement by a velocity step of 1 m/s after a time, (n,) m: 3 t along the orbit by Hill's equations.

    On an ellipse the secular part is (1 + e)/(1 - e) times as large where the speed is largest.
    """
    grown = since_s * kepler_growth(scene, since_s)
    if not closed(scene):
        return grown
    swing = np.where(since_s > 0.0, ACROSS / scene.mean_motion_rad_s, 0.0)
    return np.minimum(grown, ratio_of_speeds(scene) * (3.0 * since_s + swing))


def growth_of_velocity(scene: Scene, since_s: Array) -> Array:
    """Largest growth of a velocity step after a time, (n,)."""
    grown = kepler_growth(scene, since_s)
    return np.minimum(grown, ACROSS * ratio_of_speeds(scene)) if closed(scene) else grown


def closed(scene: Scene) -> bool:
    """Whether the orbit is an ellipse with a finite ratio of speeds."""
    return scene.effects.gravity is not Gravity.NONE and scene.bound and scene.orbit.speed_factor > 0.0


def ratio_of_speeds(scene: Scene) -> float:
    """Speed at perigee over speed at apogee, (1 + e)/(1 - e) with e = |beta² - 1|."""
    eccentricity = abs(scene.orbit.speed_factor**2 - 1.0)
    return (1.0 + eccentricity) / (1.0 - eccentricity)
