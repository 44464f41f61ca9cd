"""Scales that errors are counted in: sizes of quantities, rates of the orbit, roundings and noise of a run.

An engine's class declares noise, its runs count steps, and perturbed runs show round-off: the same setting is run again
with other last bits, in a slightly turned frame, from a start moved by a few units in the last place. Each widens the
engine's tolerances. A wrong or noisy engine could make room for its errors that way, so that each has a bound that
follows from the scene, the setting and the engine's coordinates. No coordinates are larger than the orbit's radius.
"""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING

import numpy as np

from barchain.metrics.quantities import FIELDS, TRACK, differences, drifts, rate_scale
from scenarios.channels import UNITS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.engine import Declarations, Setting
    from adapters.trajectory import Array, Trajectory
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

NORM_SLACK = 10.0
"""Slack of all bounds: largest component against norm, method constants other than the textbook's, stage effects"""
MACHINE_EPSILON = float(np.finfo(float).eps)  # twice the unit roundoff: distance from 1 to the next double
ROUNDINGS = 16.0
"""Rounding errors that enter a state in one step: a handful of operations, one for each stage"""
MAX_NOISE_SHARE = 1e-2
"""Largest declared noise relative to a quantity's scale: with more, nothing worth comparing is left"""
MAX_ATTITUDE_NOISE_RAD = 1e-5
"""Largest declared noise of the attitude, which is amplified: a thousandth of the distance of parted runs"""
MAX_TRACK_NOISE_SHARE = 1e-6
"""Largest declared noise of the track relative to distance and speed: all engines here are good to 1e-9"""
STEPS_SLACK = 10.0
"""Slack of a step count: error constants, rejected steps, restarts at events"""
LOWEST_ORDER = 4.0
"""Lowest order of the error estimates of methods that choose their steps: rtol^(-1/5) steps a radian"""
SPREAD_FACTOR = 5.0
"""Times the largest difference among four runs: of four errors of one distribution, one is farther from the right value
than this with a chance of 1e-3"""
EARLY = 4
"""Samples at the start whose round-off is of one size: at the first alone, four runs may agree by chance"""


def scales(solution: ReferenceSolution) -> dict[str, float]:
    """Size of each quantity over the whole run, from the judging solution and the scene alone; SI units.

    ``attitude`` counts in radians, ``rate`` in the fastest rate of a bar. ``reaction`` counts in the largest one, but
    in no less than the inertia force of the bars: where forces cancel, their sum says nothing of what they are made of.
    """
    scene, seen = solution.scene, solution.trajectory
    force = inertia_force_N(scene)
    found = {
        "com": largest(seen.com_m),
        "com_velocity": largest(seen.com_velocity_m_s) or scene.size_m * scene.fastest_rate_rad_s,  # never of no size
        "attitude": 1.0,
        "rate": max(largest_entry(seen.rate_rad_s), scene.fastest_rate_rad_s),
        "reaction": max(largest(seen.reaction_N), force),
        "torque": max(largest_entry(seen.torque_N_m), force * max(scene.chain.length_m)),
        "impulse": max(largest(seen.impulse_N_s), force / scene.fastest_rate_rad_s),
        "gap": min(scene.chain.length_m),
        "com_residual": min(scene.chain.length_m),
    }
    return found | dict.fromkeys(("energy", "angular_momentum", "energy_about_com", "angular_momentum_about_com"), 1.0)


def inertia_force_N(scene: Scene) -> float:
    """Force that turns the heaviest bar about its end at the orbit's rate, or at the bars' own, N: m l w²."""
    chain = scene.chain
    return max(m * size for m, size in zip(chain.mass_kg, chain.length_m, strict=True)) * scene.fastest_rate_rad_s**2


def largest(vectors: Array | None) -> float:
    """Largest length of vectors (..., 2); 0 of none."""
    return 0.0 if vectors is None else float(np.linalg.norm(vectors, axis=-1).max(initial=0.0))


def largest_entry(values: Array | None) -> float:
    """Largest absolute value; 0 of none."""
    return 0.0 if values is None else float(np.abs(values).max(initial=0.0))


def orbit_scale(scene: Scene) -> float:
    """Rate of the orbit: its mean motion, or that of the circular orbit at r0 if faster."""
    return 2.0 * math.pi / scene.step_period_s


