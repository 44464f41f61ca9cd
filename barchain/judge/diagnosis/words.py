"""Diagnoses in words."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from reports.tables.crossval import QUANTITY_UNITS

if TYPE_CHECKING:
    from barchain.judge.diagnosis.explanation import Explanation

QUANTITY_WORDS = {
    "com": "centre of mass",
    "com_velocity": "velocity of the centre of mass",
    "attitude": "angles",
    "rate": "rates",
    "reaction": "reactions",
    "torque": "torques",
    "impulse": "impulses",
}
NEAR = 1e-2
"""Share of the difference below which the nearest explanation is a hint"""
SINGLE = (2.0**-25, 2.0**-18)
"""Relative differences that single precision leaves: half a unit in the last place, amplified up to a hundred times"""
SINGLE_PRECISION = "Single precision inside an engine leaves differences of this size."
MOST_LISTED = 3
"""Indistinguishable explanations that a sentence lists"""


@dataclass(frozen=True)
class WrongQuantity:
    """A quantity outside its tolerance."""

    quantity: str
    difference: float
    """Largest difference from the judging solution, in the quantity's unit; that of the sample if it is alone"""
    size: float
    """Largest value of the judging solution, in the quantity's unit"""
    first: int
    """First sample outside the tolerance, from 0"""
    first_s: float
    """Its instant, s"""
    alone: bool = False
    """Whether no other sample is outside the tolerance"""

    @property
    def words(self) -> str:
        """Size of the difference, and its beginning."""
        unit = QUANTITY_UNITS[self.quantity]
        when = "the first sample" if self.first == 0 else f"t = {self.first_s:.4g} s"
        where = f"at {when} alone" if self.alone else f"from {when} on"
        return f"{self.difference:.2g} {unit} of {self.size:.2g} {unit}, {where}"


def diagnosis_words(
    wrong: tuple[WrongQuantity, ...],
    explanations: tuple[Explanation, ...],
    next_best: Explanation | None,
    parts: tuple[Explanation, ...],
    motion: str = "",
) -> str:
    """Sentences of a diagnosis."""
    if not wrong:
        return "The result is inside the tolerances."
    if explanations:
        return f"{addressed(explained_words(explanations, next_best))}."
    left = motion or ("" if next_best is None else nearest_words(wrong, next_best))
    return f"No known mistake explains the result.{left}{''.join(f' {part_words(p)}.' for p in parts)}"


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
    """Residual of the nearest explanation, and its name if it makes the difference far smaller."""
    left = f"{remainder(nearest)} of the quantity's size"
    if nearest.fit.relative_error > NEAR * relative_difference(wrong):
        return f" With the nearest one, a difference of {left} is left."
    return f" Near, but not inside the tolerances: {nearest.words} (leaves {left})."


def addressed(words: str) -> str:
    """Words about a result as a sentence to its author: "the reactions" becomes "Your reactions"."""
    return f"Your{words.removeprefix('the')}" if words.startswith("the ") else words[:1].upper() + words[1:]


def explained_words(explanations: tuple[Explanation, ...], next_best: Explanation | None) -> str:
    """Best explanation with its residual, and the indistinguishable ones."""
    best, others = explanations[0], explanations[1:]
    beside = "" if next_best is None else f"; next best {remainder(next_best)}"
    said = f"{best.words} (explained to {remainder(best)}{beside})"
    if not others:
        return said
    listed = "; or ".join(e.words for e in others[:MOST_LISTED])
    more = f"; or one of {len(others) - MOST_LISTED} more" if len(others) > MOST_LISTED else ""
    return f"{said}; on this scene indistinguishable: {listed}{more}"


def part_words(part: Explanation) -> str:
    """Explanation of some quantities alone."""
    names = " and ".join(QUANTITY_WORDS[q] for q in part.fit.ratio)
    return f"Of these, {names} alone: {part.words} (explained to {remainder(part)})"


def remainder(explanation: Explanation) -> str:
    """Largest remaining difference relative to its quantity's scale."""
    left = explanation.fit.relative_error
    return f"{left:.0e}".replace("e-0", "e-") if 0.0 < left < 0.01 else f"{left:.2g}" if math.isfinite(left) else "all"


def inconsistent_reason(
    wrong: WrongQuantity, explanations: tuple[Explanation, ...] = (), next_best: Explanation | None = None
) -> str:
    """Size and beginning of a wrong quantity's difference, and the explanation of the result if there is one.

    Parameters
    ----------
    wrong : WrongQuantity
    explanations : tuple of Explanation
        Indistinguishable explanations of the result as a whole.
    next_best : Explanation, optional
    """
    said = wrong.words
    return f"{said}; explained by: {explained_words(explanations, next_best)}" if explanations else said


def inconsistent_line(
    wrong: WrongQuantity, explanations: tuple[Explanation, ...] = (), next_best: Explanation | None = None
) -> str:
    """:func:`inconsistent_reason` as a line of its own, with the quantity's name."""
    return f"{QUANTITY_WORDS[wrong.quantity]}: {inconsistent_reason(wrong, explanations, next_best)}"
