"""Mistakes of reading that explain a result: each alone, in pairs, with a fitted number, in parts."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.chance import independent_digits
from barchain.judge.diagnosis.fitted import at_places, fitted
from barchain.judge.diagnosis.mistake import Explanation, Fit, Left, ranked
from barchain.judge.diagnosis.reading import VECTORS, WHOLE_TURNS, Reading
from barchain.judge.diagnosis.readings import READINGS, TIMINGS
from barchain.judge.residuals import worst
from barchain.judge.scales import scales
from barchain.metrics.quantities import FIELDS, QUANTITY_OF, arrays, completed, differences

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping

    from numpy.typing import NDArray

    from adapters.trajectory import Array, Trajectory
    from barchain.judge.diagnosis.reading import Timing
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

    Tolerance = Mapping[str, Array]

SPREAD = 3.0
"""Slack of a tolerance carried through a reading: one perturbation of random signs may meet a weak direction"""
MOST_CARRIED = 1e5
"""Largest factor by which a reading may widen tolerances; micronewtons would be 1e6"""
MOST_UNKNOWN = 2
"""Samples about which a supposed trajectory may say nothing: central differences leave both ends"""
SCREENED = 48
"""Samples at which combinations are tried first"""


@dataclass(frozen=True)
class GivenResult:
    """A trajectory to be explained and the right motion, at n common samples.

    A tolerance is infinite where a quantity is not compared, beyond the predictability limit.
    """

    scene: Scene
    given: Trajectory
    right: Trajectory
    """Judging solution"""
    tolerance: Tolerance
    """(n,) for each quantity, SI units"""
    scale: dict[str, float]
    """Size of each quantity in the scene"""
    absent: Mapping[str, NDArray[np.bool_]] = field(default_factory=dict)
    """Parts of arrays that the given trajectory lacks, of the shape of a sample; it holds the right values there"""

    @property
    def n(self) -> int:
        """Number of compared samples."""
        return len(self.right.t_s)

    @cached_property
    def quantities(self) -> frozenset[str]:
        """Compared quantities."""
        return frozenset(differences(self.given, self.right)) & frozenset(self.tolerance)

    @property
    def finite(self) -> bool:
        """Whether all compared values are numbers."""
        return all(bool(np.isfinite(v).all()) for v in arrays(self.given).values())

    def at(self, rows: NDArray[np.intp]) -> GivenResult:
        """Result at some samples."""
        tolerance = {name: values[rows] for name, values in self.tolerance.items()}
        given, right = self.given.samples(rows), self.right.samples(rows)
        return GivenResult(self.scene, given, right, tolerance, self.scale, self.absent)

    @cached_property
    def wrong(self) -> dict[str, NDArray[np.bool_]]:
        """Samples (n,) at which each quantity is outside the tolerance of the right motion."""
        apart = differences(self.given, self.right)
        return {q: np.isfinite(self.tolerance[q]) & ~(apart[q] <= self.tolerance[q]) for q in self.quantities}

    @property
    def weights(self) -> dict[str, Array]:
        """Reciprocal tolerances (n,) of the compared quantities; 0 where nothing is compared."""
        found = {}
        for q in sorted(self.quantities):
            known = np.isfinite(self.tolerance[q]) & (self.tolerance[q] > 0.0)
            found[q] = np.where(known, 1.0 / np.where(known, self.tolerance[q], 1.0), 0.0)
        return found

    def apart(self, motion: Trajectory, rows: NDArray[np.intp], weights: Mapping[str, Array]) -> Array:
        """Differences of some samples from a motion at these in weights (n,), (k, c); 0 where it is unknown."""
        given, found = completed(self.given.samples(rows), self.absent, motion), []
        for q, weight in weights.items():
            mine, theirs = getattr(given, FIELDS[q]), getattr(motion, FIELDS[q])
            if mine is not None and theirs is not None and mine.shape == theirs.shape:
                off = (mine - theirs).reshape(len(rows), -1) * weight[rows, None]
                found.append(np.nan_to_num(off, nan=0.0, posinf=0.0, neginf=0.0))
        return np.concatenate(found, axis=1) if found else np.zeros((len(rows), 0))

    def digits_of(self, quantities: frozenset[str]) -> Array:
        """Decimal digits of each independent number in the differences from the right motion, largest first."""
        weights = {q: weight for q, weight in self.weights.items() if q in quantities}
        rows = np.flatnonzero(np.any([w > 0.0 for w in weights.values()], axis=0)) if weights else np.arange(0)
        if not len(rows):
            return np.zeros(0)
        return independent_digits(self.apart(self.right.samples(rows), rows, weights))

    def perturbed(self, motion: Trajectory) -> Trajectory:
        """A motion with every value off by the tolerance of its quantity, with random signs."""
        rng = np.random.default_rng(0)
        changes: dict[str, Array | tuple[int, ...] | None] = {}
        for name, values in arrays(motion).items():
            tolerance = self.tolerance.get(QUANTITY_OF[name])
            if tolerance is not None:
                size = np.where(np.isfinite(tolerance), tolerance, 0.0)
                size = size / (math.sqrt(2.0) if name in VECTORS else 1.0)
                signs = rng.choice([-1.0, 1.0], values.shape)
                changes[name] = values + signs * size.reshape(-1, *[1] * (values.ndim - 1))
        return motion.replace(**changes)

    @cached_property
    def right_perturbed(self) -> Trajectory:
        """The right motion of :meth:`perturbed`, which every reading alone is tried on."""
        return self.perturbed(self.right)

    def read(self, reading: Reading, motion: Trajectory) -> tuple[Trajectory, Tolerance]:
        """Altered reading of a motion, and tolerances carried through the reading: at least the motion's own."""
        supposed = reading.read(self.scene, motion)
        perturbed = self.right_perturbed if motion is self.right else self.perturbed(motion)
        carried = differences(supposed, reading.read(self.scene, perturbed))
        widened = {
            name: np.fmax(values, SPREAD * carried[name]) if name in carried else values
            for name, values in self.tolerance.items()
        }
        return supposed, widened

    def fit(self, supposed: Trajectory, *, any_turns: bool = False, tolerance: Tolerance | None = None) -> Fit:
        """Residuals against a supposed trajectory.

        Parameters
        ----------
        supposed : Trajectory
            NaN where the supposition says nothing: such values are not compared. One that is silent wherever the
            result is wrong does not fit, nor does a run that ends too early.
        any_turns : bool
            Whether angles may differ by whole turns, the same at all samples.
        tolerance : mapping, optional
            (n,) for each quantity; that of the right motion by default.
        """
        allowed, n = tolerance or self.tolerance, self.n
        if any_turns:
            supposed = self.with_turns(supposed)
        apart = differences(completed(self.given, self.absent, supposed), supposed) if len(supposed.t_s) >= n else {}
        found = Fit()
        for name in sorted(self.quantities):
            inside = np.isfinite(allowed[name])
            size = apart[name][:n] if name in apart else np.full(n, math.inf)
            unknown = np.isnan(size)
            if unknown.any():
                told = np.count_nonzero(unknown) <= MOST_UNKNOWN and bool((self.wrong[name] & inside & ~unknown).any())
                size = np.where(unknown, 0.0, size) if told else np.full(n, math.inf)
            ratio, own = (max(0.0, worst(size, each[name], inside)[0]) for each in (allowed, self.tolerance))
            found[name] = Left(ratio, own, float(size[inside].max(initial=0.0)) / self.scale[name])
        return found

    def hopeless(self, supposed: Trajectory, altered: frozenset[str], *, any_turns: bool = False) -> bool:
        """Whether no tolerance carried through a reading explains the differences of the quantities that it alters.

        A quick look before :meth:`fit`. The median sample decides: a wrapped angle may jump at a single one.
        """
        supposed = self.with_turns(supposed) if any_turns else supposed
        apart = differences(completed(self.given, self.absent, supposed), supposed, altered & self.quantities)
        over = (values > MOST_CARRIED * self.tolerance[q] for q, values in apart.items())
        return any(2 * int(np.count_nonzero(each)) > len(each) for each in over)

    def with_turns(self, supposed: Trajectory) -> Trajectory:
        """Supposed trajectory with whole turns added to each bar's angle, as at the first known sample."""
        if supposed.angle_rad is None or self.given.angle_rad is None:
            return supposed
        rows = np.nonzero(~np.isnan(supposed.angle_rad).any(axis=1))[0]
        if not len(rows):
            return supposed
        apart = self.given.angle_rad[rows[0]] - supposed.angle_rad[rows[0]]
        turns = 2.0 * math.pi * np.rint(apart / (2.0 * math.pi))
        return supposed.replace(angle_rad=supposed.angle_rad + turns)


