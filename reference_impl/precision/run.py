"""Runs of many chains in one arithmetic, sampled a few times."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reference_impl.precision.coordinates import (
    HIGH_PRECISION_SETS,
    ChainObservables,
    ErrorScales,
    HighPrecisionCoordinates,
    InitialChains,
)
from reference_impl.precision.steppers import AdaptiveRuns, DormandPrince, Step, advance_adaptively, extrapolated, rk4

if TYPE_CHECKING:
    from collections.abc import Iterator

    from reference_impl.precision.arithmetic import Arithmetic, Values

FIRST_STEP = 1e-3  # of the interval between samples, before step control


def initial_vector(a: Arithmetic, name: str, start: InitialChains) -> tuple[HighPrecisionCoordinates, Values]:
    """Set of coordinates, and the vector of the initial chains in it."""
    coordinates = HIGH_PRECISION_SETS[name](a, start.bars)
    return coordinates, coordinates.pack(start)


def equal_steps(
    a: Arithmetic, name: str, start: InitialChains, method: str, sample_s: Values, samples: int, steps: int
) -> Iterator[ChainObservables]:
    """Observables after each of `samples` intervals of `sample_s`, (B,), of `steps` equal steps each.

    Parameters
    ----------
    a : Arithmetic
    name : str
        Set of coordinates, one of :data:`reference_impl.precision.coordinates.HIGH_PRECISION_SETS`.
    start : InitialChains
    method : {"rk4", "dop853", "extrapolated"}
    sample_s : ndarray, shape (B,)
    samples, steps : int
    """
    coordinates, y = initial_vector(a, name, start)
    step, h = method_of(a, method), a.cast(np.asarray(sample_s)) / steps
    for _ in range(samples):
        for _ in range(steps):
            y = step(coordinates.rates, y, h)
        yield coordinates.observables(y)


def method_of(a: Arithmetic, method: str) -> Step:
    """Function of one step."""
    return DormandPrince(a) if method == "dop853" else {"rk4": rk4, "extrapolated": extrapolated}[method]


def adaptive_steps(
    a: Arithmetic, name: str, start: InitialChains, sample_s: Values, samples: int, rtol: Values
) -> Iterator[tuple[ChainObservables, AdaptiveRuns]]:
    """Observables after each interval, with DOP853's step control.

    `rtol`, (B,), is the error allowed in a step, in each row's unit. The round-off floor of a row bounds it from below.
    """
    coordinates, y = initial_vector(a, name, start)
    radius = a.sqrt(a.cast(start.com_m[0] * start.com_m[0] + start.com_m[1] * start.com_m[1]))
    rate = a.sqrt(coordinates.bars.mu_m3_s2 / radius) / radius
    fastest = np.maximum(rate, np.abs(a.cast(start.rate_rad_s)).max(axis=0))
    units = ErrorScales(radius, coordinates.bars.length_m.max(axis=0) * np.ones_like(radius), fastest)
    allowed = np.maximum(a.cast(rtol) * coordinates.error_scales(units), coordinates.roundoff_floor(units))
    count = np.zeros(y.shape[1], int)
    at = AdaptiveRuns(y, FIRST_STEP * np.asarray(sample_s), count, count > 0)
    for _ in range(samples):
        at = advance_adaptively(a, coordinates.rates, at, np.asarray(sample_s), allowed)
        yield coordinates.observables(at.y), at
