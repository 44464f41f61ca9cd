"""Measured round-off of a run, and its largest size in an engine's coordinates.

Round-off is a property of each run. The same setting is run again with other last bits: in a slightly turned frame,
from a start moved by a few units in the last place. The largest difference of these runs is the size of their
round-off. A noisy engine could make room for any error that way. The measured size therefore counts only up to a bound,
which follows from the scene, the setting and the engine's coordinates. No coordinates are larger than the orbit's
radius.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import AccuracyParameter
from barchain.judge.error_units import NORM_SLACK
from barchain.judge.local_errors import MACHINE_EPSILON, ROUNDINGS, kepler_growth, orbit_scale, step_s
from barchain.metrics.quantities import differences, drifts

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.trajectory import Array, Trajectory
    from barchain.judge.error_model import ErrorModel
    from scenarios import Scene

DAMPED_SUM = 10.0
"""Sum of errors of multipliers that each step damps by a tenth, in units of one step's error"""
SPREAD_FACTOR = 5.0
"""Times the largest difference among four runs: of four errors of one distribution, one is farther from the right value
than this with a chance of 1e-3"""

EARLY = 4
"""Samples at the start whose round-off is of one size: at the first alone, four runs may agree by chance"""


def measured_roundoff(scene: Scene, runs: Sequence[Trajectory]) -> dict[str, Array]:
    """Round-off of the first of some runs with different rounding: for each quantity and drift, (n,), never falling.

    Beyond the end of the shortest run the round-off is unknown and counts as zero. Empty for a single run.
    """
    found: dict[str, Array] = {}
    drifted = [drifts(scene, run) for run in runs]
    for (k, one), (j, other) in itertools.combinations(enumerate(runs), 2):
        n = min(len(one.t_s), len(other.t_s))
        pairs = zip(drifted[k].items(), drifted[j].values(), strict=False)
        apart = differences(one, other) | {name: np.abs(a[:n] - b[:n]) for (name, a), b in pairs}
        for name, size in apart.items():
            size[:EARLY] = size[:EARLY].max(initial=0.0)
            grown = np.zeros(len(runs[0].t_s))
            grown[: len(size)] = SPREAD_FACTOR * np.maximum.accumulate(size)[: len(grown)]
            found[name] = np.maximum(found.get(name, 0.0), grown)
    return found


def max_roundoff(model: ErrorModel, amplification: Array) -> dict[str, Array]:
    """Largest round-off that an engine's coordinates can cause, (n,) for each quantity, in its unit.

    A place of the size r is known to u r: r is the orbit's radius in absolute coordinates and the chain's size in
    others. Each step leaves a rounding of that size, and of velocities known to u r over the step. Over a bar's length
    these are angles and rates. They add up as a random walk, and the scene amplifies them. Forces that an engine gets
    as differences over a step are known to m u r / h².

    Parameters
    ----------
    model : ErrorModel
    amplification : ndarray, shape (n,)
        Error amplification of the scene since the start, or since the instant from which a comparison started anew.
    """
    scene, size, t = model.scene, model.scale, model.t_s - model.t_s[0]
    fixed_step = model.setting.parameter is AccuracyParameter.STEPS_PER_ORBIT
    place = ROUNDINGS * MACHINE_EPSILON * model.place_m
    step = step_s(scene, model.setting) if fixed_step else 1.0 / orbit_scale(scene)
    walk = np.sqrt(model.steps_taken(model.t_s))
    turn = place / min(scene.chain.length_m) * walk * (1.0 + t * orbit_scale(scene)) * amplification
    if fixed_step:  # velocities are differences of places a step apart
        turn = turn + place / (min(scene.chain.length_m) * step) * t * amplification
    track = place * walk * kepler_growth(scene, t)
    force = DAMPED_SUM * max(scene.chain.mass_kg) * place / step**2
    found = {
        "com": track,
        "com_velocity": track * orbit_scale(scene),
        "attitude": turn,
        "rate": turn * size["rate"] + place / (min(scene.chain.length_m) * step),
        "reaction": turn * size["reaction"] + force,
        "torque": turn * size["torque"] + force * max(scene.chain.length_m),
        "impulse": turn * size["impulse"] + max(scene.chain.mass_kg) * place / step,
    }
    return {name: NORM_SLACK * values for name, values in found.items()}
