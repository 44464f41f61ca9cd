"""How a drift grows with time: a power, fitted, with its interval."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from barchain.runs.timing.orders import slope

if TYPE_CHECKING:
    from adapters.trajectory import Array

DECADES = 1.0  # of time, up to the end: earlier, a drift is what one revolution leaves, and hides how it grows
POINTS = 24  # evenly spaced in log t: a running maximum says nothing new from one sample to the next
FEWEST = 5


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
