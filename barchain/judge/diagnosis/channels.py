"""Arrays of a trajectory by name, changed together."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.trajectory import Array, Trajectory
    from barchain.judge.diagnosis.mistake import ReadingChange
    from scenarios import Scene

REACTION, TORQUE, ANGLE, RATE = "reaction_N", "torque_N_m", "angle_rad", "rate_rad_s"
COM, VELOCITY, IMPULSE = "com_m", "com_velocity_m_s", "impulse_N_s"
CHANNELS = (COM, VELOCITY, ANGLE, RATE, REACTION, TORQUE, IMPULSE)
"""Arrays that are compared"""
VECTORS = (COM, VELOCITY, REACTION, IMPULSE)
"""Arrays of vectors in inertial axes, (..., 2)"""
JOINT_FORCES = (REACTION, IMPULSE)


def changed(trajectory: Trajectory, change: Callable[[Array], Array], *fields: str) -> Trajectory:
    """Trajectory with `change` applied to some of its arrays; a missing array stays missing."""
    return trajectory.replace(**{name: change(v) for name in fields if (v := getattr(trajectory, name)) is not None})


def channel(change: Callable[[Array], Array], *fields: str) -> ReadingChange:
    """Altered reading of some arrays, without regard to the scene."""

    def read(_: Scene, right: Trajectory) -> Trajectory:
        return changed(right, change, *fields)

    return read


def times(factor: float, *fields: str) -> ReadingChange:
    """Altered reading: some arrays times a factor."""
    return channel(lambda values: values * factor, *fields)


def plus(constant: float | Array, *fields: str) -> ReadingChange:
    """Altered reading: some arrays (n, ...) with a constant added."""
    return channel(lambda values: values + constant, *fields)


def channels_of(trajectory: Trajectory) -> dict[str, Array]:
    """Compared arrays of a trajectory that are present."""
    return {name: v for name in CHANNELS if (v := getattr(trajectory, name)) is not None}


def sizes_of(trajectory: Trajectory) -> dict[str, Array]:
    """Size of each compared array at each sample: of its longest vector or largest value, (n,)."""
    found = {}
    for name, values in channels_of(trajectory).items():
        size = np.linalg.norm(values, axis=-1) if name in VECTORS else np.abs(values)
        found[name] = size.reshape(len(size), -1).max(axis=1, initial=0.0)
    return found
