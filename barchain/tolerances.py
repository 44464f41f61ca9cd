"""Every tolerance of the comparison, in one place, each with its derivation.

Two questions are asked of a difference from the truth, at every sample up to the horizon.

*Consistent?* It is explained by the two error estimates, round-off, and the declared model difference:
``explained = 2 (E_engine + E_truth) + floor + model``. The 2 is Richardson's, see `barchain.truth.RICHARDSON`.

*Good enough?* It is inside the band that the engine's method and setting promise on this scene, ``band``.

Both use the growth G(t) of a small perturbation, measured by the truth's twin: an error made at s is
G(t)/G(s) times as large at t.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import Coordinates, Knob
from barchain.local_errors import (
    ROUNDINGS,
    UNIT_ROUNDOFF,
    departure,
    kepler_growth,
    local_errors,
    orbit_rate_bound,
    orbit_scale,
    step_s,
    track_unit,
)
from barchain.truth import PARTED_RAD, RICHARDSON

if TYPE_CHECKING:
    from adapters.engine import Array, Engine, Setting, Trajectory
    from barchain.truth import Truth
    from scenarios import Scene

NORM_SLACK = 10.0  # largest component against norm, constants of the method other than the textbook's, stage effects


def steps_taken(scene: Scene, setting: Setting, seen: Trajectory) -> Array:
    """Steps taken up to each sample, (n,): counted by the engine, or from its setting."""
    share = seen.t_s / scene.run.duration_s
    if setting.knob is Knob.STEPS_PER_ORBIT:
        return 1.0 + share * scene.run.duration_s / step_s(scene, setting)
    return 1.0 + share * float(seen.info.get("steps", scene.run.samples))


def roundoff_unit(engine: type[Engine], truth: Truth) -> float:
    """Angle that one rounding of a position is worth, rad: u for lengths of a bar, u r/l for distances.

    In a frame on an orbit of its own the chain's places are as large as what drives it off that orbit makes them.
    """
    scene, away = truth.scene, reach_m(engine, truth)
    if engine.coordinates is Coordinates.ABSOLUTE:
        away = scene.radius0_m
    elif engine.coordinates is Coordinates.RELATIVE:
        away = scene.size_m
    return UNIT_ROUNDOFF * away / min(scene.chain.length_m)


def reach_m(engine: type[Engine], truth: Truth) -> float:
    """Largest place of a bar in an engine's frame, m: the chain's size, and its departure from the frame's orbit."""
    place, _ = departure(engine, truth.scene, truth.trajectory)
    return truth.scene.size_m + float(np.linalg.norm(place, axis=1).max())


def floors(engine: type[Engine], scene: Scene, setting: Setting, seen: Trajectory, truth: Truth) -> dict[str, Array]:
    """What round-off alone may contribute to each quantity, (n,): a random walk of the steps' roundings, amplified.

    On top comes what the engine declares of itself (`Engine.noise`): the tolerance of its iterations, and
    the noise of multipliers that are differences over a step.
    """
    n = common_samples(seen, truth)
    walk = ROUNDINGS * np.sqrt(steps_taken(scene, setting, seen)[:n])
    noise = engine.noise(scene, setting, truth.trajectory.t_s[:n])
    angle = (roundoff_unit(engine, truth) * walk + noise.get("attitude", 0.0)) * truth.growth[:n]
    angle = np.minimum(angle, RICHARDSON * PARTED_RAD)  # up to the horizon no attitude is off by more
    found = {
        name: angle * truth.response[name][:n] + rounded(truth.trajectory, name)[:n] + noise.get(name, 0.0)
        for name in truth.response
    }
    if "rate" in found:  # a place rounded once in a radian of the orbit
        found["rate"] += roundoff_unit(engine, truth) * ROUNDINGS * orbit_scale(scene)
    distance = np.maximum.accumulate(np.linalg.norm(truth.trajectory.com_m[:n], axis=1))
    carried = UNIT_ROUNDOFF * walk * kepler_growth(scene, truth.trajectory.t_s[:n])
    speed = np.maximum.accumulate(np.linalg.norm(truth.trajectory.com_velocity_m_s[:n], axis=1))
    found["com"] += distance * carried
    found["com_velocity"] += speed * carried
    return found


