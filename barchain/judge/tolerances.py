"""What the tolerances of the comparison are made of; `barchain.judge.error_model` puts them together.

Two questions are asked of a difference from the reference solution, at every sample up to the predictability limit.

*Consistent?* It is explained by the two error estimates, round-off, and the declared model difference: ``explained = 2
(E_engine + E_truth) + floor + model``. The 2 is Richardson's, see `barchain.solutions.reference.RICHARDSON`.

*Good enough?* It is inside the band that the engine's method and setting promise on this scene, ``band``.

Both use the growth G(t) of a small perturbation, measured by the truth's twin: an error made at s is
G(t)/G(s) times as large at t.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import Coordinates
from barchain.judge.local_errors import ROUNDINGS, UNIT_ROUNDOFF, departure, orbit_scale, track_unit
from barchain.metrics.rates import own_rate

if TYPE_CHECKING:
    from adapters.engine import Engine, Setting
    from adapters.trajectory import Array, Trajectory
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

NORM_SLACK = 10.0  # largest component against norm, constants of the method other than the textbook's, stage effects


def roundoff_unit(engine: type[Engine], solution: ReferenceSolution) -> float:
    """Angle that one rounding of a position is worth, rad: u for lengths of a bar, u r/l for distances.

    In a frame on an orbit of its own the chain's places are as large as what drives it off that orbit makes them.
    """
    scene, away = solution.scene, reach_m(engine, solution)
    if engine.coordinates is Coordinates.ABSOLUTE:
        away = scene.radius0_m
    elif engine.coordinates is Coordinates.RELATIVE:
        away = scene.size_m
    return UNIT_ROUNDOFF * away / min(scene.chain.length_m)


def reach_m(engine: type[Engine], solution: ReferenceSolution) -> float:
    """Largest place of a bar in an engine's frame, m: the chain's size, and its departure from the frame's orbit."""
    place, _ = departure(engine, solution.scene, solution.trajectory)
    return solution.scene.size_m + float(np.linalg.norm(place, axis=1).max())


def rounded(trajectory: Trajectory, quantity: str) -> Array:
    """Rounding of a value that is a sum over the bars, (n,): N terms of at most its own size."""
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
    largest: Array = UNIT_ROUNDOFF * ROUNDINGS * bars * np.maximum.accumulate(size)
    return largest


def step_unit(engine: type[Engine], quantity: str, scene: Scene, setting: Setting) -> float:
    """What the requested accuracy of a step counts in, where it is not the answer to an angle: SI units."""
    track = track_unit(engine, scene, setting.value) * (NORM_SLACK if engine.track_by_length else 1.0)
    units = {"com": track, "com_velocity": track * orbit_scale(scene), "rate": own_rate(scene)}
    return units.get(quantity, 0.0)
