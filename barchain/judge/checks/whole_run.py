"""Faults of a run as a whole: its end, the samples that can be compared, and the digits of its values."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.trajectory import ENDED
from barchain.judge.checks.more_judged import next_sample
from barchain.judge.residuals import other_end
from barchain.judge.verdict import CheckFinding
from barchain.metrics.quantities import FIELDS
from barchain.runs.trajectory_checks import TIME_SLACK
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from barchain.judge.residuals import Residuals
    from barchain.solutions.reference import ReferenceSolution

FEWEST = 12
"""Different values that a channel must have: by chance they all lie on a lattice a hundred times coarser than their
own digits with a probability of 1e-24"""
COARSE = 100.0  # units in the last place: a lattice closer than that is what rounding makes of any number
LEFT_OVER = 1e-6  # of a channel's largest right value: smaller ones may be left over by sums, with few bits
EXPONENTS = range(-12, 4)
DEGREE = np.pi / 180.0
ANGULAR = ("attitude", "rate")
"""Quantities that may have been rounded in degrees"""
ROUNDED = 4.0  # units in the last place, of a number that was multiplied by its unit
ERRORS = 10.0  # of the judging solution: where a value is exact, its error is no more than this off the decimal
MOSTLY = 0.5  # of the reference's values: chance puts next to none on a lattice so coarse


def fault_of_run(run: Residuals) -> CheckFinding | None:
    """First fault of the run as a whole, or None."""
    for role, seen in (("", run.main), (" (at its finer setting)", run.finer)):
        said = other_end(seen, run.solution)
        if said is not None:
            return CheckFinding("run", "outcome", outcome=Outcome.INCOMPLETE, reason=said + role)
    said = other_end_instant(run)
    if said is not None:
        return CheckFinding("run", "outcome", outcome=Outcome.INCONSISTENT, reason=said)
    said = "" if run.com_only else next_sample(run.errors)
    if said:
        return CheckFinding("run", "outcome", outcome=Outcome.TOO_COARSE, reason=said)
    said = None if run.errors.written else rounded_values(run.main, run.solution)
    return None if said is None else CheckFinding("run", "outcome", outcome=Outcome.MALFORMED, reason=said)


def other_end_instant(run: Residuals) -> str | None:
    """Say why, if both runs located the instant of their end and their errors do not explain its difference."""
    mine, theirs = (float(seen.info.get(ENDED, np.nan)) for seen in (run.main, run.solution.trajectory))
    if np.isnan(mine - theirs):
        return None
    apart, allowed = abs(mine - theirs), landing_tolerance_s(run)
    if apart <= allowed:
        return None
    return f"ended {apart:.3g} s apart from the reference, {apart / allowed:.3g} times the explained difference"


def landing_tolerance_s(run: Residuals) -> float:
    """Explained difference of the instants at which a bar reached the surface, s.

    The places of the chain's ends have the errors of track and attitude at the last sample, and of their rates until
    the next. Beyond the predictability limit a bar may point anywhere. The errors are divided by the speed of descent:
    that of the centre of mass less that of the bars' rotation about it. Where this difference is not positive, the
    chain grazes the surface, and the instant is judged to one sample.
    """
    seen, size, last = run.solution.trajectory, run.scene.size_m, run.n - 1
    spacing = run.scene.run.duration_s / (run.scene.run.samples - 1)
    if seen.rate_rad_s is None or not {"attitude", "rate"} <= run.difference.keys():
        return spacing
    place, velocity = seen.com_m[last], seen.com_velocity_m_s[last]
    turning = float(np.abs(seen.rate_rad_s[last]).max())
    down = -float(place @ velocity) / float(np.linalg.norm(place)) - size * turning
    off = {name: float(run.tolerance[name][last]) for name in ("com", "com_velocity", "attitude", "rate")}
    if run.t[last] > run.limit_s:
        off |= {"attitude": 1.0, "rate": turning}
    ends = off["com"] + size * off["attitude"]
    ends += spacing * (off["com_velocity"] + size * (off["rate"] + turning * off["attitude"]))
    return TIME_SLACK * run.scene.run.duration_s + ends / down if down > 0.0 else spacing


def rounded_values(trajectory: Trajectory, solution: ReferenceSolution | None = None) -> str | None:
    """Say which channel was rounded to decimals, or to single precision; None if none was.

    Parameters
    ----------
    trajectory : Trajectory
    solution : ReferenceSolution, optional
        Values that are exact decimals in the judging solution, too, were not rounded.
    """
    for quantity, name in FIELDS.items():
        units = (1.0, DEGREE) if quantity in ANGULAR else (1.0,)
        values = getattr(trajectory, name)
        if values is None or not values.size:
            continue
        right = None if solution is None else getattr(solution.trajectory, name)
        least = LEFT_OVER * float(np.abs(values if right is None else right).max(initial=0.0))
        columns = values.reshape(len(values), -1)
        for k, column in enumerate(columns.T):
            lattice = lattice_of(column[np.abs(column) > least], units)
            if lattice is not None and not (solution and exact(solution, quantity, k, lattice[1])):
                return f"{name} is {lattice[0]}"
    return None


def exact(solution: ReferenceSolution, quantity: str, column: int, spacing: float | None) -> bool:
    """Whether the judging solution's own values are on the lattice, to its error; no spacing for single precision."""
    values = getattr(solution.trajectory, FIELDS[quantity])
    if values is None or quantity not in solution.error:
        return False
    own = values.reshape(len(values), -1)[:, column]
    n = min(len(own), len(solution.error[quantity]))
    allowed = ERRORS * solution.error[quantity][:n] + ROUNDED * np.spacing(np.abs(own[:n]))
    nearest = own[:n].astype(np.float32) if spacing is None else np.round(own[:n] / spacing) * spacing
    return bool(np.mean(np.abs(own[:n] - nearest) <= allowed) > MOSTLY)


def lattice_of(column: Array, units: tuple[float, ...]) -> tuple[str, float | None] | None:
    """Words on the lattice that the values of one component were rounded to, and its spacing; None if they were not.

    Single precision has no spacing.
    """
    different = np.unique(column)
    if len(different) < FEWEST:
        return None
    if np.array_equal(different, different.astype(np.float32)):
        return "in single precision", None
    grain = np.spacing(np.abs(different))
    for unit in units:
        for exponent in reversed(EXPONENTS):
            spacing = unit * 10.0**exponent
            if spacing < COARSE * grain.max():
                break
            count = np.round(different / spacing)
            if np.all(np.abs(different - count * spacing) <= ROUNDED * grain) and len(np.unique(count)) >= FEWEST:
                named = "degrees" if unit == DEGREE else "its unit"
                return f"rounded to multiples of 1e{exponent:d} of {named}", spacing
    return None