def given_result(
    trajectory: Trajectory, judging: ReferenceSolution, tolerance: Tolerance, absent: Mapping[str, NDArray[np.bool_]]
) -> GivenResult:
    """A trajectory and its judging solution at their common samples.

    Parameters
    ----------
    trajectory : Trajectory
    judging : ReferenceSolution
    tolerance : mapping
        (k,) for each quantity, SI units; infinite where the quantity is not compared.
    absent : mapping
        Parts of arrays that the trajectory lacks.
    """
    lengths = [len(values) for values in tolerance.values()]
    rows = np.arange(min([len(trajectory.t_s), len(judging.trajectory.t_s), *lengths]))
    whole = GivenResult(judging.scene, trajectory, judging.trajectory, tolerance, scales(judging), absent)
    return whole.at(rows)


def together(parts: list[tuple[frozenset[str], Fit]]) -> Fit:
    """Fit that has some quantities of each of several fits."""
    return Fit({q: left for names, fit in parts for q, left in fit.of(names).items()})


@dataclass(frozen=True)
class Tried:
    """A mistake that was tried alone: the trajectory that it makes of the right motion, and its fit."""

    mistake: Reading | Timing
    supposed: Trajectory
    fit: Fit
    few: Trajectory
    """The trajectory at the samples at which combinations are tried first"""
    altered: frozenset[str] = frozenset()
    """Quantities that a mistake of reading alters"""
    any_turns: bool = False

    @property
    def explanation(self) -> Explanation:
        """The mistake alone."""
        return Explanation((self.mistake,), self.fit)

    @property
    def of_altered(self) -> Explanation:
        """The mistake as explanation of the quantities that it alters."""
        return Explanation((self.mistake,), self.fit.of(self.altered))


