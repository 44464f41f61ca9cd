"""Checks of each quantity up to the predictability limit.

Is a difference explained, and inside the expected-error bound? Is the finer run inside that bound, too? Does the error
fall with the step as the method's order says?

At half the step, the error of a method of order p is smaller by 2^p, to leading order. Richardson's extrapolation of
two runs is therefore better than either run. Its remaining error is not the method's: it is wrong physics that is the
same at both settings, noise, or coarse interpolation. This check detects errors far smaller than the method's own.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.residuals import FINER_NOISE, HALVED_STEP_NOISE, worst
from barchain.judge.scales import NORM_SLACK
from barchain.judge.verdict import CheckFinding
from reports.results.comparison import ROUNDING
from reports.results.outcome import Outcome
from scenarios.channels import UNITS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from adapters.trajectory import Array
    from barchain.judge.residuals import Residuals

FINEST_NOISE = 4.0 * FINER_NOISE
"""Noise in the extrapolation of the finer and the finest run, relative to the finer run's noise"""
PERSISTING_SHARE = 0.5
"""Least size of a persisting error, relative to one setting before: terms of higher order fall four times or more, at
order 2 sixteen times"""
END_SLACK = 1e-6
"""Slack of an orbit's end, relative to the orbit: a sample meant to be at its end is in it"""


def difference_findings(run: Residuals, quantity: str) -> list[CheckFinding]:
    """Sizes of a quantity's difference, and whether it is explained and inside the expected-error bound.

    Measured round-off counts in both questions up to the floor of the coordinates, times the slack of the bounds.
    """
    inside, granted, margin = run.inside(quantity), run.granted_roundoff(quantity), run.margin[quantity]
    size, period_s = run.difference[quantity][inside], run.scene.period_s
    normalised, explained, why = judged(
        run, quantity, run.tolerance[quantity] + granted, Outcome.INCONSISTENT, "the explained error"
    )
    ratio, bounded, reason = judged(run, quantity, margin + granted, Outcome.EXCEEDS_BOUND, "the expected-error bound")
    bound = margin + granted + run.model_size.get(quantity, 0.0)
    allowed = float(bound[inside][int(np.argmax(size))])
    reported = {"rms": float(np.sqrt(np.mean(size**2))), "final": float(size[-1])}
    early = inside & (run.t <= period_s * (1.0 + END_SLACK))
    if early.sum() < run.n and run.limit_s >= period_s * (1.0 - END_SLACK):  # in chaos the last difference says little
        reported["first_orbit_max"] = float(run.difference[quantity][early].max())
    reported["detection_limit"] = detection_limit(run, quantity)
    if quantity in run.errors.floor:  # results of two machines may differ by twice the share of rounding
        reported[ROUNDING] = float(run.errors.floor[quantity][: run.n][inside].max())
    return [
        CheckFinding(quantity, "max", float(size.max()), allowed, bounded, reason),
        *(CheckFinding(quantity, name, value) for name, value in reported.items()),
        CheckFinding(quantity, "bound_ratio", ratio, 1.0, bounded),
        CheckFinding(quantity, "normalised_error", normalised, 1.0, explained, why),
    ]


def judged(run: Residuals, quantity: str, allowed: Array, failure: Outcome, named: str) -> tuple[float, Outcome, str]:
    """Largest ratio of a residual to `allowed` (n,), with outcome and reason; empty for a pass.

    Parameters
    ----------
    run : Residuals
    quantity : str
    allowed : ndarray, shape (n,)
        In the quantity's unit.
    failure : Outcome
        Outside of `allowed`, unless noise explains the rest.
    named : str
        Name of `allowed` in reasons.
    """
    inside, residual = run.inside(quantity), run.residual[quantity]
    ratio, at = worst(residual, allowed, inside)
    if ratio <= 1.0:
        return ratio, Outcome.PASS, ""
    if worst(residual, allowed + run.limiting_noise(quantity), inside)[0] <= 1.0:
        left = digits_left(run, quantity, residual[inside], f"{ratio:.3g} times {named}")
        return ratio, Outcome.ROUNDOFF_LIMITED, left
    reason = f"{ratio:.3g} times {named} at t = {run.t[at]:.6g} s"
    sizes = run.errors_by_setting(quantity)
    if sizes:
        how = "shrinks" if run.shrinks(quantity) else "does not shrink"
        told = ", ".join(f"{size:.2g}" for size in sizes)
        reason += f"; the error {how} with the setting: {told} {UNITS[quantity]} from coarse to fine"
    return ratio, failure, reason


