"""Rule of times and memory: steps over the nights of one machine class, with one error rate for all series together.

The probability of a step in each series is corrected for its places by
:mod:`barchain.nightly.history.changes.rank_test`. Benjamini and Hochberg's procedure over all series then bounds the
expected share of false steps among those found on one night. Without any step that share is 1 as soon as one is found,
so that a night has a false alarm with at most the probability :data:`FALSE_ALARMS`.
"""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import false_discovery_control

from barchain.nightly.history.changes.model import Change, Direction
from barchain.nightly.history.changes.rank_test import FEWEST_NEW, FEWEST_OLD, autocorrelations, split_levels
from barchain.nightly.history.changes.steps import LEAST_EFFECT, Step, ToldStep, alike, find_steps, segments
from barchain.nightly.history.changes.suspects import differing

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from barchain.nightly.history.changes.model import ToldChange
    from barchain.nightly.history.model.series_model import FigureSeries

    ToldChanges = Mapping[str, Sequence[ToldChange]]
    Array = NDArray[np.float64]

FALSE_ALARMS = 1.0 / 120.0
"""Largest probability of a false alarm in a night: one in four months, half a one in 60 nights"""
WINDOW = 200
"""Nights that are looked at: longer ago, machines and their systems differ in too much"""


def time_changes(
    series: Sequence[FigureSeries], false_alarms: float = FALSE_ALARMS, told: ToldChanges = MappingProxyType({})
) -> tuple[tuple[Change, ...], tuple[Change, ...]]:
    """Changes of times and memory.

    Parameters
    ----------
    series : sequence of FigureSeries
        All series of these kinds, over the nights of one machine class; the last night is judged.
    false_alarms : float
    told : mapping
        Changes that earlier nights told, by name of the figure.

    Returns
    -------
    tuple
        All changes, and those that the last night tells for the first time.
    """
    present = [measured(one) for one in series]
    last = max((night.started for one in series for night in one.nights), default=None)
    before = [shortened(one, last) for one in present]
    kept = [told_steps(one, told.get(one.identity.name, ())) for one in present]
    steps, earlier = all_steps(present, kept, false_alarms), all_steps(before, kept, false_alarms)
    changes, fresh = [], []
    for one, found, own, known in zip(present, steps, kept, earlier, strict=True):
        shown: list[Step | ToldStep] = [*own, *known]
        for step in found:
            change = change_of(one, step)
            changes.append(change)
            if not any(alike(step, other) for other in shown):
                fresh.append(change)
    return tuple(changes), tuple(fresh)


def measured(series: FigureSeries) -> FigureSeries:
    """Nights of a series with a number, at most the last :data:`WINDOW`."""
    kept = [k for k, figure in enumerate(series.figures) if not figure.missing][-WINDOW:]
    return replace(series, nights=tuple(series.nights[k] for k in kept), figures=tuple(series.figures[k] for k in kept))


def shortened(series: FigureSeries, last: object) -> FigureSeries:
    """Series as it stood before the last night."""
    if not series.nights or series.nights[-1].started != last:
        return series
    return replace(series, nights=series.nights[:-1], figures=series.figures[:-1])


def all_steps(
    series: Sequence[FigureSeries], told: Sequence[Sequence[ToldStep]], false_alarms: float
) -> list[tuple[Step, ...]]:
    """Steps of each series, with one threshold for all; what is held is no discovery, and does not widen it."""
    values = [logarithms(one) for one in series]
    correlations = autocorrelations(values)
    held = [held_steps(x, r, own) for x, r, own in zip(values, correlations, told, strict=True)]
    between = [
        (part, correlation)
        for x, correlation, own in zip(values, correlations, held, strict=True)
        for _, part in segments(x, [one.place for one in own])
    ]
    threshold = common_threshold([part for part, _ in between], [r for _, r in between], false_alarms)
    return [
        find_steps(x, threshold, correlation, part_changes(one), own)
        for x, correlation, one, own in zip(values, correlations, series, held, strict=True)
    ]


def held_steps(x: Array, correlation: float, told: Sequence[ToldStep]) -> list[ToldStep]:
    """Those of the told steps that still hold: one that is given up must not hide another one beside its place."""
    places = {step.place for step in find_steps(x, 0.0, correlation, told=told)}
    return [one for one in told if one.place in places]


def common_threshold(values: Sequence[Array], correlations: Sequence[float], false_alarms: float) -> float:
    """Largest probability of a step that is a discovery on this night, by Benjamini and Hochberg; 0 if there is none.

    It is the procedure's level, and not the probability of the least clear discovery: another step of the same series
    need not be as clear as the clearest one. Only series that are long enough for a step count.
    """
    tested = [
        float(split_levels(x, correlation).min())
        for x, correlation in zip(values, correlations, strict=True)
        if len(x) >= FEWEST_OLD + FEWEST_NEW
    ]
    if not tested:
        return 0.0
    adjusted = false_discovery_control(np.array(tested), method="bh")
    return false_alarms * float(np.count_nonzero(adjusted <= false_alarms)) / len(tested)


def logarithms(series: FigureSeries) -> Array:
    """Logarithms of the figures, (n,)."""
    found: Array = np.log(np.array([figure.value for figure in series.figures], float))
    return found


def part_changes(series: FigureSeries) -> set[int]:
    """Places at which a part that the figure depends on differs from the night before."""
    return {
        k
        for k in range(1, len(series.nights))
        if differing(series.nights[k - 1], series.nights[k], series.figures[k].depends)
    }


def told_steps(series: FigureSeries, told: Sequence[ToldChange]) -> list[ToldStep]:
    """Steps of a series that earlier nights told, as far as their nights are still there."""
    place = {night.name: k for k, night in enumerate(series.nights)}
    return [ToldStep(place[one.since], one.direction is Direction.WORSE) for one in told if one.since in place]


def change_of(series: FigureSeries, step: Step) -> Change:
    """Change at a step; more time, or more memory, is worse."""
    nights = len(series.figures) - step.place
    words = f"{step.factor:.3f} times the earlier level ({step.low:.3f} to {step.high:.3f})"
    chance = "told on an earlier night" if step.held else f"by chance with {step.probability:.1g}"
    return Change(
        series.identity, series.figures[step.place - 1], series.figures[-1], series.nights[step.place - 1].name,
        series.nights[step.place].name, Direction.WORSE if step.slower else Direction.BETTER,
        f"{words} in {nights} nights since; {chance}; least effect {LEAST_EFFECT:.0%}",
        step.factor, step.low, step.high,
    )  # fmt: skip
