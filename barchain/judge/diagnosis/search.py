"""Search for mistakes that explain a result: each alone, then pairs, then several in different quantities."""

from __future__ import annotations

import dataclasses
import itertools
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.altered_scenes.amount_fit import fitted_amount
from barchain.judge.diagnosis.altered_scenes.amounts import amounts
from barchain.judge.diagnosis.altered_scenes.catalogue import SCENES
from barchain.judge.diagnosis.altered_scenes.equation_amounts import equation_amounts
from barchain.judge.diagnosis.altered_scenes.runs import ALTERED, AlteredRuns, run_errors
from barchain.judge.diagnosis.explanation import MIN_GAIN, Explanation, ranked
from barchain.judge.diagnosis.fit import QUANTITY_OF, merged
from barchain.judge.diagnosis.mistake import ReadingMistake, SceneMistake
from barchain.judge.diagnosis.readings.angles import WHOLE_TURNS
from barchain.judge.diagnosis.readings.catalogue import READINGS, TIMINGS
from barchain.judge.diagnosis.readings.fitted import fitted
from barchain.judge.diagnosis.readings.timing import delayed
from barchain.metrics.quantities import differences

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from adapters.trajectory import Array, Trajectory
    from barchain.judge.diagnosis.altered_scenes.amounts import Amount
    from barchain.judge.diagnosis.fit import Fit, GivenResult
    from barchain.judge.diagnosis.mistake import Mistake
    from barchain.solutions.reference import ReferenceSolution

SCREENED = 48
"""Samples at which combinations are tried first"""
EARLY = 4
"""Samples at the start at which pairs of altered scenes are tried first"""
AMOUNT_RUNS = 4
"""Expected runs for the fit of one amount"""
BEGINNING = 11
"""Samples at the start by which amounts in the equations are chosen"""
AMOUNT_GAIN = 1e3
"""Least ratio of the residuals without and with a fitted amount: a coarse run resembles some amount, too"""
MOVING = frozenset({"com", "com_velocity", "attitude", "rate"})
"""Quantities that an amount in the scene alters"""
MOST_WHOLE = 40
"""Pairs of altered scenes that are run to the end, best first"""


@dataclass(frozen=True)
class Effort:
    """Extent of a search."""

    scene_run_s: float
    """Longest expected time of one run of an altered scene, s; 0: no runs"""
    equation_run_s: float
    """Longest expected time of one run with altered equations, of which there are few, s; 0: no runs"""
    scene_pairs: bool
    """Whether pairs of mistakes in the scene are tried"""
    amounts_s: float
    """Longest expected time of all fits of unknown amounts in the scene, s; 0: no fits"""


FULL = Effort(scene_run_s=10.0, equation_run_s=20.0, scene_pairs=True, amounts_s=60.0)
"""Every mistake and every pair"""
ONE_ENGINE = Effort(scene_run_s=1.0, equation_run_s=5.0, scene_pairs=False, amounts_s=10.0)
"""For the examination of one engine: runs of NumPy's reference are affordable where nothing is compiled"""
BRIEF = Effort(scene_run_s=0.05, equation_run_s=1.0, scene_pairs=False, amounts_s=0.0)
"""For many results: mistakes in the scene only where their runs are short, and no pairs of them"""


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

    @property
    def alters(self) -> bool:
        """Whether the mistake alters anything in this scene."""
        return bool(self.altered)