def kepler_growth(scene: Scene, t_s: Array) -> Array:
    """Growth of a small error of the centre of mass, (n,): 1 + 3 n t, an error of the period along the track."""
    return 1.0 + 3.0 * orbit_scale(scene) * t_s


def orbit_rate_bound(scene: Scene, trajectory: Trajectory) -> float:
    """Largest rate at which a displaced centre of mass moves: speed over distance, where the orbit is lowest."""
    speed, distance = (np.linalg.norm(x, axis=1) for x in (trajectory.com_velocity_m_s, trajectory.com_m))
    return max(orbit_scale(scene), float((speed / distance).max()))


def rounded_sum(trajectory: Trajectory, quantity: str) -> Array:
    """Rounding of a value that is a sum over N bars, (n,), in the quantity's unit: N terms of at most its own size."""
    values = None if quantity in TRACK else getattr(trajectory, FIELDS[quantity])
    bars = 1 if trajectory.angle_rad is None else trajectory.angle_rad.shape[1]
    if values is None or not values.size:
        return np.zeros(len(trajectory.t_s))
    size = np.abs(values).reshape(len(trajectory.t_s), -1).max(axis=1)
    largest: Array = MACHINE_EPSILON * ROUNDINGS * bars * np.maximum.accumulate(size)
    return largest


def declared_noise(engine: Declarations, setting: Setting, solution: ReferenceSolution, t_s: Array) -> dict[str, Array]:
    """Noise that an engine declares, (n,) for each quantity, as declared.

    Parameters
    ----------
    engine : Declarations
    setting : Setting
    solution : ReferenceSolution
    t_s : ndarray, shape (n,)
        Instants from the start of the scene, s.
    """
    said = engine.noise(solution.scene, setting, t_s)
    return {name: np.array(np.broadcast_to(np.abs(values), t_s.shape)) for name, values in said.items()}


def believed_noise(noise: dict[str, Array], size: dict[str, float]) -> dict[str, Array]:
    """Declared noise as far as it is believed, (n,) for each quantity.

    Transient noise, such as that of the start, is cut off at :func:`max_noise`. Noise that is still larger at the end
    is not believed at all: an engine that noisy can't pass.
    """
    found = {}
    for name, values in noise.items():
        most = max_noise(name, size)
        found[name] = np.minimum(values, most) if values[-1] <= most else np.zeros_like(values)
    return found


def max_noise(quantity: str, size: dict[str, float]) -> float:
    """Largest declared noise of a quantity that is believed, in its unit; `size`: the quantities' scales."""
    if quantity == "attitude":
        return MAX_ATTITUDE_NOISE_RAD
    return (MAX_TRACK_NOISE_SHARE if quantity in TRACK else MAX_NOISE_SHARE) * size[quantity]


def too_noisy(noise: dict[str, Array], size: dict[str, float]) -> str | None:
    """Reason if an engine declares more noise than is believed, for the worst quantity; None if all is believed."""
    over = {name: float(values.max()) / max_noise(name, size) for name, values in noise.items()}
    worst = max(over, key=lambda name: over[name], default="")
    if not worst or over[worst] <= 1.0:
        return None
    unit, said = UNITS[worst], float(noise[worst].max())
    return (
        f"its adapter declares that iterations and rounding leave {said:.2g} {unit} of the {worst} uncertain here; "
        f"at most {max_noise(worst, size):.2g} {unit} can be compared"
    )


def believed_steps(setting: Setting, solution: ReferenceSolution, counted: float) -> float:
    """Step count of a method that chooses its steps, or 0 if no method would take so many steps.

    A method whose error estimate is of order p takes about rtol^(-1/(p+1)) steps in a radian of the motion. A count
    beyond that of the lowest order in use, times a slack, is not used at all.
    """
    rate = rate_scale(solution.scene, solution.trajectory)
    radians = 1.0 + rate * solution.scene.run.duration_s
    most = STEPS_SLACK * radians * setting.value ** (-1.0 / (LOWEST_ORDER + 1.0))
    return counted if 0.0 < counted <= max(most, solution.scene.run.samples) else 0.0


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
