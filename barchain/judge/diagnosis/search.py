"""Search for mistakes of reading that explain a result: each alone, in pairs, with a fitted number, in parts."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.explanation import Explanation, ranked
from barchain.judge.diagnosis.fit import merged
from barchain.judge.diagnosis.readings.angles import WHOLE_TURNS
from barchain.judge.diagnosis.readings.catalogue import READINGS, TIMINGS
from barchain.judge.diagnosis.readings.fitted import fitted
from barchain.judge.diagnosis.readings.timing import delayed
from barchain.metrics.quantities import differences

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from adapters.trajectory import Trajectory
    from barchain.judge.diagnosis.fit import Fit, GivenResult
    from barchain.judge.diagnosis.mistake import Mistake, ReadingMistake

SCREENED = 48
"""Samples at which combinations are tried first"""


@dataclass(frozen=True)
class Tried:
    """A mistake that was tried alone: the trajectory that it makes of the right motion, and its fit."""

    mistake: Mistake
    supposed: Trajectory
    fit: Fit


@dataclass(frozen=True)
class TriedReading(Tried):
    """A mistake of reading that was tried alone."""

    mistake: ReadingMistake
    altered: frozenset[str]
    """Quantities that the mistake alters"""


class ReadingSearch:
    """Mistakes of reading that may explain one result; each part is computed once."""

    def __init__(self, result: GivenResult, halves: Callable[[], Trajectory | None] = lambda: None) -> None:
        """Keep the arguments; nothing is tried yet. `halves` makes the right motion with samples half way between."""
        self.result, self.halves = result, halves
        self.unaltered = result.fit(result.right)
        self.few_rows = np.unique(np.linspace(0, result.n - 1, SCREENED).astype(np.intp))
        self.few = result.at(self.few_rows)

    @cached_property
    def readings(self) -> list[TriedReading]:
        """Mistakes of reading alone, those that change something."""
        tried = (self.tried_reading(mistake) for mistake in READINGS)
        return [each for each in tried if each.altered]

    def tried_reading(self, mistake: ReadingMistake) -> TriedReading:
        """Try a mistake of reading alone."""
        supposed, tolerance = self.result.read(mistake, self.result.right)
        fit = self.result.fit(supposed, any_turns=mistake.any_turns, tolerance=tolerance)
        apart = differences(self.result.right, supposed)
        altered = frozenset(name for name in self.result.quantities if name not in apart or apart[name].any())
        if mistake.any_turns and (altered or mistake.name == WHOLE_TURNS):  # of one bar, "relative" alters nothing
            altered |= {"attitude"} & self.result.quantities
        return TriedReading(mistake, supposed, fit, altered)

    @cached_property
    def timings(self) -> list[Tried]:
        """Late and early samples alone."""
        halves = self.halves()
        made = [(m, delayed(m, self.result.right, halves)) for m in TIMINGS]
        return [Tried(m, s, self.result.fit(s)) for m, s in made if s is not None]

    @cached_property
    def alone(self) -> list[Explanation]:
        """All mistakes alone, ranked."""
        tried: list[Tried] = [*self.readings, *self.timings]
        return ranked(Explanation((t.mistake,), t.fit) for t in tried)

    @cached_property
    def explaining(self) -> list[Explanation]:
        """Explanations by one mistake, or by two where none explains the result, ranked."""
        return [e for e in self.alone if e.explains(self.unaltered.own_error)] or self.pairs

    @cached_property
    def fitted(self) -> list[Explanation]:
        """Readings with a fitted number that explain the result, ranked."""
        tried = (self.tried_reading(m) for m in fitted(self.result.scene, self.result.given, self.result.right))
        found = (Explanation((t.mistake,), t.fit) for t in tried if t.altered)
        return ranked(e for e in found if e.explains(self.unaltered.own_error))

    @cached_property
    def pairs(self) -> list[Explanation]:
        """Pairs of mistakes that explain the result far better than either mistake alone, ranked."""
        return ranked(self.needed([*self.reading_pairs(), *self.pairs_with_timing()]))

    def needed(self, pairs: Iterable[Explanation]) -> list[Explanation]:
        """Pairs that explain the result, and whose mistakes both are needed."""
        alone = {e.names: e.fit.own_error for e in self.alone}
        without = self.unaltered.own_error
        return [e for e in pairs if e.explains(min([without, *(alone[(name,)] for name in e.names)]))]

    def reading_pairs(self) -> Iterator[Explanation]:
        """Pairs of mistakes of reading that leave no quantity outside its tolerance."""
        for a, b in itertools.combinations(self.readings, 2):
            both = a.altered & b.altered
            parts = [(a.altered - both, a.fit), (b.altered - both, b.fit)]
            parts.append((self.result.quantities - a.altered - b.altered, self.unaltered))
            if any(fit.ratio[q] > 1.0 for names, fit in parts for q in names):
                continue
            if not both:
                yield Explanation((a.mistake, b.mistake), merged(parts))
            else:
                yield from self.composed(a, b.mistake, any_turns=a.mistake.any_turns)
                yield from self.composed(b, a.mistake, any_turns=b.mistake.any_turns)

    def pairs_with_timing(self) -> Iterator[Explanation]:
        """Pairs of a delay with a mistake of reading."""
        for base in self.timings:
            for reading in self.readings:
                if base.fit.outside <= reading.altered:
                    yield from self.composed(base, reading.mistake)

    def composed(self, first: Tried, second: ReadingMistake, *, any_turns: bool = False) -> Iterator[Explanation]:
        """A mistake of reading on top of another mistake, if they explain the result at some samples."""
        turns = second.any_turns or any_turns
        some = second.read(self.result.scene, first.supposed.samples(self.few_rows))
        if self.few.hopeless(some, any_turns=turns):
            return
        for result, rows in ((self.few, self.few_rows), (self.result, np.arange(self.result.n))):
            supposed, tolerance = result.read(second, first.supposed.samples(rows))
            fit = result.fit(supposed, any_turns=turns, tolerance=tolerance)
            if fit.outside:
                return
        yield Explanation((first.mistake, second), fit)

    @cached_property
    def in_parts(self) -> list[TriedReading]:
        """Mistakes of reading that each explain some wrong quantities and alter no others."""
        outside, found = self.unaltered.outside, []
        left = set(outside)
        for t in sorted(self.readings, key=lambda t: (-len(t.altered), t.fit.normalised_error)):
            if t.altered <= left and Explanation((t.mistake,), t.fit.of(t.altered)).explains(
                self.unaltered.of(t.altered).own_error
            ):
                found.append(t)
                left -= t.altered
        return found

    def merged_parts(self) -> Fit:
        """Fit of all mistakes of :attr:`in_parts` together."""
        parts = [(t.altered, t.fit) for t in self.in_parts]
        rest = self.result.quantities.difference(*(names for names, _ in parts))
        return merged([*parts, (rest, self.unaltered)])
