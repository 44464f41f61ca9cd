"""Mistakes that may explain a result, with the residuals that they leave."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

    from barchain.judge.diagnosis.fit import Fit
    from barchain.judge.diagnosis.mistake import Mistake

MIN_GAIN = 4.0
"""Least ratio of the residuals without and with a mistake: noise at the tolerance does not fall by it"""
EQUAL_FACTOR = 10.0
"""Explanations whose residuals differ by less are indistinguishable"""


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
