"""Events in pymunk's run: the chain restarts after each, as at t = 0.

A restart uses the angles, their rates and the centre of mass just before the event. Impulses change these states under
closed joints.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from adapters.bar_loads.interface import bars_of
from adapters.common.initial_state import InitialState, chain_model
from adapters.pymunk.iteration_count import step_sweeps
from adapters.pymunk.space import ChainSpace
from reference_impl.model.kinematics import relative_positions, relative_velocities

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.pymunk.samples import StaggeredSample
    from adapters.trajectory import Array
    from scenarios import Impulse, Scene


@dataclass(frozen=True)
class RestartState:
    """A chain ready for a restart."""

    chain: ChainSpace
    start: InitialState
    impulse_N_s: Array
    """(N-1, 2) impulsive reactions on each bar from the next"""


def synchronised(scene: Scene, staggered: StaggeredSample) -> InitialState:
    """State in the space's axes at an instant between two half steps, with closed joints."""
    position, before, after = (np.array(rows) for rows in staggered)
    mean, share = 0.5 * (before + after), np.array(scene.chain.mass_kg) / scene.mass_kg
    return chain_state(scene, share @ position[:, :2], share @ mean[:, :2], position[:, 2], mean[:, 2])


def chain_state(scene: Scene, com_m: Array, com_velocity_m_s: Array, angle: Array, rate: Array) -> InitialState:
    """State of a chain with closed joints."""
    model = chain_model(scene)
    position, velocity = relative_positions(model, angle), relative_velocities(model, angle, rate)
    return InitialState(com_m, com_velocity_m_s, angle, rate, position, velocity)


def restart_state(scene: Scene, start: InitialState, impulses: Sequence[Impulse], dt_s: float) -> RestartState:
    """Chain that starts from `start`, in the space's axes, after impulses."""
    nothing = np.zeros(2)
    found = np.zeros((scene.bars - 1, 2))
    if impulses:
        start, found = after_impulses(scene, start, impulses, dt_s)
    chain = ChainSpace(scene.chain, start, nothing, nothing, dt_s, step_sweeps(scene, dt_s))
    return RestartState(chain, start, found)


def after_impulses(
    scene: Scene, start: InitialState, impulses: Sequence[Impulse], dt_s: float
) -> tuple[InitialState, Array]:
    """State after impulses, and the impulsive reactions of pymunk's joints by momentum along the chain."""
    from adapters.bar_loads.thrusts import impulse_jumps

    chain = ChainSpace(scene.chain, start, np.zeros(2), np.zeros(2), dt_s, step_sweeps(scene, dt_s))
    mass = np.array(scene.chain.mass_kg)
    jumps = impulse_jumps(bars_of(scene.chain), impulses, start.angle_rad.tolist())
    before = np.array(chain.velocities())
    chain.apply_impulses(jumps)
    after, given = np.array(chain.velocities()), np.array(jumps)
    held = np.cumsum(mass[:, None] * (after - before - given)[:, :2], axis=0)[:-1]
    gained = mass @ given[:, :2] / mass.sum()
    return chain_state(scene, start.com_m, start.com_velocity_m_s + gained, start.angle_rad, after[:, 2]), held