def digits_left(run: Residuals, quantity: str, error: Array, without: str) -> str:
    """Reason of an outcome limited by round-off: its size up to `error`, the ratio `without` it, digits left."""
    inside = run.inside(quantity)
    noise = min(float(error.max()), float(run.limiting_noise(quantity)[inside].max()))
    left = max(0.0, -math.log10(float(run.residual[quantity][inside].max()) / run.scale[quantity]))
    unit = UNITS[quantity]
    return f"limited by round-off of {noise:.2g} {unit} ({without} without it): {left:.1f} digits are left"


def detection_limit(run: Residuals, quantity: str) -> float:
    """Smallest error that would be rejected at every sample, relative to the quantity's scale.

    A larger error, equal at both settings, is outside a tolerance at any sample. This holds for either sign of the
    engine's own error, and for all round-off that further runs may grant.
    """
    allowed = np.minimum(run.tolerance[quantity], run.margin[quantity]) + run.residual[quantity]
    if quantity in run.extrapolated:
        left, most = run.extrapolated[quantity]
        allowed[: len(left)] = np.minimum(allowed[: len(left)], left + most)
    granted_roundoff = 0.0 if run.com_only else NORM_SLACK * run.errors.floor[quantity][: run.n]
    return float((allowed + granted_roundoff)[run.inside(quantity)].max() / run.scale[quantity])


def finer_findings(run: Residuals) -> list[CheckFinding]:
    """Quantities in which the finer run is outside the main run's bound.

    A finer run that is off in the same way would hide an error of the main run. It takes more steps and may make more
    round-off, which is allowed: half as long steps make four times the noise of differences.
    """
    found = []
    for quantity, residual in run.finer_residual.items():
        n = len(residual)
        floor = run.finer_floor(quantity)[:n]
        margin = run.margin[quantity][:n] + floor + HALVED_STEP_NOISE * run.limiting_noise(quantity)[:n]
        if run.roundoff:
            margin = margin + np.minimum(HALVED_STEP_NOISE * run.roundoff[quantity][:n], NORM_SLACK * floor)
        used, at = worst(residual, margin, run.inside(quantity)[:n])
        if used > 1.0:
            reason = f"{used:.3g} times the expected-error bound at t = {run.t[at]:.6g} s at its finer setting"
            found.append(CheckFinding(quantity, "finer_bound_ratio", used, 1.0, Outcome.EXCEEDS_BOUND, reason))
    return found


def extrapolation_finding(run: Residuals, quantity: str) -> CheckFinding:
    """Whether a quantity's error falls less than the method's order says.

    An error of the extrapolation outside its tolerance must be there at a third setting too.
    """
    size, allowed = run.extrapolated[quantity]
    allowed = allowed + run.granted_roundoff(quantity)[: len(allowed)]
    inside = run.inside(quantity)[: len(size)]
    used, _ = worst(size, allowed, inside)
    over = persisting(run, quantity, ~(size <= allowed) & inside, size)
    if not over.any():
        said = "" if used <= 1.0 else "an error above 1 at two settings is not there at a third"
        return CheckFinding(quantity, "extrapolation_ratio", used, 1.0, Outcome.PASS, said)
    used, at = worst(size, allowed, over)
    noise = FINEST_NOISE * run.limiting_noise(quantity)[: len(allowed)]
    if worst(size, allowed + noise, over)[0] <= 1.0:
        left = digits_left(run, quantity, size[over], f"{used:.3g} times the allowed")
        return CheckFinding(quantity, "extrapolation_ratio", used, 1.0, Outcome.ROUNDOFF_LIMITED, left)
    reason = (
        f"{size[at]:.2g} {UNITS[quantity]} at t = {run.t[at]:.6g} s do not shrink with the step, "
        f"{used:.3g} times the allowed"
    )
    return CheckFinding(quantity, "extrapolation_ratio", used, 1.0, Outcome.INCONSISTENT, reason)


def persisting(run: Residuals, quantity: str, over: NDArray[np.bool_], size: Array) -> NDArray[np.bool_]:
    """Samples (n,) at which an error `size` (n,), `over` its tolerance, is there at a third setting too.

    Without a third setting, all samples over the tolerance.
    """
    if run.finest is None:
        return over
    later, allowed = run.extrapolation_error(quantity, run.finer, run.finest, FINEST_NOISE)
    n = min(len(later), len(size))
    found = np.zeros_like(over)
    found[:n] = over[:n] & (later[:n] > allowed[:n]) & (later[:n] > PERSISTING_SHARE * size[:n])
    return found
