"""Steps in times and memory: in one series, and with one error rate for all series of a night."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import false_discovery_control

from barchain.nightly.figures.changes import Change, Direction
from barchain.nightly.figures.figure import names_since
from barchain.nightly.figures.rank_test import (
    FEWEST_NEW,
    FEWEST_OLD,
    LEVEL_NIGHTS,
    autocorrelations,
    ranks,
    split_levels,
    two_sided,
)
from barchain.nightly.figures.suspects import differing

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from numpy.typing import NDArray

    from barchain.nightly.figures.table import NumberSeries

    Array = NDArray[np.float64]
    Told = Mapping[int, bool]
    ToldChanges = Mapping[str, Sequence[tuple[str, bool]]]


LEAST_EFFECT = 0.05
"""Least relative change that is told: smaller ones come and go with the machine"""
AS_LIKELY = 1000.0
"""Places at which a part changed may be so many times less clear than the clearest one: a level hardly ever changes by
itself, and an outlier beside the step is common"""
SHIFT = 5
"""Nights by which the place of a step may move when nights are added"""
MOST_LIKELY = 0.5
"""Probability by chance above which a place is no step, however near a change of a part"""
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
    """That equal levels give so clear a step anywhere in the series; NaN of a held one"""

    @property
    def held(self) -> bool:
        """Whether an earlier night told the step; its probability is not computed again then."""
        return math.isnan(self.probability)

    @property
    def slower(self) -> bool:
        """Whether the new level is the larger one."""
        return self.factor > 1.0


def find_steps(
    x: Array, threshold: float, correlation: float = 0.0, likely: Collection[int] = (),
    told: Told = MappingProxyType({}),
) -> tuple[Step, ...]:  # fmt: skip
    """Steps of at least :data:`LEAST_EFFECT` in a series (n,) of logarithms, in their order.

    Steps that earlier nights told divide the series first. Each is held at its place, though the last nights make it
    less clear, as long as the levels before and after it differ in its direction by half the least effect: it would be
    told and taken back in turns otherwise.

    Parameters
    ----------
    x : ndarray, shape (n,)
    threshold : float
        Largest probability of a step, corrected for the places.
    correlation : float
        Of neighbours.
    likely : collection of int
        Places at which a part changed: among places that fit about as well, one of these is taken.
    told : mapping
        Places of the steps that earlier nights told, and whether the new level is the larger one.
    """
    held = {place: slower for place, slower in told.items() if 0 < place < len(x)}
    probability = found_between(x, held, threshold, correlation, likely)
    while True:
        steps = sized(x, {**dict.fromkeys(held, math.nan), **probability}, correlation)
        sizes = {step.place: size(step, held) for step in steps}
        weak = {k: own for k, own in sizes.items() if own < math.log1p(LEAST_EFFECT) * (0.5 if k in held else 1.0)}
        if not weak:
            return tuple(steps)
        weakest = min(weak, key=lambda place: weak[place])
        if weakest in held:  # what lies around it is searched again without it
            del held[weakest]
            probability = found_between(x, held, threshold, correlation, likely)
        else:
            del probability[weakest]


def found_between(
    x: Array, held: Collection[int], threshold: float, correlation: float, likely: Collection[int]
) -> dict[int, float]:
    """Probabilities of new steps by their places, between those that are held."""
    parts = segments(x, held)
    return dict(step for first, part in parts for step in divided(part, first, threshold, correlation, likely))


def segments(x: Array, places: Collection[int]) -> list[tuple[int, Array]]:
    """Parts of a series between some places, each with the place of its first element."""
    ends = [0, *sorted(places), len(x)]
    return [(first, x[first:last]) for first, last in pairwise(ends)]


def sized(x: Array, probability: Mapping[int, float], correlation: float) -> list[Step]:
    """Steps at some places, each between the levels up to its neighbours."""
    places = sorted(probability)
    parts = [part for _, part in segments(x, places)]
    return [step_at(parts[k], parts[k + 1], place, probability[place], correlation) for k, place in enumerate(places)]


def size(step: Step, held: Told) -> float:
    """Size of a step in logarithms: of a held one in its direction.

    A new one that is a held one found again beside its place is smaller than all others.
    """
    log = math.log(step.factor)
    if step.place in held:
        return log if held[step.place] else -log
    return -math.inf if is_known(step, held) else abs(log)


def is_known(step: Step, known: Told) -> bool:
    """Whether a step is one of the known ones: its place moves a little when nights are added."""
    return any(abs(step.place - place) <= SHIFT and step.slower is slower for place, slower in known.items())


def divided(
    x: Array, first: int, threshold: float, correlation: float, likely: Collection[int]
) -> list[tuple[int, float]]:
    """Places of steps and their probabilities: the clearest one, then those before and after."""
    if threshold == 0.0 or len(x) < LEVEL_NIGHTS + FEWEST_NEW:
        return []
    probability = split_levels(x, correlation)
    best = int(np.argmin(probability))
    if probability[best] > threshold:
        return []
    place = chosen(x, probability, best, {k - first for k in likely})
    before = divided(x[:place], first, threshold, correlation, likely)
    after = divided(x[place:], first + place, threshold, correlation, likely)
    return [*before, (first + place, float(probability[best])), *after]


def chosen(x: Array, probability: Array, best: int, likely: Collection[int]) -> int:
    """Place of a step: the most likely one at which a part changed, of those that fit about as well as the best.

    A place with too few nights before it for a probability fits where the nights from it on are at the new level.
    """
    near = range(max(best - NEAR, 1), min(best + NEAR + 1, len(probability)))
    most = min(AS_LIKELY * float(probability[best]), MOST_LIKELY)
    fitting = [k for k in near if k in likely and (probability[k] <= most or is_new(x, k, best))]
    return min(fitting, key=lambda k: (float(probability[k]), abs(k - best)), default=best)


def is_new(x: Array, place: int, best: int) -> bool:
    """Whether the nights from an early place up to that of a step are nearer to its new level than to the old one."""
    if not place < min(best, FEWEST_OLD):
        return False
    old, new = np.median(x[:place]), np.median(x[best:])
    return bool(np.all(np.abs(x[place:best] - new) < np.abs(x[place:best] - old)))


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


def step_between(old: Array, new: Array) -> Step:
    """Step from one group of independent values (n,) to another one (m,), in logarithms: its place needs no search."""
    n, m = len(old), len(new)
    excess = ranks(np.concatenate([old, new]))[n:].sum() - m * (m + 1) / 2.0
    probability = two_sided(np.array([excess]), np.array([float(n)]), np.array([float(m)]))
    return step_at(old, new, n, float(probability[0]), 0.0)


FALSE_ALARMS = 1.0 / 120.0
"""Largest probability of a false alarm in a night: one in four months, half a one in 60 nights"""


def discoveries(steps: Sequence[Step]) -> list[Step]:
    """Steps between groups that are told: of at least the least effect, with one error rate for all of them."""
    if not steps:
        return []
    adjusted = false_discovery_control(np.array([step.probability for step in steps]), method="bh")
    least = math.log1p(LEAST_EFFECT)
    told = zip(steps, adjusted, strict=True)
    return [step for step, chance in told if chance <= FALSE_ALARMS and abs(math.log(step.factor)) >= least]


WINDOW = 200
"""Nights that are looked at: longer ago, machines and their systems differ in too much"""


def time_changes(
    series: Sequence[NumberSeries], told: ToldChanges = MappingProxyType({})
) -> tuple[tuple[Change, ...], tuple[Change, ...]]:
    """Changes of times and memory.

    Parameters
    ----------
    series : sequence of NumberSeries
        All series of these kinds, over the nights of one machine class; the last night is judged.
    told : mapping
        First nights of the steps that earlier nights told, and whether they are slower, by name of the figure.

    Returns
    -------
    tuple
        All changes, and those that the last night tells for the first time.
    """
    present = [one.within(-WINDOW, None) for one in series]
    last = max((one.at[-1] for one in present if len(one.at)), default=0)
    before = [one.within(None, -1) if len(one.at) and one.at[-1] == last else one for one in present]
    kept = []
    for one in present:
        place = {night.name: k for k, night in enumerate(one.nights)}  # as far as the nights are still there
        names = *one.earlier, (one.identity, "~")  # after all nights
        own = dict.fromkeys(each for name, until in names for each in told.get(name.name, ()) if each[0] <= until)
        kept.append({place[since]: slower for since, slower in own if since in place})
    steps, earlier = all_steps(present, kept), all_steps(before, kept)
    changes, fresh = [], []
    for one, found, held, known in zip(present, steps, kept, earlier, strict=True):
        shown = held | {step.place: step.slower for step in known}
        for step in found:
            change = change_of(one, step)
            changes.append(change)
            if not is_known(step, shown):
                fresh.append(change)
    return tuple(changes), tuple(fresh)


SO_FAR = 0.2
"""Least relative change that is worth a word before there are enough nights for a step"""


def so_far(series: Sequence[NumberSeries]) -> str:
    """What moved most among times and memory that have too few nights for a step; empty if nothing did."""
    found: list[tuple[float, str, int]] = []
    for one in series:
        x = np.log(one.values)
        if FEWEST_NEW < len(x) < FEWEST_OLD + FEWEST_NEW:
            moved = float(np.median(x[-FEWEST_NEW:]) - np.median(x[:-FEWEST_NEW]))
            found.append((moved, one.identity.name, len(x)))
    moved, name, nights = max(found, key=lambda each: abs(each[0]), default=(0.0, "", 0))
    if abs(moved) < math.log1p(SO_FAR):
        return ""
    needed = f"{nights} of the {FEWEST_OLD + FEWEST_NEW} nights that a step needs"
    return f"{name}: ×{math.exp(moved):.3g} so far, {needed}"


def all_steps(series: Sequence[NumberSeries], told: Sequence[Told]) -> list[tuple[Step, ...]]:
    """Steps of each series, with one threshold for all; what is held is no discovery, and does not widen it."""
    values = [np.log(one.values) for one in series]
    correlations = autocorrelations(values)
    held = [held_steps(x, r, own) for x, r, own in zip(values, correlations, told, strict=True)]
    between = [
        (part, correlation)
        for x, correlation, own in zip(values, correlations, held, strict=True)
        for _, part in segments(x, own)
    ]
    threshold = common_threshold([part for part, _ in between], [r for _, r in between])
    return [
        find_steps(x, threshold, correlation, part_changes(one) if threshold else (), own)
        for x, correlation, one, own in zip(values, correlations, series, held, strict=True)
    ]


def held_steps(x: Array, correlation: float, told: Told) -> Told:
    """Those of the told steps that still hold: one that is given up must not hide another one beside its place."""
    places = {step.place for step in find_steps(x, 0.0, correlation, told=told)}
    return {place: slower for place, slower in told.items() if place in places}


def common_threshold(values: Sequence[Array], correlations: Sequence[float]) -> float:
    """Largest probability of a step that is a discovery on this night, by Benjamini and Hochberg; 0 if there is none.

    It is the procedure's level, and not the probability of the least clear discovery: another step of the same series
    need not be as clear as the clearest one. Only series that are long enough for a step count.
    """
    tested = [
        float(split_levels(x, correlation).min())
        for x, correlation in zip(values, correlations, strict=True)
        if len(x) >= LEVEL_NIGHTS + FEWEST_NEW
    ]
    if not tested:
        return 0.0
    adjusted = false_discovery_control(np.array(tested), method="bh")
    return FALSE_ALARMS * float(np.count_nonzero(adjusted <= FALSE_ALARMS)) / len(tested)


def part_changes(series: NumberSeries) -> set[int]:
    """Places at which a part that the figure depends on differs from the night before."""
    pairs = enumerate(pairwise(series.nights), 1)
    return {k for k, (last, since) in pairs if differing(last, since, series.depends(k))}


def change_of(series: NumberSeries, step: Step) -> Change:
    """Change at a step; more time, or more memory, is worse."""
    nights = len(series.at) - step.place
    words = f"{step.factor:.3f} times the earlier level ({step.low:.3f} to {step.high:.3f})"
    chance = "told on an earlier night" if step.held else f"by chance with {step.probability:.1g}"
    last, since = (night.name for night in series.nights[step.place - 1 : step.place + 1])
    names = [names_since(night, series.identity, series.earlier) for night in (last, since)]
    settings = tuple(own[0].setting for own in names)
    return Change(
        series.identity, series.figure(step.place - 1), series.figure(-1), last, since,
        Direction.WORSE if step.slower else Direction.BETTER,
        f"{words} in {nights} nights since; {chance}; least effect {LEAST_EFFECT:.0%}",
        step.factor, step.low, step.high, named=names[1], settings=settings if settings[0] != settings[1] else (),
    )  # fmt: skip
