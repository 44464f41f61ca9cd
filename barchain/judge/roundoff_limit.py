"""Round-off of a run, measured, and the most that it may be.

Round-off is a property of each run: the same setting is run again with other last bits, in a turned frame and from a
start moved by a few units in the last place, and what the runs part by is its size. An engine could make room for any
error that way, by being noisy, so that the measured size counts only up to what its coordinates can make, which follows
from the scene and the setting; no coordinates are larger than the orbit's radius.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import AccuracyParameter
from barchain.judge.drift_bounds import rounded_place
from barchain.judge.local_errors import ROUNDINGS, UNIT_ROUNDOFF, kepler_growth, orbit_scale, step_s
from barchain.judge.scales import scales
from barchain.judge.tolerances import NORM_SLACK
from barchain.metrics.quantities import differences, drifts

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.trajectory import Array, Trajectory
    from barchain.judge.error_model import ErrorModel
    from scenarios import Scene

PILES_UP = 10.0  # multipliers that are damped by a tenth in each step add up
SPREAD = 5.0
"""Times the largest difference among four runs: of four errors of one distribution, one is farther from the right value
than this with a chance of 1e-3"""


def measured_roundoff(scene: Scene, runs: Sequence[Trajectory]) -> dict[str, Array]:
    """Round-off of the first of some runs with different rounding: for each quantity and drift, (n,), never falling.

    Beyond the end of one of the runs it is not known, and counts as nothing. Empty for a single run.
    """
    found: dict[str, Array] = {}
    for one, other in itertools.combinations(runs, 2):
        n = min(len(one.t_s), len(other.t_s))
        drifted = zip(drifts(scene, one).items(), drifts(scene, other).values(), strict=False)
        apart = differences(one, other) | {name: np.abs(a[:n] - b[:n]) for (name, a), b in drifted}
        for name, size in apart.items():
            grown = np.zeros(len(runs[0].t_s))
            grown[: len(size)] = SPREAD * np.maximum.accumulate(size)[: len(grown)]
            found[name] = np.maximum(found.get(name, 0.0), grown)
    return found


def coarsest_roundoff(model: ErrorModel, quantity: str, amplification: Array | None = None) -> Array:
    """Most that round-off may be in an engine's coordinates, (n,), in the quantity's unit.

    A place of the size r, the orbit's radius in absolute coordinates and the chain's own in others, is known to u r.
    Each step leaves a rounding of that, and of velocities known to u r over the step: over a bar's length these are
    angles and rates, which add up as a random walk and grow as the scene makes errors grow. Forces that an engine gets
    as differences over a step are known to m u r / h².

    `amplification`, (n,), is the scene's error amplification from the start on, or from where a comparison started
    anew.
    """
    amplification = model.amplification if amplification is None else amplification
    scene, solution, t = model.scene, model.solution, model.t_s - model.t_s[0]
    place = ROUNDINGS * UNIT_ROUNDOFF * rounded_place(model.engine, solution)
    step = (
        step_s(scene, model.setting)
        if model.setting.parameter is AccuracyParameter.STEPS_PER_ORBIT
        else 1.0 / orbit_scale(scene)
    )
    walk = np.sqrt(model.steps_taken(model.t_s))
    turn = place / min(scene.chain.length_m) * walk * (1.0 + t * orbit_scale(scene)) * amplification
    if model.setting.parameter is AccuracyParameter.STEPS_PER_ORBIT:  # velocities made of places a step apart
        turn = turn + place / (min(scene.chain.length_m) * step) * t * amplification
    size = scales(solution)
    force = PILES_UP * max(scene.chain.mass_kg) * place / step**2
    found = {
        "com": place * walk * kepler_growth(scene, t),
        "com_velocity": place * walk * kepler_growth(scene, t) * orbit_scale(scene),
        "attitude": turn,
        "rate": turn * size["rate"] + place / (min(scene.chain.length_m) * step),
        "reaction": turn * size["reaction"] + force,
        "torque": turn * size["torque"] + force * max(scene.chain.length_m),
        "impulse": turn * size["impulse"] + max(scene.chain.mass_kg) * place / step,
    }
    largest: Array = NORM_SLACK * found[quantity]
    return largest
