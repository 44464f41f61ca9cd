"""Synthetic noise of times: heavy tails, and memory of the night before."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from barchain.nightly.figures.rank_test import autocorrelations
from barchain.nightly.figures.steps import Step, common_threshold, find_steps, is_known

Array = NDArray[np.float64]


def noise(seed: int, series: int, nights: int, sigma: float, rho: float, tails: str = "student") -> Array:
    """Logarithms of ratios, (series, nights): a first-order autoregression.

    Its innovations are of Student's distribution with three degrees of freedom, normal, or normal with outliers of ten
    times the size on a twentieth of the nights.
    """
    random = np.random.default_rng(seed)
    drawn = (
        random.standard_t(3, (series, nights)) / np.sqrt(3.0)
        if tails == "student"
        else random.normal(size=(series, nights))
    )
    if tails == "outliers":
        drawn = drawn * np.where(random.random((series, nights)) < 0.05, 10.0, 1.0)
    x = np.array(drawn)
    for t in range(1, nights):
        x[:, t] = rho * x[:, t - 1] + np.sqrt(1.0 - rho**2) * drawn[:, t]
    return sigma * x


def told(x: Array) -> list[tuple[Step, ...]]:
    """Steps of each series that the last night tells."""
    values = list(x)
    correlations = autocorrelations(values)
    threshold = common_threshold(values, correlations)
    if threshold == 0.0:
        return [() for _ in values]
    return [find_steps(v, threshold, r) for v, r in zip(values, correlations, strict=True)]


def alarms(x: Array, first: int) -> list[int]:
    """Nights on which a step is told first, one for each step, from night `first` on."""
    found: list[int] = []
    known: list[tuple[Step, ...]] = [() for _ in x]
    for night in range(first, x.shape[1] + 1):
        steps = told(x[:, :night])
        for own, before in zip(steps, known, strict=True):
            found += [night for step in own if not is_known(step, {other.place: other.slower for other in before})]
        known = steps
    return found


def nights_until_found(seed: int, size: float, sigma: float, before: int, series: int, most: int = 40) -> int | None:
    """Nights from a step in the first of many series until it is told; None if it is not in `most` nights."""
    x = noise(seed, series, before + most, sigma, 0.3)
    x[0, before:] += np.log1p(size)
    for night in range(2, most + 1):
        if told(x[:, : before + night])[0]:
            return night
    return None
