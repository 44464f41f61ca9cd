"""Mistakes that engines make, explanations of a result by one or several, and their words."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from scenarios.channels import UNITS, WORDS

if TYPE_CHECKING:
    from collections.abc import Iterable

PAGE = "docs/explanation/engine_conventions.md"
MIN_GAIN = 4.0
"""Least ratio of the residuals without and with a mistake: noise at the tolerance does not fall by it"""
EQUAL_FACTOR = 10.0
"""Explanations whose residuals differ by less are indistinguishable"""
NEAR = 1e-2
"""Share of the difference below which the nearest explanation is a hint"""
SINGLE = (2.0**-25, 2.0**-18)
"""Relative differences that single precision leaves: half a unit in the last place, amplified up to a hundred times"""
SINGLE_PRECISION = "Single precision inside an engine leaves differences of this size."
MOST_LISTED = 4
"""Indistinguishable explanations that a sentence lists"""


@dataclass(frozen=True)
class Mistake:
    """A known mistake of an engine or its adapter."""

    name: str
    """Short name in lower case, with hyphens"""
    sentence: str
    """Subject and verb without a full stop; the first word is `the`"""
    section: str
    """Heading of the section in :data:`PAGE` that states the convention, as an anchor"""

    @property
    def anchor(self) -> str:
        """Page and section that state the right convention."""
        return f"{PAGE}#{self.section}"


class Left(NamedTuple):
    """Largest difference that is left of a quantity."""

    ratio: float
    """Over its tolerance"""
    own_ratio: float
    """Over the tolerance of the right motion, not carried through a reading"""
    relative: float
    """Over the quantity's scale"""


class Fit(dict[str, Left]):
    """Residuals of a given trajectory against a supposed one, of each quantity."""

    @property
    def normalised_error(self) -> float:
        """Largest difference over its tolerance, of all quantities."""
        return max((left.ratio for left in self.values()), default=math.inf)

    @property
    def own_error(self) -> float:
        """Largest difference over the tolerance of the right motion, of all quantities."""
        return max((left.own_ratio for left in self.values()), default=math.inf)

    @property
    def relative_error(self) -> float:
        """Largest difference over its quantity's scale, of all quantities."""
        return max((left.relative for left in self.values()), default=math.inf)

    @property
    def outside(self) -> frozenset[str]:
        """Quantities outside their tolerances."""
        return frozenset(name for name, left in self.items() if not left.ratio <= 1.0)

    def of(self, names: frozenset[str]) -> Fit:
        """Residuals of some quantities."""
        return Fit({q: self[q] for q in sorted(names)})


@dataclass(frozen=True)
class Explanation:
    """One mistake or several together, and the residuals of the result against them."""

    mistakes: tuple[Mistake, ...]
    fit: Fit

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the mistakes."""
        return tuple(m.name for m in self.mistakes)

    @property
    def words(self) -> str:
        """Sentences of the mistakes, joined, without a full stop."""
        return ", and ".join(m.sentence for m in self.mistakes)

    def explains(self, without: float) -> bool:
        """Whether the result is inside the tolerances, and its difference far below that `without` the mistakes.

        Both differences count in the tolerance of the right motion: a reading that only widens tolerances explains
        nothing.
        """
        return self.fit.normalised_error <= 1.0 and without >= MIN_GAIN * self.fit.own_error


def ranked(found: Iterable[Explanation]) -> list[Explanation]:
    """Explanations by their residuals, smallest first; of the same mistakes in several orders, the best order."""
    order = sorted(found, key=lambda e: (e.fit.normalised_error, e.fit.relative_error, len(e.mistakes), e.names))
    best: dict[frozenset[str], Explanation] = {}
    for each in order:
        best.setdefault(frozenset(each.names), each)
    return list(best.values())


def indistinguishable(explaining: list[Explanation]) -> tuple[Explanation, ...]:
    """The first of some ranked explanations, and those with equal residuals."""
    if not explaining:
        return ()
    most = EQUAL_FACTOR * explaining[0].fit.normalised_error
    return tuple(e for e in explaining if e.fit.normalised_error <= most)


@dataclass(frozen=True)
class WrongQuantity:
    """A quantity outside its tolerance."""

    quantity: str
    difference: float
    """Largest difference from the judging solution, in the quantity's unit; that of the sample if it is alone"""
    size: float
    """Largest value of the judging solution, in the quantity's unit"""
    scale: float
    """Size of the quantity in the scene, in its unit: what residuals of mistakes are relative to"""
    first: int
    """First sample outside the tolerance, from 0"""
    first_s: float
    """Its instant, s"""
    alone: bool = False
    """Whether no other sample is outside the tolerance"""

    @property
    def words(self) -> str:
        """Size of the difference, and its beginning."""
        unit = UNITS[self.quantity]
        when = "the first sample" if self.first == 0 else f"t = {self.first_s:.4g} s"
        where = f"at {when} alone" if self.alone else f"from {when} on"
        return f"{self.difference:.2g} {unit} of {self.size:.2g} {unit}, {where}"


def relative_difference(wrong: tuple[WrongQuantity, ...]) -> float:
    """Largest difference over its quantity's size."""
    return max((w.difference / w.size for w in wrong if w.size > 0.0), default=0.0)


def looks_single(relative: float) -> bool:
    """Whether a relative difference is one that single precision inside an engine leaves."""
    return SINGLE[0] <= relative <= SINGLE[1]


def single_words(relative: float) -> str:
    """Sentence on a relative difference that single precision leaves: the digits that are left."""
    return f"{-math.log10(relative):.1f} digits left. {SINGLE_PRECISION}"


def nearest_words(wrong: tuple[WrongQuantity, ...], nearest: Explanation) -> str:
    """Nearest explanation and its residual, if it makes the difference far smaller; else empty."""
    without = max((w.difference / w.scale for w in wrong if w.scale > 0.0), default=0.0)  # measured as the fit is
    if nearest.fit.relative_error > min(NEAR * without, 1.0):
        return ""
    left = f"{remainder(nearest)} of the quantity's size"
    return f" Near, but not inside the tolerances: {nearest.words} (leaves {left})."


def addressed(words: str) -> str:
    """Words about a result as a sentence to its author: "the reactions" becomes "Your reactions"."""
    return f"Your{words.removeprefix('the')}" if words.startswith("the ") else words[:1].upper() + words[1:]


def explained_words(explanations: tuple[Explanation, ...], next_best: Explanation | None) -> str:
    """Best explanation with its residual, and the indistinguishable ones."""
    best = explanations[0]
    worse = next_best is not None and next_best.fit.relative_error > best.fit.relative_error  # in the same measure
    beside = f"; next best {remainder(next_best)}" if next_best is not None and worse else ""
    said = f"{best.words} (explained to {remainder(best)}{beside})"
    others = [words for words in dict.fromkeys(e.words for e in explanations) if words != best.words]
    if not others:
        return said
    more = f"; or {len(others) - MOST_LISTED} more" if len(others) > MOST_LISTED else ""
    return f"{said}; on this scene indistinguishable: {'; or '.join(others[:MOST_LISTED])}{more}"


def part_words(part: Explanation) -> str:
    """Explanation of some quantities alone."""
    names = " and ".join(WORDS[q] for q in part.fit)
    return f"Of these, {names} alone: {part.words} (explained to {remainder(part)})"


def remainder(explanation: Explanation) -> str:
    """Largest remaining difference relative to its quantity's scale."""
    left = explanation.fit.relative_error
    return f"{left:.0e}".replace("e-0", "e-") if 0.0 < left < 0.01 else f"{left:.2g}" if math.isfinite(left) else "all"
