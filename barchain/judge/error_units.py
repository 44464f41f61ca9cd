"""Units that errors are counted in: the rounding of a place, the rounding of a sum, and one step's request."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import Coordinates
from barchain.judge.local_errors import MACHINE_EPSILON, ROUNDINGS, departure, orbit_scale, track_unit
from barchain.metrics.rates import own_rate

if TYPE_CHECKING:
    from adapters.engine import Engine, Setting
    from adapters.trajectory import Array, Trajectory
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

NORM_SLACK = 10.0
"""Slack of all bounds: largest component against norm, method constants other than the textbook's, stage effects"""


def largest_place_m(engine: type[Engine], solution: ReferenceSolution) -> float:
    """Largest number that a bar's place is made of in an engine's coordinates, m.

    Absolute coordinates count from the central body's centre, relative ones along the chain. In a frame on an orbit of
    its own, the chain's departure from that orbit is added to the chain's size.
    """
    scene = solution.scene
    if engine.coordinates is Coordinates.ABSOLUTE:
        return scene.radius0_m
    if engine.coordinates is Coordinates.RELATIVE:
        return scene.size_m
    place, _ = departure(engine, scene, solution.trajectory)
    return scene.size_m + float(np.linalg.norm(place, axis=1).max())


def rounded_sum(trajectory: Trajectory, quantity: str) -> Array:
    """Rounding of a value that is a sum over N bars, (n,), in the quantity's unit: N terms of at most its own size."""
    values = {
        "attitude": trajectory.angle_rad,
        "rate": trajectory.rate_rad_s,
        "reaction": trajectory.reaction_N,
        "torque": trajectory.torque_N_m,
        "impulse": trajectory.impulse_N_s,
    }
    found = values.get(quantity)
    bars = 1 if trajectory.angle_rad is None else trajectory.angle_rad.shape[1]
    if found is None or not found.size:
        return np.zeros(len(trajectory.t_s))
    size = np.abs(found).reshape(len(trajectory.t_s), -1).max(axis=1)
    largest: Array = MACHINE_EPSILON * ROUNDINGS * bars * np.maximum.accumulate(size)
    return largest


def step_unit(engine: type[Engine], quantity: str, scene: Scene, setting: Setting) -> float:
    """Unit of a step's requested accuracy, SI; 0 for quantities that only respond to a change of attitude."""
    track = track_unit(engine, scene, setting.value) * (NORM_SLACK if engine.track_by_length else 1.0)
    units = {"com": track, "com_velocity": track * orbit_scale(scene), "rate": own_rate(scene)}
    return units.get(quantity, 0.0)
