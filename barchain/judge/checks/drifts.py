"""Drifts of joint gaps, centre-of-mass residual, energy and angular momentum over the whole run, and their bounds.

The bounds follow from the motion of the judging solution. Beyond the predictability limit the engine's path is a
different one of the same kind, and the slack of the bounds covers the difference.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import cumulative_trapezoid

from adapters.common.equal_steps import step_s
from adapters.engine import AccuracyParameter, Coordinates
from barchain.judge.local_errors import SECOND_ORDER_CONSTANT, end_derivatives
from barchain.judge.residuals import worst
from barchain.judge.scales import MACHINE_EPSILON, MAX_NOISE_SHARE, NORM_SLACK, ROUNDINGS, orbit_scale
from barchain.judge.verdict import CheckFinding
from barchain.metrics.quantities import conserved
from barchain.solutions.reference import RICHARDSON
from reports.results.comparison import ROUNDING
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Mapping

    from adapters.trajectory import Array
    from barchain.judge.error_model import ErrorModel
    from barchain.judge.residuals import Residuals
    from barchain.solutions.reference import ReferenceSolution

    Drifts = dict[str, Array]

QUADRATIC = 4.0
"""Energy and angular momentum are of second degree in two kinds of variables: rates (angles) and track"""
WHOLE = ("energy", "angular_momentum")
ABOUT_COM = tuple(f"{name}_about_com" for name in WHOLE)
"""Balances about the centre of mass: the rates of the bars are all that there is"""


def drift_findings(run: Residuals, main: Drifts, bound: Drifts) -> list[CheckFinding]:
    """Whether each drift of the main run is inside its bound, and its share of rounding.

    Parameters
    ----------
    run : Residuals
    main : dict of ndarray, shape (n,)
        Drifts of its main run.
    bound : dict of ndarray, shape (n,)
        Of :func:`drift_bounds`.
    """
    rounding, found = drift_rounding(run.errors), []
    for quantity, drift in main.items():
        n = min(len(drift), len(bound[quantity]))
        allowed = bound[quantity][:n]
        if quantity in run.roundoff:  # rounding is all that there is in joints and sums of places
            allowed = allowed + np.minimum(run.roundoff[quantity][:n], NORM_SLACK * allowed)
        used, at = worst(drift[:n], allowed, np.ones(n, bool))
        good = Outcome.PASS if used <= 1.0 else Outcome.EXCEEDS_BOUND
        reason = "" if used <= 1.0 else f"{used:.3g} times the drift's bound at t = {run.main.t_s[at]:.6g} s"
        top = int(np.argmax(drift[:n]))
        found.append(CheckFinding(quantity, "drift", float(drift[top]), float(allowed[top]), good, reason))
        found.append(CheckFinding(quantity, ROUNDING, rounding[quantity]))
    return found


def drift_bounds(model: ErrorModel, main: Drifts, finer: Drifts) -> dict[str, Array]:
    """Bound of each drift, (n,): ``gap``, ``com_residual`` (m), those of :data:`WHOLE` and :data:`ABOUT_COM` (1).

    Parameters
    ----------
    model : ErrorModel
    main, finer : dict of ndarray, shape (n,)
        Drifts of the engine's two runs (`barchain.metrics.quantities.drifts`).
    """
    found = {
        "gap": gap_bound(model),
        # a sum over the bars of rounded places: nothing is integrated
        "com_residual": np.full(model.n, model.rounding_m * np.sqrt(model.scene.bars)),
    }
    return found | invariant_bounds(model, main, finer)


def invariant_bounds(model: ErrorModel, main: Drifts, finer: Drifts) -> dict[str, Array]:
    """Bounds of :data:`WHOLE` and :data:`ABOUT_COM`, (n,), relative: the smaller of promised and explained drift.

    Promised drift: energy is quadratic in rates and track, angular momentum bilinear. Their relative error is at most
    four times that of their factors, N bars each. The track counts only where a force acts.
    Explained drift: the exact motion has no drift. Richardson's twice the change to the finer setting therefore bounds
    it, beside round-off. Neither a loosened tolerance nor different physics at both settings is inside the smaller one.
    Two runs may have the same drift by chance, most so in their first steps. Where no step's request covers that, the
    change of their states, carried into the invariant, explains a drift up to the limit.
    """
    scene, n = model.scene, model.n
    names = [name for name in (*WHOLE, *ABOUT_COM) if name in main and name in finer]
    if not names:
        return {}
    requested = NORM_SLACK * model.setting.value if model.setting.parameter is AccuracyParameter.RTOL else 0.0
    found: dict[str, Array] = {}
    for name in names:
        k = min(n, len(finer[name]))
        promised = carried(model, name, model.bound)
        change = np.maximum.accumulate(np.abs(main[name][:k] - finer[name][:k]))
        turned = inner_share(model.solution, name) * model.noise.get("attitude", np.zeros(n))
        floor = QUADRATIC * scene.bars * (invariant_walk(model, name) + turned + requested)
        explained = RICHARDSON * change + floor[:k]
        if model.by_change_alone:
            explained = np.maximum(explained, promised[: np.count_nonzero(model.t_s <= model.limit_s)].max())
        found[name] = np.minimum(promised[:k], explained) + written_share(model, name)[:k]
    return found


def written_share(model: ErrorModel, name: str) -> Array:
    """Error of an invariant, (n,), relative, by values that were written with few digits."""
    if not model.written:
        return np.zeros(model.n)
    speed = float(np.linalg.norm(model.solution.trajectory.com_velocity_m_s, axis=-1).max())
    velocity = 0.0 if name in ABOUT_COM or speed == 0.0 else QUADRATIC * model.written["com_velocity"] / speed
    found: Array = carried(model, name, model.written) + velocity
    return found


def carried(model: ErrorModel, name: str, errors: Mapping[str, Array]) -> Array:
    """Errors of attitude, rates and track, (n,) each, as they appear in an invariant, (n,), relative."""
    scene, solution = model.scene, model.solution
    relative = scene.bars * (errors["rate"] / fastest(solution) + errors["attitude"])
    straight = name in ABOUT_COM or conserved(scene).relative
    track = np.zeros(model.n) if straight else errors["com"] / scene.radius0_m
    found: Array = QUADRATIC * (inner_share(solution, name) * relative + track)
    return found


def invariant_walk(model: ErrorModel, name: str) -> Array:
    """Random walk of the roundings and the engine's noise in a factor of an invariant, (n,), relative."""
    scene, solution = model.scene, model.solution
    unit = model.rounding_rad * orbit_scale(scene) + model.noise.get("rate", 0.0)
    found: Array = (inner_share(solution, name) * unit / fastest(solution) + ROUNDINGS * MACHINE_EPSILON) * model.walk
    return found


