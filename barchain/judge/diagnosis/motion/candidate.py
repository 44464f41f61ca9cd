"""Candidates for what is wrong in equations of motion, and a list that collects them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.motion.words import BODIES, factor_words, nice_factor

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.trajectory import Array
    from barchain.judge.diagnosis.motion.balance import Balance
    from barchain.judge.diagnosis.motion.numbers import Number
    from barchain.judge.equations import Load
    from scenarios import Scene

    Rows = Callable[[], Array]

SMALL = 0.02
"""Largest relative amount of a mass or length whose effect is linear enough for a pair"""


@dataclass(frozen=True)
class Candidate:
    """A change of the right equations: fixed, linear in its amounts, or of a number whose effect is not linear."""

    name: str
    section: str
    """Anchor of the convention"""
    make: Rows
    """Rows (n - 1, c) or (n - 1, c, m) that the change adds to the balance for a unit of each amount"""
    words: Callable[[Array], str]
    """Sentence of the amounts (m,), without a full stop; begins with `the`"""
    fixed: bool = False
    """Whether the amount is 1 by definition"""
    nice: Callable[[Array], bool] = lambda _: False
    """Whether the amounts are ones that a slip would give"""
    scene: Callable[[float], Scene] | None = None
    """Scene whose right motion has the change, of an amount; None of a change that no scene has"""
    of: Callable[[float], Array] | None = None
    """Rows (n - 1, c) of an amount of a number"""
    probe: float = 0.0
    """Amount of a number that is small enough for a linear effect"""
    range: tuple[float, float] = (-math.inf, math.inf)
    """Least and largest amount"""
    number: Number | None = None
    """Number of the scene that changes"""

    @cached_property
    def rows(self) -> Array:
        """Rows (n - 1, c, m)."""
        made = self.make()
        return made[..., None] if made.ndim == 2 else made

    def effect(self, amounts: Array) -> Array:
        """Rows (n - 1, c) of amounts (m,)."""
        return self.rows @ amounts if self.of is None else self.of(float(amounts[0]))

    def effect_as_of(self, other: Candidate, amounts: Array) -> Array:
        """Rows (n - 1, c) of what the same candidate of another scene is there by amounts (m,)."""
        if self.number is None or other.number is None:
            return self.effect(amounts)
        return self.effect(np.array([self.number.as_in(other.number, float(amounts[0]))]))

    def possible(self, amounts: Array) -> bool:
        """Whether the amounts are in their range."""
        return bool(np.all((self.range[0] <= amounts) & (amounts <= self.range[1])))

    def linear(self, amounts: Array) -> bool:
        """Whether the effect of possible amounts is linear: of masses and lengths, of small amounts alone."""
        nearly = self.of is None or self.section != BODIES or abs(float(amounts[0])) <= SMALL
        return nearly and self.possible(amounts)


def linearised(
    name: str, section: str, of: Callable[[float], Array], words: Callable[[float], str], probe: float,
    within: tuple[float, float], number: Number | None = None,
) -> Candidate:  # fmt: skip
    """Change by an amount, linear about the right value; of a number of the scene, or of none."""
    return Candidate(
        name, section, lambda: of(probe) / probe, lambda a: words(float(a[0])),
        nice=lambda a: number is not None and number.nice(float(a[0])),
        scene=None if number is None else number.change, of=of, probe=probe, range=within, number=number,
    )  # fmt: skip


class Candidates:
    """Candidates of one balance, in their order."""

    def __init__(self, balance: Balance) -> None:
        """Start an empty list."""
        self.balance = balance
        self.found: list[Candidate] = []

    def rows(self, load: Load | Rows) -> Rows:
        """Maker of the rows of a load."""
        return load if callable(load) else partial(self.balance.rows, load)

    def times(self, name: str, subject: str, section: str, load: Load | Rows) -> None:
        """Add a term of the right equations that the engine has another number of times; subject with its verb."""

        def words(amounts: Array) -> str:
            return f"{subject} {factor_words(1.0 + float(amounts[0]))}"

        nice = lambda a: bool(nice_factor(1.0 + float(a[0])))  # noqa: E731
        self.found.append(Candidate(name, section, self.rows(load), words, nice=nice))

    def added(self, name: str, words: str, unit: str, section: str, load: Load | Rows) -> None:
        """Add a term that no scene has; words with `{}` for the amount."""

        def said(amounts: Array) -> str:
            return words.format(f"{float(amounts[0]):.4g} {unit}".rstrip())

        self.found.append(Candidate(name, section, self.rows(load), said))

    def fixed(self, name: str, words: str, section: str, load: Load | Rows, scene: Scene | None = None) -> None:
        """Add a change without an amount."""
        of = None if scene is None else lambda _: scene
        self.found.append(
            Candidate(name, section, self.rows(load), lambda _: words, fixed=True, nice=lambda _: True, scene=of)
        )
