"""How far what should stay may drift: judged over the whole run, beyond the horizon too."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import cumulative_trapezoid

from adapters.engine import Coordinates, Knob
from barchain.local_errors import (
    ROUNDINGS,
    SECOND_ORDER_CONSTANT,
    UNIT_ROUNDOFF,
    end_derivatives,
    kepler_growth,
    orbit_scale,
    step_s,
)
from barchain.quantities import conserved, drifts
from barchain.tolerances import NORM_SLACK, bands, common_samples, reach_m, roundoff_unit, steps_taken
from barchain.truth import RICHARDSON

if TYPE_CHECKING:
    from adapters.engine import Array, Engine, Setting, Trajectory
    from barchain.truth import Truth
    from scenarios import Scene

QUADRATIC = 4.0  # energy and angular momentum are of second degree in two kinds of things: rates (angles), track


def drift_bands(
    engine: type[Engine], setting: Setting, seen: Trajectory, finer: Trajectory, truth: Truth
) -> dict[str, Array]:
    """Band of each drift, shape (n,): ``gap``, ``identity`` (m), ``energy``, ``angular_momentum`` (1)."""
    scene = truth.scene
    place = UNIT_ROUNDOFF * ROUNDINGS * rounded_place(engine, truth)
    found = {
        "gap": gap_band(engine, setting, seen, truth),
        # a sum over the bars of places that are as good as rounding leaves them: nothing is integrated
        "identity": np.full(len(seen.t_s), place * np.sqrt(scene.bars)),
    }
    return found | invariant_bands(engine, setting, seen, finer, truth)


def invariant_bands(
    engine: type[Engine], setting: Setting, seen: Trajectory, finer: Trajectory, truth: Truth
) -> dict[str, Array]:
    """Bands of ``energy`` and ``angular_momentum``, (n,): what the method promises, and what the finer run explains.

    Promised: energy is quadratic in rates and track, angular momentum bilinear: their relative error is at
    most four times that of what they are made of, N bars each. The track counts only where something pulls.
    Explained: the exact motion has no drift, so that Richardson's twice the change to the finer setting
    bounds it, beside round-off. The less of both is the band: neither a loosened tolerance nor
    different physics at both settings is inside.
    """
    scene, n = truth.scene, common_samples(seen, truth)
    bound = bands(engine, scene, setting, seen, truth)
    track = np.zeros(n) if conserved(scene).relative else bound["com"] / scene.radius0_m
    relative = np.zeros(n)
    if seen.rate_rad_s is not None:
        relative = inner_share(scene, seen) * scene.bars * (bound["rate"] / fastest(scene, seen) + bound["attitude"])
    promised = QUADRATIC * (relative + track)
    floor = invariant_floor(engine, setting, seen, truth)
    mine, theirs = drifts(scene, seen), drifts(scene, finer)
    found: dict[str, Array] = {}
    for name in ("energy", "angular_momentum"):
        if name in mine and name in theirs:
            k = min(n, len(theirs[name]))
            change = np.maximum.accumulate(np.abs(mine[name][:k] - theirs[name][:k]))
            found[name] = np.minimum(promised[:k], RICHARDSON * change + floor[:k])
    return found


def invariant_floor(engine: type[Engine], setting: Setting, seen: Trajectory, truth: Truth) -> Array:
    """What round-off and the engine's noise leave of an invariant, (n,), relative: a random walk that does not grow."""
    scene, n = truth.scene, common_samples(seen, truth)
    steps = np.sqrt(steps_taken(scene, setting, seen)[:n])
    noise = engine.noise(scene, setting, seen.t_s[:n])
    unit = roundoff_unit(engine, truth) * orbit_scale(scene) * ROUNDINGS + noise.get("rate", 0.0)
    walk = (inner_share(scene, seen) * unit / fastest(scene, seen) + ROUNDINGS * UNIT_ROUNDOFF) * steps
    requested = NORM_SLACK * setting.value if setting.knob is Knob.RTOL else 0.0
    found: Array = QUADRATIC * scene.bars * (walk + requested)
    return found


def inner_share(scene: Scene, seen: Trajectory) -> float:
    """Bound of what the motion about the centre of mass has of an invariant: of its kinetic energy, (L w / v)².

    All of it where the centre of mass never moves.
    """
    speed = float(np.linalg.norm(seen.com_velocity_m_s, axis=-1).max())
    if conserved(scene).relative or speed == 0.0:
        return 1.0
    return float(min(1.0, (scene.size_m * fastest(scene, seen) / speed) ** 2))


def fastest(scene: Scene, seen: Trajectory) -> float:
    """Largest rate of a bar, rad/s; at least the orbit's, where it starts at rest that of its period."""
    spin = 0.0 if seen.rate_rad_s is None else float(np.abs(seen.rate_rad_s).max())
    return max(spin, scene.orbital_rate_rad_s) or orbit_scale(scene)


def rounded_place(engine: type[Engine], truth: Truth) -> float:
    """Largest number that a place of a bar is made of, m."""
    if engine.coordinates is Coordinates.ABSOLUTE:
        return truth.scene.radius0_m
    return truth.scene.size_m if engine.coordinates is Coordinates.RELATIVE else reach_m(engine, truth)


def gap_band(engine: type[Engine], setting: Setting, seen: Trajectory, truth: Truth) -> Array:
    """Band of the joint gaps, (n,), m, from the run's own motion.

    Joints held at velocity level (index 2) open by what the step's rule leaves of the third derivative of
    a bar's end, joints held by impulses by h²/2 of its second; a method that chooses its steps leaves the
    requested error in each. Round-off adds a random walk, in velocities too: it runs on with n t. Joints that
    every step puts in place are open by where its iterations stop, and by the rounding of a sum over the bars.
    """
    scene = truth.scene
    length = max(scene.chain.length_m)
    steps = steps_taken(scene, setting, seen)
    unit = UNIT_ROUNDOFF * rounded_place(engine, truth) * ROUNDINGS
    noise = engine.noise(scene, setting, seen.t_s).get("gap", 0.0)
    if engine.joints_in_place:
        return np.full(len(seen.t_s), unit * scene.bars + noise)
    if engine.coordinates is Coordinates.RELATIVE:  # relative positions follow from the angles
        return np.full(len(seen.t_s), unit * scene.bars)
    rounding = unit * np.sqrt(steps) * kepler_growth(scene, seen.t_s)
    left = noise * steps
    if setting.knob is Knob.RTOL:
        return NORM_SLACK * setting.value * length * steps * kepler_growth(scene, seen.t_s) + rounding
    second, third = end_derivatives(engine, seen)
    h2 = 0.5 * length * step_s(scene, setting) ** 2
    opened = SECOND_ORDER_CONSTANT * h2 * cumulative_trapezoid(third, seen.t_s, initial=0)
    held = 0.5 * h2 * np.maximum.accumulate(second)
    band: Array = NORM_SLACK * (opened + held) + rounding + left
    return band
