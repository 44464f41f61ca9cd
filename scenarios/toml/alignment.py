"""Alignment of given instants with samples.

At a sample with a jump, an engine shows the values just before the jump. An instant written with ten digits may lie
just before or just after its sample by rounding. Such an instant is moved to the sample here, once for all engines.
"""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenarios.scene import Array

NEAR = 1e-9  # of the run: rounding of an instant to ten digits
ROUNDED = 4.0 * float(np.finfo(float).eps)  # of the run: a sum, and an instant of the samples' own grid


def on_sample(t_s: float, times_s: Array, *, beyond: float = 0.0) -> float:
    """Instant, or the sample next to it, bit for bit.

    Parameters
    ----------
    t_s : float
    times_s : ndarray, shape (n,)
        Samples of the run.
    beyond : float
        Share of the run up to which an instant stays beside a sample.
    """
    sample = float(times_s[np.abs(times_s - t_s).argmin()])
    end = float(times_s[-1])
    return sample if beyond * end < abs(sample - t_s) <= NEAR * end else t_s


def table_on_samples(instants_s: Iterable[float], times_s: Array) -> tuple[float, ...]:
    """Instants of a table of sizes, moved to samples next to them.

    Raises
    ------
    ValueError
        If two of them that differ are next to the same sample.
    """
    given = tuple(instants_s)
    found = tuple(on_sample(t, times_s) for t in given)
    for (a, before), (b, after) in itertools.pairwise(zip(given, found, strict=True)):
        if after <= before and a != b:
            raise ValueError(too_near(before, times_s))
    return found


def turn_on_samples(start_s: float, duration_s: float, times_s: Array) -> tuple[float, float]:
    """Start and duration of a prescribed rotation whose ends are moved to samples next to them.

    An end beside its sample by rounding alone stays. The law is smooth to the third derivative there, so that no
    quantity jumps, and the sum of start and duration is rounded anyway.

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
    """Difference that gives `end` when added to `start`, bit for bit if any double does."""
    plain = end - start
    near = (plain, math.nextafter(plain, math.inf), math.nextafter(plain, 0.0))
    return next((d for d in near if start + d == end), plain)


def too_near(t_s: float, times_s: Array) -> str:
    """Message on two instants next to one sample."""
    return (
        f"two instants at the sample at {t_s:g} s, allowed: one within {NEAR:g} of the run "
        f"({NEAR * float(times_s[-1]):.3g} s)"
    )
