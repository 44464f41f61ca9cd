"""Instants that a file gives next to a sample are on it: on which side of it something jumps is nobody's intent.

An engine shows at a sample what is just before a jump there. Of an instant that was written with ten digits, and lies
just before or just after its sample by rounding, every engine would have to guess that; so it is settled here, once.
"""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenarios.scene import Array

NEAR = 1e-9  # of the run: what ten digits of an instant leave
ROUNDED = 4.0 * float(np.finfo(float).eps)  # of the run: a sum, and an instant of the samples' own grid


def on_sample(t_s: float, times_s: Array, *, beyond: float = 0.0) -> float:
    """Instant, or the sample (bit for bit) that it is next to.

    Parameters
    ----------
    t_s : float
    times_s : ndarray, shape (n,)
        Samples of the run.
    beyond : float
        Share of the run up to which it may stay beside a sample.
    """
    sample = float(times_s[np.abs(times_s - t_s).argmin()])
    end = float(times_s[-1])
    return sample if beyond * end < abs(sample - t_s) <= NEAR * end else t_s


def table_on_samples(instants_s: Iterable[float], times_s: Array) -> tuple[float, ...]:
    """Instants of a thrust's table, each on the sample that it is next to.

    Raises
    ------
    ValueError
        If two of them are next to the same sample.
    """
    found = tuple(on_sample(t, times_s) for t in instants_s)
    for before, after in itertools.pairwise(found):
        if after <= before:
            raise ValueError(too_near(before, times_s))
    return found


def turn_on_samples(start_s: float, duration_s: float, times_s: Array) -> tuple[float, float]:
    """Start and duration of a prescribed rotation whose ends are on the samples that they are next to.

    An end that is beside its sample by rounding alone stays: its law is smooth to the third derivative there, so that
    nothing seen jumps, and the sum of start and duration is rounded anyway.

    Raises
    ------
    ValueError
        If both ends are next to the same sample.
    """
    end_s = start_s + duration_s
    start, end = (on_sample(t, times_s, beyond=ROUNDED) for t in (start_s, end_s))
    if (start, end) == (start_s, end_s):
        return start_s, duration_s
    if end <= start:
        raise ValueError(too_near(start, times_s))
    return start, span(start, end)


def span(start: float, end: float) -> float:
    """Difference of two floats which added to the first gives the second, bit for bit where any does."""
    plain = end - start
    near = (plain, math.nextafter(plain, math.inf), math.nextafter(plain, 0.0))
    return next((d for d in near if start + d == end), plain)


def too_near(t_s: float, times_s: Array) -> str:
    """Two instants next to one sample, in words."""
    return (
        f"two instants at the sample at {t_s:g} s, allowed: one within {NEAR:g} of the run "
        f"({NEAR * float(times_s[-1]):.3g} s)"
    )
