"""How far what should stay may drift: judged over the whole run, beyond the horizon too."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import cumulative_trapezoid

from adapters.engine import Coordinates, Knob
from barchain.local_errors import SECOND_ORDER_CONSTANT, end_derivatives, kepler_growth, step_s
from barchain.tolerances import NORM_SLACK, ROUNDINGS, UNIT_ROUNDOFF, bands, steps_taken

if TYPE_CHECKING:
    from adapters.engine import Array, Engine, Setting, Trajectory
    from barchain.truth import Truth
    from scenarios import Scene


def drift_bands(
    engine: type[Engine], scene: Scene, setting: Setting, seen: Trajectory, truth: Truth
) -> dict[str, Array]:
    """Band of each drift, shape (n,): ``gap``, ``identity`` (m), ``energy``, ``angular_momentum`` (1).

    Energy is quadratic in rates and track, angular momentum bilinear: their relative error is at most
    four times that of what they are made of, N bars each.
    """
    gap = gap_band(engine, scene, setting, seen)
    bound = bands(engine, scene, setting, seen, truth)
    relative = np.zeros(len(bound["com"]))
    if seen.rate_rad_s is not None:
        fastest = max(float(np.abs(seen.rate_rad_s).max()), scene.orbital_rate_rad_s)
        relative = scene.bars * (bound["rate"] / fastest + bound["attitude"])
    changed = 4.0 * (relative + bound["com"] / scene.radius0_m)
    return {"gap": gap, "identity": gap, "energy": changed, "angular_momentum": changed}


def gap_band(engine: type[Engine], scene: Scene, setting: Setting, seen: Trajectory) -> Array:
    """Band of the joint gaps, (n,), m, from the run's own motion.

    Joints held at velocity level (index 2) open by what the step's rule leaves of the third derivative of
    a bar's end, joints held by impulses by h²/2 of its second; a method that chooses its steps leaves the
    requested error in each. Round-off adds a random walk, in velocities too: it runs on with n t.
    """
    length = max(scene.chain.length_m)
    steps = steps_taken(scene, setting, seen)
    place = scene.radius0_m if engine.coordinates is Coordinates.ABSOLUTE else scene.size_m
    rounding = UNIT_ROUNDOFF * place * ROUNDINGS * np.sqrt(steps) * kepler_growth(scene, seen.t_s)
    left = engine.noise(scene, setting, seen.t_s).get("gap", 0.0) * steps
    if engine.coordinates is Coordinates.RELATIVE:
        return rounding  # relative positions follow from the angles: there is nothing to drift
    if setting.knob is Knob.RTOL:
        return NORM_SLACK * setting.value * length * steps * kepler_growth(scene, seen.t_s) + rounding
    second, third = end_derivatives(engine, seen)
    h2 = 0.5 * length * step_s(scene, setting) ** 2
    opened = SECOND_ORDER_CONSTANT * h2 * cumulative_trapezoid(third, seen.t_s, initial=0)
    held = 0.5 * h2 * np.maximum.accumulate(second)
    band: Array = NORM_SLACK * (opened + held) + rounding + left
    return band
