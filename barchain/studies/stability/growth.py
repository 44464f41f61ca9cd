"""How drifts and errors grow: a power of time, fitted, or faster than the scene's own error amplification."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.scales import NORM_SLACK
from barchain.metrics.quantities import differences
from barchain.solutions.reference import PERTURBATION_RAD
from barchain.studies.timing.orders import slope
from reports.tables.crossval import PARTED_RAD

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from adapters.trajectory import Array, Trajectory
    from barchain.solutions.reference import ReferenceSolution

DECADES = 1.0  # of time, up to the end: earlier, a drift is what one revolution leaves, and hides how it grows
POINTS = 24  # evenly spaced in log t: a running maximum says nothing new from one sample to the next
CLEAR = 10.0  # times the first size, or the reference solution's own error, from which an error counts as grown
FEWEST = 5  # samples of a fit
UNSTABLE = "unstable"  # tag of scenes on an unstable equilibrium


@dataclass(frozen=True)
class GrowthLaw:
    """``drift = at_end (t/T)^exponent`` over the last decade of a run that ends at T."""

    exponent: float
    low: float
    high: float
    """Student's interval at 95 % of the exponent; of one realisation, so that another random walk may lie outside"""
    at_end: float

    @property
    def words(self) -> str:
        """``as t^0.98 (0.95 to 1.01), 3.2e-09 at the end``."""
        return f"as t^{self.exponent:.2f} ({self.low:.2f} to {self.high:.2f}), {self.at_end:.2g} at the end"


def law(t_s: Array, drift: Array) -> GrowthLaw | None:
    """Law of a drift, fitted to its running maximum by least squares in both logarithms.

    Parameters
    ----------
    t_s, drift : ndarray, shape (n,)

    Returns
    -------
    Law or None
        None where the drift is zero or seen too few times.
    """
    finite = np.isfinite(drift)
    t, largest = t_s[finite], np.maximum.accumulate(np.abs(drift[finite]))
    if len(t) < FEWEST:
        return None
    wanted = np.geomspace(t[-1] * 10.0**-DECADES, t[-1], POINTS)
    at = np.unique(np.searchsorted(t, wanted * (1.0 - 1e-12)))
    at = at[(t[at] > 0.0) & (largest[at] > 0.0)]
    if len(at) < FEWEST:
        return None
    found = slope(np.log(t[at]), np.log(largest[at]))
    return GrowthLaw(found.value, found.low, found.high, float(largest[-1]))


def attitude_error(trajectory: Trajectory, solution: ReferenceSolution) -> tuple[Array, Array] | None:
    """Instants up to the predictability limit, s, and attitude errors there, rad, each (n,); None without attitude."""
    apart = differences(trajectory, solution.trajectory).get("attitude")
    if apart is None:
        return None
    t = solution.trajectory.t_s[: len(apart)]
    inside = t <= solution.limit_s
    return t[inside], apart[inside]


def exponential_rate(t_s: Array, size: Array, inside: NDArray[np.bool_]) -> tuple[float, float] | None:
    """Rate of exponential growth, 1/s, and its lower end, over the samples inside; None of too few."""
    if np.count_nonzero(inside) < FEWEST:
        return None
    found = slope(t_s[inside], np.log(size[inside]))
    return found.value, found.low


def linear_rate(solution: ReferenceSolution) -> tuple[float, float] | None:
    """Rate of the scene's error amplification, 1/s: that of the perturbed run while it is linear."""
    amplification = solution.amplification
    inside = (amplification > CLEAR) & (amplification < PARTED_RAD / PERTURBATION_RAD)
    return exponential_rate(solution.trajectory.t_s[: len(amplification)], amplification, inside)


def own_motion(solution: ReferenceSolution) -> Array:
    """Largest departure of the reference solution from its initial attitude so far, (n,) rad, to its own horizontal."""
    trajectory = solution.trajectory
    assert trajectory.angle_rad is not None
    longitude = np.unwrap(np.arctan2(trajectory.com_m[:, 1], trajectory.com_m[:, 0]))
    stood = trajectory.angle_rad - longitude[:, None]
    largest: Array = np.maximum.accumulate(np.abs(stood - stood[0]).max(axis=1))
    return largest


def growth_excess(trajectory: Trajectory, solution: ReferenceSolution) -> float | None:
    """Growth of an error over the scene's linear error amplification; None where no growth is resolved.

    Asked of scenes on an unstable equilibrium (tag `unstable`): elsewhere nothing grows exponentially from the start.

    Both rates are fitted, and that of the departure is taken at the lower end of its interval. Errors that are added
    on the way make a departure grow faster than the linear rate at first only: from ten times its first size on by
    less than a tenth more in all. The fit covers instants at which the departure exceeds the reference solution's own
    motion. Where the reference solution moves more, a method errs in proportion to a motion that itself grows, which
    feeds the departure and is no instability.
    """
    if UNSTABLE not in solution.scene.tags:
        return None
    error, own = attitude_error(trajectory, solution), linear_rate(solution)
    if error is None or own is None:
        return None
    t, apart = error
    size = np.maximum.accumulate(apart)
    nonzero = size[size > 0.0]
    if not len(nonzero):
        return None
    clear = CLEAR * np.maximum(nonzero[0], solution.error["attitude"][: len(size)])
    inside = (size > np.maximum(clear, own_motion(solution)[: len(size)])) & (size < PARTED_RAD)
    found = exponential_rate(t, size, inside)
    if found is None:
        return None
    return float(np.exp((found[1] - own[0]) * np.ptp(t[inside])))


def grows_too_fast(excess: float | None) -> bool:
    """Whether an error grew by more than the scene's amplification and the slack of every bound."""
    return excess is not None and excess > NORM_SLACK