def fields_of(tried: Tried) -> frozenset[str]:
    """Arrays that a mistake of reading alters."""
    assert isinstance(tried.mistake, Reading)
    return frozenset(tried.mistake.changes)


class ReadingSearch:
    """Mistakes of reading that may explain one result; each part is computed once."""

    def __init__(self, result: GivenResult, halves: Callable[[], Trajectory | None] = lambda: None) -> None:
        """Keep the arguments; nothing is tried yet. `halves` makes the right motion with samples half way between."""
        self.result, self.halves = result, halves
        self.unaltered = result.fit(result.right)
        self.few_rows = np.unique(np.linspace(0, result.n - 1, SCREENED).astype(np.intp))
        self.few = result.at(self.few_rows)

    def tried(self, mistakes: Iterable[Reading]) -> list[Tried]:
        """Mistakes of reading alone, those that change something."""
        found = []
        for mistake in mistakes:
            supposed, tolerance = self.result.read(mistake, self.result.right)
            fit = self.result.fit(supposed, any_turns=mistake.any_turns, tolerance=tolerance)
            apart = differences(self.result.right, supposed)
            altered = frozenset(name for name in self.result.quantities if name not in apart or apart[name].any())
            if mistake.any_turns and (altered or mistake.name == WHOLE_TURNS):  # of one bar, "relative" alters nothing
                altered |= {"attitude"} & self.result.quantities
            if altered:
                few = supposed.samples(self.few_rows)
                found.append(Tried(mistake, supposed, fit, few, altered, mistake.any_turns))
        return found

    @cached_property
    def readings(self) -> list[Tried]:
        """Known mistakes of reading alone, none of arrays that the file lacks where a narrower one says as much."""
        every = self.tried(READINGS)
        lacking = {t.mistake.name for t in every if any(getattr(self.result.given, f) is None for f in fields_of(t))}

        def narrower(t: Tried) -> bool:
            return any(fields_of(o) < fields_of(t) and (o.fit, o.altered) == (t.fit, t.altered) for o in every)

        return [t for t in every if t.mistake.name not in lacking or not narrower(t)]

    @cached_property
    def timings(self) -> list[Tried]:
        """Late and early samples alone."""
        halves = self.halves()
        made = [(m, m.read(self.result.right, halves)) for m in TIMINGS]
        return [Tried(m, s, self.result.fit(s), s.samples(self.few_rows)) for m, s in made if s is not None]

    @cached_property
    def alone(self) -> list[Explanation]:
        """All mistakes alone, ranked."""
        return ranked(t.explanation for t in (*self.readings, *self.timings))

    @cached_property
    def explaining(self) -> list[Explanation]:
        """Explanations by one mistake, or by one at one place, or else by two mistakes, ranked."""
        return [e for e in self.alone if e.explains(self.unaltered.own_error)] or self.at_one_place or self.pairs

    @cached_property
    def at_one_place(self) -> list[Explanation]:
        """Readings at one bar or joint alone that explain the result, ranked."""
        return self.explained_by(at_places(self.result.scene))

    @cached_property
    def fitted(self) -> list[Explanation]:
        """Readings with a fitted number that explain the result, ranked."""
        return self.explained_by(fitted(self.result.scene, self.result.given, self.result.right))

    def explained_by(self, mistakes: Iterable[Reading]) -> list[Explanation]:
        """Explanations by readings that explain the result, ranked."""
        without = self.unaltered.own_error
        return ranked(e for t in self.tried(mistakes) if (e := t.explanation).explains(without))

    @cached_property
    def pairs(self) -> list[Explanation]:
        """Pairs of mistakes that explain the result far better than either mistake alone, ranked."""
        alone, without = {e.names: e.fit.own_error for e in self.alone}, self.unaltered.own_error
        found = [*self.reading_pairs(), *self.pairs_with_timing()]
        return ranked(e for e in found if e.explains(min([without, *(alone[(name,)] for name in e.names)])))

    def reading_pairs(self) -> Iterator[Explanation]:
        """Pairs of mistakes of reading that leave no quantity outside its tolerance."""
        for a, b in itertools.combinations(self.readings, 2):
            both = a.altered & b.altered
            parts = [(a.altered - both, a.fit), (b.altered - both, b.fit)]
            parts.append((self.result.quantities - a.altered - b.altered, self.unaltered))
            if any(fit[q].ratio > 1.0 for names, fit in parts for q in names):
                continue
            if not both:
                yield Explanation((a.mistake, b.mistake), together(parts))
            else:
                yield from self.composed(a, b)
                yield from self.composed(b, a)

    def pairs_with_timing(self) -> Iterator[Explanation]:
        """Pairs of a delay with a mistake of reading."""
        for base in self.timings:
            for reading in self.readings:
                if base.fit.outside <= reading.altered:
                    yield from self.composed(base, reading)

    def composed(self, first: Tried, second: Tried) -> Iterator[Explanation]:
        """A mistake of reading on top of another mistake, if they explain the result at some samples.

        What the reading does not alter is inside its tolerance with the first mistake alone.
        """
        turns, reading = first.any_turns or second.any_turns, second.mistake
        assert isinstance(reading, Reading)
        if self.few.hopeless(reading.read(self.result.scene, first.few), second.altered, any_turns=turns):
            return
        for result, motion in ((self.few, first.few), (self.result, first.supposed)):
            supposed, tolerance = result.read(reading, motion)
            fit = result.fit(supposed, any_turns=turns, tolerance=tolerance)
            if fit.outside:
                return
        yield Explanation((first.mistake, reading), fit)

    @cached_property
    def in_parts(self) -> list[Tried]:
        """Mistakes of reading that each explain some wrong quantities and alter no others."""
        left, found = set(self.unaltered.outside), []
        for t in sorted(self.readings, key=lambda t: (-len(t.altered), t.fit.normalised_error)):
            if t.altered <= left and t.of_altered.explains(self.unaltered.of(t.altered).own_error):
                found.append(t)
                left -= t.altered
        return found

    @property
    def parts_together(self) -> Explanation | None:
        """All mistakes of :attr:`in_parts` together, if they alter all wrong quantities."""
        parts = [(t.altered, t.fit) for t in self.in_parts]
        altered = frozenset().union(*(names for names, _ in parts))
        if not parts or self.unaltered.outside != altered:
            return None
        rest = self.result.quantities - altered
        return Explanation(tuple(t.mistake for t in self.in_parts), together([*parts, (rest, self.unaltered)]))