def rounded(seen: Trajectory, quantity: str) -> Array:
    """Rounding of a value that is a sum over the bars, (n,): N terms of at most its own size."""
    values = {
        "attitude": seen.angle_rad,
        "rate": seen.rate_rad_s,
        "reaction": seen.reaction_N,
        "torque": seen.torque_N_m,
        "impulse": seen.impulse_N_s,
    }
    found = values.get(quantity)
    bars = 1 if seen.angle_rad is None else seen.angle_rad.shape[1]
    if found is None or not found.size:
        return np.zeros(len(seen.t_s))
    size = np.abs(found).reshape(len(seen.t_s), -1).max(axis=1)
    largest: Array = UNIT_ROUNDOFF * ROUNDINGS * bars * np.maximum.accumulate(size)
    return largest


def bands(engine: type[Engine], scene: Scene, setting: Setting, seen: Trajectory, truth: Truth) -> dict[str, Array]:
    """What the method promises at this setting, (n,) for each quantity, floors included.

    Errors of attitude made at s are carried to t by G(t)/G(s), and into the other quantities by the
    twin's measured response; the track of the centre of mass has its own local errors besides.
    """
    n = common_samples(seen, truth)
    t, growth = truth.trajectory.t_s[:n], truth.growth[:n]
    local = local_errors(engine, scene, setting, truth, float(seen.info.get("steps", 0.0)))
    # carried on: the error of the start (half a step aside), and all that are made on the way
    attitude = growth * local.immediate["attitude"][0] + local.attitude(t, growth)
    floor = floors(engine, scene, setting, seen, truth)
    parted = RICHARDSON * PARTED_RAD  # up to the horizon no attitude is off by more
    found = {}
    for name, response in truth.response.items():
        direct = local.immediate[name][:n] if name in local.immediate else 0.0
        carried = np.minimum(NORM_SLACK * attitude, parted)
        if name != "attitude":  # the twin parts in one direction; others may answer more strongly
            carried = NORM_SLACK * np.minimum(attitude, parted)
        found[name] = carried * response[:n] + NORM_SLACK * direct + floor[name]
    track = NORM_SLACK * local.track(scene, t)
    found["com"] += track
    found["com_velocity"] += track * orbit_rate_bound(scene, truth.trajectory)
    return found


def common_samples(seen: Trajectory, truth: Truth) -> int:
    """Number of samples that both have."""
    return min(len(seen.t_s), len(truth.growth))


def explained(
    engine: type[Engine], own: dict[str, Array], setting: Setting, truth: Truth, extra: list[dict[str, Array]]
) -> dict[str, Array]:
    """What may stand between an engine and the truth if both are right, (n,) for each quantity.

    Both error estimates, `extra` (floors, kinks), and for a method that chooses its steps a few steps' requests:
    its errors are a sum of what single steps leave, of any sign, so that two of its runs may meet where both are
    off. The slack is that of the band, NORM_SLACK; for a track asked for in radii, far above what is made, one step.
    """
    n = min(len(truth.growth), *map(len, own.values()))  # an engine may run on where the truth has ended
    found = {}
    for name in own.keys() & truth.error.keys():
        both = np.maximum.accumulate(own[name][:n]) + truth.error[name][:n]
        found[name] = RICHARDSON * both + sum((e[name][:n] for e in extra if name in e), np.zeros(n))
        if setting.knob is Knob.RTOL:
            requested = np.maximum(NORM_SLACK * truth.response[name][:n], step_unit(engine, name, truth.scene, setting))
            found[name] += setting.value * requested
    return found


def step_unit(engine: type[Engine], quantity: str, scene: Scene, setting: Setting) -> float:
    """What the requested accuracy of a step counts in, where it is not the answer to an angle: SI units."""
    track = track_unit(engine, scene, setting.value) * (NORM_SLACK if engine.track_by_length else 1.0)
    units = {"com": track, "com_velocity": track * orbit_scale(scene), "rate": orbit_scale(scene)}
    return units.get(quantity, 0.0)