class MistakeSearch:
    """Mistakes that may explain one result; each part is computed once."""

    def __init__(self, result: GivenResult, judging: ReferenceSolution, effort: Effort) -> None:
        """Keep the arguments; nothing is tried yet."""
        self.result, self.judging, self.effort = result, judging, effort
        self.unaltered = result.fit(result.right)
        self.few_rows = np.unique(np.linspace(0, result.n - 1, SCREENED).astype(np.intp))
        self.few = result.at(self.few_rows)
        self.runs = AlteredRuns(judging.scene, effort.scene_run_s, effort.equation_run_s)

    @cached_property
    def readings(self) -> list[TriedReading]:
        """Mistakes of reading alone, those that change something."""
        tried = (self.tried_reading(mistake) for mistake in READINGS)
        return [each for each in tried if each.alters]

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
        made = [(m, delayed(m, self.judging.trajectory, self.runs.halves)) for m in TIMINGS]
        return [Tried(m, s, self.result.fit(s)) for m, s in made if s is not None]

    @cached_property
    def scenes(self) -> list[Tried]:
        """Mistakes in the scene alone, those whose runs are short enough and show another motion."""
        made = [(m, self.runs.run(m)) for m in SCENES]
        return [Tried(m, s, self.result_of_run.fit(s)) for m, s in made if s is not None and self.is_another(s)]

    def is_another(self, motion: Trajectory, *, any_turns: bool = False) -> bool:
        """Whether a supposed motion is another than the right one, by far more than the error of a run.

        A single bar in point gravity moves alike with any moment of inertia, but for rounding; and two mistakes may
        cancel.
        """
        n, right = len(motion.t_s), self.judging.trajectory
        if n < self.result.n:
            return True
        if any_turns:
            motion, right = self.result.with_turns(motion), self.result.with_turns(right)
        apart = differences(motion, right.samples(slice(n)))
        for q in self.result.quantities & set(apart):
            error = self.run_errors[q][:n] if q in self.run_errors else 0.0
            if np.any(apart[q] > MIN_GAIN * (error + ALTERED.value * self.result.scale[q])):
                return True
        return False

    @cached_property
    def run_errors(self) -> dict[str, Array]:
        """Error of a run of an altered scene, (n,) for each quantity, SI units."""
        return run_errors(self.judging)

    @cached_property
    def result_of_run(self) -> GivenResult:
        """The result with tolerances that allow for the error of a run of an altered scene.

        What a mistake gains is counted in tolerances of the right motion: wider ones would be a gain by themselves.
        """
        errors, n = self.run_errors, self.result.n
        tolerance = {q: v + errors[q][:n] if q in errors else v for q, v in self.result.tolerance.items()}
        return dataclasses.replace(self.result, tolerance=tolerance, right_tolerance=self.result.tolerance)

    @cached_property
    def alone(self) -> list[Explanation]:
        """All mistakes alone, ranked."""
        tried: list[Tried] = [*self.readings, *self.timings, *self.scenes]
        return ranked(Explanation((t.mistake,), t.fit) for t in tried)

    @cached_property
    def fitted(self) -> list[Explanation]:
        """Readings with a fitted number that explain the result, ranked."""
        tried = (self.tried_reading(m) for m in fitted(self.judging.scene, self.result.given, self.result.right))
        found = (Explanation((t.mistake,), t.fit) for t in tried if t.alters)
        return ranked(e for e in found if e.explains(self.unaltered.own_error))

    @cached_property
    def pairs(self) -> list[Explanation]:
        """Pairs of mistakes that explain the result far better than either mistake alone, ranked."""
        readings = [*self.reading_pairs(), *self.pairs_with_reading([*self.timings, *self.scenes])]
        found = self.needed([*readings, *self.pairs_with_timing()])
        if self.effort.scene_pairs and not found:
            found = self.needed(self.scene_pairs())
        return ranked(found)

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
                yield from self.composed(a, b.mistake)
                yield from self.composed(b, a.mistake)

    def pairs_with_reading(self, bases: list[Tried]) -> Iterator[Explanation]:
        """Pairs of a delay or an altered scene with a mistake of reading."""
        for base in bases:
            for reading in self.readings:
                if base.fit.outside <= reading.altered:
                    yield from self.composed(base, reading.mistake)

    def pairs_with_timing(self) -> Iterator[Explanation]:
        """Pairs of an altered scene with samples that are a whole number of samples late or early."""
        whole = [t for t in TIMINGS if t.late_samples == round(t.late_samples)]
        for base in self.scenes:
            for timing in whole:
                if base.fit.outside <= {QUANTITY_OF[f] for f in timing.fields}:
                    supposed = delayed(timing, base.supposed, None)
                    if supposed is not None and len(supposed.t_s) == self.result.n:
                        yield Explanation((base.mistake, timing), self.result_of_run.fit(supposed))

    def composed(self, first: Tried, second: ReadingMistake) -> Iterator[Explanation]:
        """A mistake of reading on top of another mistake, if they explain the result at some samples."""
        whole = self.result_of_run if isinstance(first.mistake, SceneMistake) else self.result
        if len(first.supposed.t_s) < whole.n:
            return
        turns = second.any_turns or (isinstance(first.mistake, ReadingMistake) and first.mistake.any_turns)
        some = second.read(self.judging.scene, first.supposed.samples(self.few_rows))
        if self.few.hopeless(some, any_turns=turns):
            return
        for result, rows in ((whole.at(self.few_rows), self.few_rows), (whole, np.arange(whole.n))):
            supposed, tolerance = result.read(second, first.supposed.samples(rows))
            fit = result.fit(supposed, any_turns=turns, tolerance=tolerance)
            if fit.outside:
                return
        if not isinstance(first.mistake, SceneMistake) or self.is_another(supposed, any_turns=turns):
            yield Explanation((first.mistake, second), fit)

    def scene_pairs(self) -> Iterator[Explanation]:
        """Pairs of altered scenes that explain the first samples, and then the whole run."""
        early = []
        scenes = [t.mistake for t in self.scenes if isinstance(t.mistake, SceneMistake) and t.mistake.model is None]
        for a, b in itertools.combinations(scenes, 2):
            supposed = self.runs.run(composed_scenes(a, b), EARLY)
            fit = None if supposed is None else self.result_of_run.fit(supposed, samples=EARLY)
            if fit is not None and not fit.outside:
                early.append(Explanation((a, b), fit))
        for pair in ranked(early)[:MOST_WHOLE]:
            whole = self.runs.run(composed_scenes(*(m for m in pair.mistakes if isinstance(m, SceneMistake))))
            if whole is not None and self.is_another(whole):
                yield Explanation(pair.mistakes, self.result_of_run.fit(whole))

    @cached_property
    def amounts(self) -> list[Explanation]:
        """Numbers of the scene that are wrong by a fitted amount and explain the result, ranked.

        Numbers in the equations are fitted if no number of the scene explains the result.
        """
        if not self.unaltered.outside & MOVING:
            return []
        scene = self.judging.scene
        found = self.fitted_amounts(amounts(scene), equations=False)
        return found or self.fitted_amounts(self.possible(equation_amounts(scene)), equations=True)

    def possible(self, every: tuple[Amount, ...]) -> tuple[Amount, ...]:
        """Amounts that explain the first samples, or all if these are right: their runs take long."""
        n = min(self.result.n, BEGINNING)
        if not self.result.fit(self.result.right, samples=n).outside:
            return every
        early = {amount: self.fitted_amount(amount, n) for amount in every}
        return tuple(a for a, e in early.items() if e is not None and not e.fit.outside)

    def fitted_amounts(self, every: tuple[Amount, ...], *, equations: bool) -> list[Explanation]:
        """Explanations by one of several amounts, ranked; none if the fits would take too long."""
        if not self.runs.affordable_in(self.effort.amounts_s, AMOUNT_RUNS * len(every), equations=equations):
            return []
        found = [e for amount in every if (e := self.fitted_amount(amount, self.result.n)) is not None]
        return ranked(e for e in found if e.explains(self.unaltered.own_error * MIN_GAIN / AMOUNT_GAIN))

    def fitted_amount(self, amount: Amount, n: int) -> Explanation | None:
        """An amount fitted to the first n samples, and the fit; None without a run."""
        result = self.result_of_run if n == self.result.n else self.result_of_run.at(np.arange(n))
        mistake = amount.mistake(fitted_amount(amount, result, lambda m: self.runs.run(m, n)))
        supposed = self.runs.run(mistake, n)
        if supposed is None or len(supposed.t_s) < n:
            return None
        return Explanation((mistake,), result.fit(supposed))

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


def composed_scenes(first: SceneMistake, second: SceneMistake) -> SceneMistake:
    """Two altered scenes at once."""
    assert first.scene is not None
    assert second.scene is not None
    one, other = first.scene, second.scene
    return SceneMistake("pair", "the pair", "", lambda scene: other(one(scene)))
