"""How far what should stay may drift: judged over the whole run, beyond the predictability limit too.

Bands follow from the motion of the reference solution. Beyond the limit its path is another one than the engine's, but
one of the same kind, and the slack of the bands covers that.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import cumulative_trapezoid

from adapters.engine import AccuracyParameter, Coordinates
from barchain.judge.declared_noise import MOST_NOISE
from barchain.judge.local_errors import (
    ROUNDINGS,
    SECOND_ORDER_CONSTANT,
    UNIT_ROUNDOFF,
    end_derivatives,
    kepler_growth,
    orbit_scale,
    step_s,
)
from barchain.judge.tolerances import NORM_SLACK, reach_m, roundoff_unit
from barchain.metrics.quantities import conserved, drifts
from barchain.solutions.reference import RICHARDSON

if TYPE_CHECKING:
    from adapters.engine import Engine
    from adapters.trajectory import Array, Trajectory
    from barchain.judge.error_model import ErrorModel
    from barchain.solutions.reference import ReferenceSolution

QUADRATIC = 4.0  # energy and angular momentum are of second degree in two kinds of things: rates (angles), track


def drift_bounds(model: ErrorModel, main: Trajectory, finer: Trajectory) -> dict[str, Array]:
    """Band of each drift, shape (n,): ``gap``, ``identity`` (m), ``energy``, ``angular_momentum`` (1)."""
    place = UNIT_ROUNDOFF * ROUNDINGS * rounded_place(model.engine, model.solution)
    found = {
        "gap": gap_bound(model),
        # a sum over the bars of places that are as good as rounding leaves them: nothing is integrated
        "identity": np.full(model.n, place * np.sqrt(model.scene.bars)),
    }
    return found | invariant_bounds(model, main, finer)


def invariant_bounds(model: ErrorModel, main: Trajectory, finer: Trajectory) -> dict[str, Array]:
    """Bands of ``energy`` and ``angular_momentum``, (n,): what the method promises, and what the finer run explains.

    Promised: energy is quadratic in rates and track, angular momentum bilinear: their relative error is at
    most four times that of what they are made of, N bars each. The track counts only where something pulls.
    Explained: the exact motion has no drift, so that Richardson's twice the change to the finer setting
    bounds it, beside round-off. The less of both is the band: neither a loosened tolerance nor
    different physics at both settings is inside.
    """
    scene, n = model.scene, model.n
    bound = model.bound
    track = np.zeros(n) if conserved(scene).relative else bound["com"] / scene.radius0_m
    relative = np.zeros(n)
    if main.rate_rad_s is not None:
        spin = fastest(model.solution)
        relative = inner_share(model.solution) * scene.bars * (bound["rate"] / spin + bound["attitude"])
    promised = QUADRATIC * (relative + track)
    floor = invariant_floor(model)
    mine, theirs = drifts(scene, main), drifts(scene, finer)
    found: dict[str, Array] = {}
    for name in ("energy", "angular_momentum"):
        if name in mine and name in theirs:
            k = min(n, len(theirs[name]))
            change = np.maximum.accumulate(np.abs(mine[name][:k] - theirs[name][:k]))
            found[name] = np.minimum(promised[:k], RICHARDSON * change + floor[:k])
    return found


def invariant_floor(model: ErrorModel) -> Array:
    """What round-off and the engine's noise leave of an invariant, (n,), relative: a random walk that does not grow."""
    scene, setting, solution = model.scene, model.setting, model.solution
    steps = np.sqrt(model.steps_taken(model.t_s))
    unit = roundoff_unit(model.engine, solution) * orbit_scale(scene) * ROUNDINGS + model.noise.get("rate", 0.0)
    walk = (inner_share(solution) * unit / fastest(solution) + ROUNDINGS * UNIT_ROUNDOFF) * steps
    requested = NORM_SLACK * setting.value if setting.parameter is AccuracyParameter.RTOL else 0.0
    found: Array = QUADRATIC * scene.bars * (walk + requested)
    return found


def inner_share(solution: ReferenceSolution) -> float:
    """Bound of what the motion about the centre of mass has of an invariant: of its kinetic energy, (L w / v)².

    All of it where the centre of mass never moves.
    """
    scene = solution.scene
    speed = float(np.linalg.norm(solution.trajectory.com_velocity_m_s, axis=-1).max())
    if conserved(scene).relative or speed == 0.0:
        return 1.0
    return float(min(1.0, (scene.size_m * fastest(solution) / speed) ** 2))


def fastest(solution: ReferenceSolution) -> float:
    """Largest rate of a bar, rad/s; at least the orbit's, where it starts at rest that of its period."""
    scene, rate = solution.scene, solution.trajectory.rate_rad_s
    spin = 0.0 if rate is None else float(np.abs(rate).max())
    return max(spin, scene.orbital_rate_rad_s) or orbit_scale(scene)


def rounded_place(engine: type[Engine], solution: ReferenceSolution) -> float:
    """Largest number that a place of a bar is made of, m."""
    if engine.coordinates is Coordinates.ABSOLUTE:
        return solution.scene.radius0_m
    return solution.scene.size_m if engine.coordinates is Coordinates.RELATIVE else reach_m(engine, solution)


def gap_bound(model: ErrorModel) -> Array:
    """Band of the joint gaps, (n,), m.

    Joints held at velocity level (index 2) open by what the step's rule leaves of the third derivative of
    a bar's end, joints held by impulses by h²/2 of its second; a method that chooses its steps leaves the
    requested error in each. Round-off adds a random walk, in velocities too: it runs on with n t. Joints that
    every step puts in place are open by where its iterations stop, and by the rounding of a sum over the bars.
    """
    scene, engine, setting, t = model.scene, model.engine, model.setting, model.t_s
    length = max(scene.chain.length_m)
    steps = model.steps_taken(t)
    unit = UNIT_ROUNDOFF * rounded_place(engine, model.solution) * ROUNDINGS
    noise = model.noise.get("gap", np.zeros(model.n))
    if engine.joints_in_place:
        return unit * scene.bars + noise
    if engine.coordinates is Coordinates.RELATIVE:  # relative positions follow from the angles
        return np.full(model.n, unit * scene.bars)
    grown = kepler_growth(scene, t - t[0])
    rounding = unit * np.sqrt(steps) * grown
    if setting.parameter is AccuracyParameter.RTOL:
        return NORM_SLACK * setting.value * length * steps * grown + rounding
    fine = model.solution.fine
    second, third = end_derivatives(engine, model.scene, fine)
    h2 = 0.5 * length * step_s(scene, setting) ** 2
    opened = np.interp(t, fine.t_s, SECOND_ORDER_CONSTANT * h2 * cumulative_trapezoid(third, fine.t_s, initial=0))
    held = np.interp(t, fine.t_s, 0.5 * h2 * np.maximum.accumulate(second))
    bound: Array = (
        NORM_SLACK * (opened + held) + rounding + np.minimum(noise * steps, MOST_NOISE * min(scene.chain.length_m))
    )
    return bound
