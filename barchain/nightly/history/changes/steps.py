"""Steps in one series of times or memory: where its level changed, and by which factor."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from barchain.nightly.history.changes.rank_test import FEWEST_NEW, FEWEST_OLD, split_levels

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from numpy.typing import NDArray

    Array = NDArray[np.float64]

LEAST_EFFECT = 0.05
"""Least relative change that is told: smaller ones come and go with the machine"""
AS_LIKELY = 1000.0
"""Places at which a part changed may be so many times less clear than the clearest one: a level hardly ever changes by
itself, and an outlier beside the step is common"""
SHIFT = 5
"""Nights by which the place of a step may move when nights are added"""
NEAR = 3
"""Nights from the most likely place within which another may be that of the step"""
CONFIDENCE_SIGMAS = 1.96
"""Of a 95 % interval"""


@dataclass(frozen=True)
class Step:
    """Step of a level."""

    place: int
    """First element of the new level"""
    factor: float
    """Median of the new level relative to that of the old one"""
    low: float
    """Ends of the factor's 95 % interval"""
    high: float
    probability: float
    """That equal levels give so clear a step anywhere in the series"""
    held: bool = False
    """Whether only an earlier night found the step clear enough"""


@dataclass(frozen=True)
class ToldStep:
    """Step that an earlier night told."""

    place: int
    """First element of the new level"""
    slower: bool
    """Whether the new level is the larger one"""


def find_steps(x: Array, threshold: float, correlation: float = 0.0, likely: Collection[int] = ()) -> tuple[Step, ...]:
    """Steps of at least :data:`LEAST_EFFECT` in a series (n,) of logarithms, in their order.

    Parameters
    ----------
    x : ndarray, shape (n,)
    threshold : float
        Largest probability of a step, corrected for the places.
    correlation : float
        Of neighbours.
    likely : collection of int
        Places at which a part changed: among places that fit about as well, one of these is taken.
    """
    places = divided(x, 0, threshold, correlation, likely)
    ends = [0, *(place for place, _ in places), len(x)]
    found = [
        step_at(x[ends[i] : ends[i + 1]], x[ends[i + 1] : ends[i + 2]], place, probability, correlation)
        for i, (place, probability) in enumerate(places)
    ]
    return tuple(step for step in found if abs(math.log(step.factor)) >= math.log1p(LEAST_EFFECT))


def with_told(x: Array, found: Sequence[Step], told: Collection[ToldStep], correlation: float) -> tuple[Step, ...]:
    """Steps of a series (n,) with those that earlier nights told, in their order.

    A step that was told keeps its place. It is held, though the last nights make it less clear, as long as the levels
    before and after it differ in its direction by half the least effect: a figure would be told and taken back in turns
    otherwise.
    """
    steps = list(found)
    for one in told:
        same = next((k for k, step in enumerate(steps) if alike(step.place, step.factor > 1.0, one)), None)
        if same is not None:
            steps[same] = replace(steps[same], place=one.place)
            continue
        first = max((step.place for step in steps if step.place < one.place), default=0)
        end = min((step.place for step in steps if step.place > one.place), default=len(x))
        if first < one.place < end and all(step.place != one.place for step in steps):
            held = step_at(x[first : one.place], x[one.place : end], one.place, math.nan, correlation)
            size = math.log(held.factor) * (1.0 if one.slower else -1.0)
            steps += [replace(held, held=True)] * (size >= math.log1p(LEAST_EFFECT) / 2.0)
    return tuple(sorted(steps, key=lambda step: step.place))


def alike(place: int, slower: bool, told: ToldStep) -> bool:
    """Whether a step of a series is one that was told: its place moves a little when nights are added."""
    return abs(place - told.place) <= SHIFT and slower is told.slower


def divided(
    x: Array, first: int, threshold: float, correlation: float, likely: Collection[int]
) -> list[tuple[int, float]]:
    """Places of steps and their probabilities: the clearest one, then those before and after."""
    if len(x) < FEWEST_OLD + FEWEST_NEW:
        return []
    probability = split_levels(x, correlation)
    best = int(np.argmin(probability))
    if probability[best] > threshold:
        return []
    place = chosen(probability, best, {k - first for k in likely})
    before = divided(x[:place], first, threshold, correlation, likely)
    after = divided(x[place:], first + place, threshold, correlation, likely)
    return [*before, (first + place, float(probability[best])), *after]


def chosen(probability: Array, best: int, likely: Collection[int]) -> int:
    """Place of a step: the most likely one at which a part changed, of those that fit about as well as the best."""
    near = range(max(best - NEAR, 0), min(best + NEAR + 1, len(probability)))
    fitting = [k for k in near if k in likely and probability[k] <= AS_LIKELY * probability[best]]
    return min(fitting, key=lambda k: (float(probability[k]), abs(k - best)), default=best)


def step_at(old: Array, new: Array, place: int, probability: float, correlation: float) -> Step:
    """Size of a step between two levels, with the interval of Hodges and Lehmann.

    Autocorrelation leaves fewer independent nights than there are: it widens the interval.
    """
    pairs = np.sort((new[:, None] - old[None, :]).ravel())
    n, m, middle = len(old), len(new), float(np.median(new) - np.median(old))
    wider = math.sqrt((1.0 + correlation) / (1.0 - correlation))
    off = int(n * m / 2.0 - CONFIDENCE_SIGMAS * wider * math.sqrt(n * m * (n + m + 1) / 12.0))
    at = max(off, 0)
    low, high = min(float(pairs[at]), middle), max(float(pairs[-1 - at]), middle)
    return Step(place, math.exp(middle), math.exp(low), math.exp(high), probability)