def drift_rounding(model: ErrorModel) -> dict[str, float]:
    """Largest share of rounding in each drift: of invariants relative, of joint gaps and centre-of-mass residuals in m.

    Places round once in each step, whatever keeps the joints closed, and their errors grow with the orbit.
    """
    places = model.rounding_m * (model.scene.bars + float(np.max(model.walk * model.track_growth)))
    noise = float(np.max(model.noise.get("gap", 0.0)))
    found = {
        name: QUADRATIC * model.scene.bars * float(np.max(invariant_walk(model, name))) for name in (*WHOLE, *ABOUT_COM)
    }
    return found | {"gap": places + noise, "com_residual": places}


def inner_share(solution: ReferenceSolution, name: str) -> float:
    """Largest share of an invariant in the motion about the centre of mass, relative to the whole: (L w / v)².

    It is 1 of balances about the centre of mass, and where the centre of mass never moves.
    """
    scene = solution.scene
    speed = float(np.linalg.norm(solution.trajectory.com_velocity_m_s, axis=-1).max())
    if name in ABOUT_COM or conserved(scene).relative or speed == 0.0:
        return 1.0
    return float(min(1.0, (scene.size_m * fastest(solution) / speed) ** 2))


def fastest(solution: ReferenceSolution) -> float:
    """Largest rate of a bar, rad/s; at least the orbit's, or 2 pi over its period where the orbit starts at rest."""
    scene, rate = solution.scene, solution.trajectory.rate_rad_s
    spin = 0.0 if rate is None else float(np.abs(rate).max())
    return max(spin, scene.speed_rate_rad_s) or orbit_scale(scene)


def gap_bound(model: ErrorModel) -> Array:
    """Bound of the joint gaps, (n,), m.

    Joints held at velocity level (index 2) open by C h² times the third derivative of a bar's end. Joints held by
    impulses open by h²/2 times its second derivative. A method that chooses its steps leaves the requested error in
    each. Round-off adds a random walk, in velocities too: it grows with n t. Joints closed in every step are open by
    the tolerance of its iterations, and by the rounding of a sum over the bars.
    """
    scene, engine, setting, t = model.scene, model.engine, model.setting, model.t_s
    length, steps, unit = max(scene.chain.length_m), model.steps_taken, model.rounding_m
    noise = model.noise.get("gap", np.zeros(model.n))
    if engine.joints_in_place:
        return unit * scene.bars + noise
    if engine.coordinates is Coordinates.RELATIVE:  # relative positions follow from the angles
        return np.full(model.n, unit * scene.bars)
    rounding = unit * model.walk * model.track_growth
    if setting.parameter is AccuracyParameter.RTOL:
        return NORM_SLACK * setting.value * length * steps * model.track_growth + rounding
    fine = model.solution.fine
    second, third = end_derivatives(engine, model.scene, fine)
    h2 = 0.5 * length * step_s(scene, setting.value) ** 2
    opened = np.interp(t, fine.t_s, SECOND_ORDER_CONSTANT * h2 * cumulative_trapezoid(third, fine.t_s, initial=0))
    held = np.interp(t, fine.t_s, 0.5 * h2 * np.maximum.accumulate(second))
    bound: Array = (
        NORM_SLACK * (opened + held) + rounding + np.minimum(noise * steps, MAX_NOISE_SHARE * min(scene.chain.length_m))
    )
    return bound
