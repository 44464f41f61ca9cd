"""Initial state of a scene: the same numbers for every engine.

Angles are relative to the horizontal, which is the radial direction rotated by -90 degrees. A prescribed bar takes the
rate of its law, so that law and state agree at t = 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.reference_model import chain_model
from reference_impl.model.kinematics import (
    bar_centre_vectors,
    cross,
    directions,
    relative_positions,
    relative_velocities,
)
from scenarios import Frame

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array
    from reference_impl.model.chain import ChainModel
    from scenarios import Scene

LONGITUDE_ITERATIONS = 50  # contraction by the chain's size over its radius, 1e-5 in the paper's scenes


@dataclass(frozen=True)
class InitialState:
    """Positions and velocities at t = 0, in inertial axes."""

    com_m: Array
    """(2,)"""
    com_velocity_m_s: Array
    """(2,)"""
    angle_rad: Array
    """(N,) theta_j from the z1 axis"""
    rate_rad_s: Array
    """(N,)"""
    position_m: Array
    """(N, 2) d_j = Z_j - Z0"""
    velocity_m_s: Array
    """(N, 2)"""


def initial_state(scene: Scene) -> InitialState:
    """Initial state of `scene`, with joints closed in position and velocity.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    InitialState
        Centre of mass from the centre of the body; places and velocities of the bars' centres relative to it; absolute
        angles and rates.
    """
    model = chain_model(scene)
    longitude = scene.orbit.longitude_rad
    radial = np.array([math.cos(longitude), math.sin(longitude)])
    com = scene.radius0_m * radial
    onward = math.cos(scene.orbit.flight_path_rad)
    com_velocity = scene.speed0_m_s * onward * np.array([-radial[1], radial[0]])
    if scene.orbit.flight_path_rad:
        com_velocity += scene.speed0_m_s * math.sin(scene.orbit.flight_path_rad) * radial
    angle = initial_angles(scene, model, com)
    rate = initial_rates(scene, model, com, com_velocity, angle)
    return InitialState(
        com,
        com_velocity,
        angle,
        rate,
        relative_positions(model, angle),
        relative_velocities(model, angle, rate),
    )


def initial_angles(scene: Scene, model: ChainModel, com_m: Array) -> Array:
    """theta_j(0), (N,): relative to the chain's horizontal, or by fixed-point iteration to each bar's own."""
    longitude = scene.orbit.longitude_rad
    phi = np.array(scene.chain.angle_rad)
    angle: Array = phi + longitude - 0.5 * math.pi
    if scene.chain.angle_from == "chain":
        return angle
    for _ in range(LONGITUDE_ITERATIONS):
        before = angle
        angle = phi + longitude + longitude_differences(com_m, relative_positions(model, angle)) - 0.5 * math.pi
        if np.array_equal(angle, before):
            break
    return angle


def longitude_differences(com_m: Array, position_m: Array) -> Array:
    """Longitude of each bar's centre relative to the chain's, (N,) rad, free of cancellation."""
    difference: Array = np.arctan2(cross(com_m, position_m), com_m @ com_m + position_m @ com_m)
    return difference


def initial_rates(scene: Scene, model: ChainModel, com_m: Array, com_velocity_m_s: Array, angle_rad: Array) -> Array:
    """theta_j'(0), (N,): alpha v0/r0, and the law's rate for prescribed bars.

    Relative to the local horizontal the law requires theta' = omega', relative to the bar before that bar's rate. A
    bar's own longitude rate depends on all bars' rates, which gives a linear system with one row per prescribed bar.
    """
    rate = np.array(scene.chain.rate_factor) * scene.orbital_rate_rad_s
    laws = scene.effects.prescribed_rotation
    for law in laws:
        rate[law.bar - 1] = 0.0
    relative = [p for p in laws if p.frame is not Frame.INERTIAL]
    if not relative:
        return rate
    bars = np.array([p.bar - 1 for p in relative])
    of_joint = np.array([p.frame is Frame.PREVIOUS_BAR for p in relative])
    position = com_m + relative_positions(model, angle_rad)
    r2 = np.sum(position**2, axis=-1)
    longitude_rate = cross(position, com_velocity_m_s + relative_velocities(model, angle_rad, rate)) / r2
    base = np.where(of_joint, rate[bars - 1], longitude_rate[bars])
    _, across = directions(angle_rad)
    system = np.eye(len(bars))
    for column, bar in enumerate(bars):
        unit = np.zeros((model.bars, 2))
        unit[bar] = model.half_m[bar] * across[bar]
        moved = cross(position, bar_centre_vectors(model, unit)) / r2
        system[:, column] -= np.where(of_joint, bars - 1 == bar, moved[bars])
    rate[bars] = np.linalg.solve(system, base)
    return rate
