"""Rank test of a step in a series whose noise is heavy-tailed and depends on its past.

The test makes no assumption on the distribution of the noise. Innovations of a first-order autoregression take the
place of the values. Under the null hypothesis they are exchangeable, so that any m of n + m innovations are the largest
with probability 1/C(n + m, m), and Mann and Whitney's statistic has its exact distribution. The autocorrelation is the
machine's more than the figure's, and 30 nights of one series leave it uncertain by 0.3: it is estimated from all series
together.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import ndtr

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Array = NDArray[np.float64]


FEWEST_OLD = 10
"""Nights before a step"""
LEVEL_NIGHTS = 5
"""First nights of a series that are its level: one more place of the search, known before the values are. So a step
that comes after few nights, or a drift, is told against them once there are enough nights since"""
FEWEST_NEW = 2
"""Nights after a step"""
RECENT = 12
"""Steps at most so many nights ago share half of the error probability; all earlier ones share the other half"""
MOST_EXACT = 12
"""Largest group whose statistic has its exact distribution; two larger ones have the normal one, which is wider in the
tails"""
MOST_CORRELATION = 0.9
LEFT_OUT = 0.1
"""Share of the differences that the autocorrelation is not estimated from: the largest ones"""
FEWEST_LEFT_OUT = 2
"""Differences over two nights that one step disturbs, or over one night one outlier: at least as many are left out.
With one of two left in, a step of ten times the noise made its own series look correlated and was told later than a
small one"""
OWN_NIGHTS = 100
"""Nights from which on a series' own autocorrelation counts as much as that of all series"""
SEED = 20020812  # fixed, so that equal histories give equal answers


def autocorrelations(values: Sequence[Array]) -> list[float]:
    """Correlations of neighbours in each of some series, for innovations.

    Each is the median over all series, rounded up by its own error, and drawn towards that of its own series where this
    is larger and the series long.
    """
    own = [autocorrelation(x) for x in values]
    known = [r for r in own if r is not None]
    if not known:
        return [0.0] * len(values)
    nights = sum(len(x) for x, r in zip(values, own, strict=True) if r is not None)
    common = max(float(np.median(known)), 0.0) + 1.0 / math.sqrt(nights)
    found = []
    for x, r in zip(values, own, strict=True):
        more = 0.0 if r is None else max(r - common, 0.0) * len(x) / (len(x) + OWN_NIGHTS)
        found.append(min(common + more, MOST_CORRELATION))
    return found


def autocorrelation(x: Array) -> float | None:
    """Correlation of neighbours in a series (n,); None without noise.

    Of a first-order autoregression differences over two nights have the variance 2 s² (1 - r²), those over one night
    2 s² (1 - r): their ratio is 1 + r. Mean sizes take the place of deviations, as tails are heavy. A step disturbs one
    difference over one night and two over two nights: the largest ones are left out.
    """
    if len(x) < FEWEST_OLD:
        return None
    left_out = max(FEWEST_LEFT_OUT, math.floor(LEFT_OUT * len(x)))
    sizes = (np.sort(np.abs(x[k:] - x[:-k])) for k in (1, 2))
    one, two = (float(np.mean(size[:-left_out])) for size in sizes)
    return (two / one) ** 2 - 1.0 if one > 0.0 else None


def innovations(x: Array, correlation: float) -> Array:
    """Part of each value (n,) that the night before does not explain; of the first its own deviation."""
    before = np.concatenate([x[:1] * 0.0 + float(np.median(x)), x[:-1]])
    found: Array = x - correlation * before
    return found


def split_levels(x: Array, correlation: float = 0.0) -> Array:
    """Probabilities of steps at each place of a series (n,), corrected for the number of places.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Logarithms.
    correlation : float
        Of neighbours (:func:`autocorrelations`).

    Returns
    -------
    ndarray, shape (n,)
        Element k: a step between nights k - 1 and k; 1 where too few nights lie before or after.
    """
    n = len(x)
    found = np.ones(n)
    if n < LEVEL_NIGHTS + FEWEST_NEW:
        return found
    places = np.array([LEVEL_NIGHTS, *range(FEWEST_OLD, n - FEWEST_NEW + 1)])
    rank = ranks(innovations(x, correlation))
    new = n - places
    excess = np.cumsum(rank[::-1])[::-1][places] - new * (new + 1) / 2.0  # pairs in which the new value is larger
    recent = new <= RECENT
    shares = np.array([np.count_nonzero(~recent), np.count_nonzero(recent)])[recent.astype(int)]
    found[places] = np.minimum(1.0, 2.0 * shares * two_sided(excess, places.astype(float), new.astype(float)))
    return found


def ranks(e: Array) -> Array:
    """Ranks 1 to n of the values (n,); equal values are ordered at random, always alike."""
    order = np.lexsort((np.random.default_rng(SEED).random(len(e)), e))
    found = np.empty(len(e))
    found[order] = np.arange(1, len(e) + 1)
    return found


def two_sided(excess: Array, old: Array, new: Array) -> Array:
    """Probability of a Mann-Whitney statistic at least as far from its mean, on either side, (k,).

    Parameters
    ----------
    excess : ndarray, shape (k,)
        Number of pairs in which the new value is the larger one, 0 to old * new.
    old, new : ndarray, shape (k,)
        Sizes of the groups.
    """
    far = np.maximum(excess, old * new - excess)
    found = ndtr((0.5 + old * new / 2.0 - far) / np.sqrt(old * new * (old + new + 1.0) / 12.0))
    small, large = np.minimum(old, new), np.maximum(old, new)
    for k in np.flatnonzero(small <= MOST_EXACT):
        found[k] = upper_tail(int(small[k]), int(large[k]))[round(far[k])]
    doubled: Array = np.minimum(1.0, 2.0 * found)
    return doubled


@lru_cache(maxsize=4096)
def upper_tail(small: int, large: int) -> Array:
    """Probabilities of a statistic of at least u = 0 to small * large, exact under exchangeability."""
    top = small * large
    ways = np.zeros(top + 1)
    ways[0] = 1.0
    for k in range(1, small + 1):  # Gaussian binomial coefficient: times (1 - q^(large+k)) / (1 - q^k)
        taken = large + k
        ways[taken:] -= ways[:-taken].copy() if taken <= top else 0.0
        for first in range(k):
            ways[first::k] = np.cumsum(ways[first::k])
    found: Array = np.cumsum(ways)[::-1] / math.comb(small + large, small)  # small numbers first; ways are symmetric
    return found
