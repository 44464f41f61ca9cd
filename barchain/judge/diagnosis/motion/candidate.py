"""Candidates for what is wrong in equations of motion, words for their amounts, and a list that collects them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.trajectory import Array
    from barchain.judge.diagnosis.motion.balance import Balance
    from barchain.judge.diagnosis.motion.equations import Load
    from scenarios import Scene

GRAVITY, LOADS, BODIES = "gravity", "loads", "masses-lengths-and-inertia"
"""Anchors of the conventions that equations of motion break"""
FACTORS = {
    0.0: "missing", -1.0: "of the opposite sign", 0.5: "half the right value", 2.0: "twice the right value",
    math.degrees(1.0): "180/pi times the right value, as if per degree",
    math.radians(1.0): "pi/180 times the right value, as if per radian",
}  # fmt: skip
"""Factors of a right value that have words"""
NICE = 1e-4
"""Difference from a number that has words, relative to it, below which a fitted number is that number"""
NEAR_ONE = 1e-3
"""Departure from 1 below which a factor is told by the departure"""


def nice_factor(factor: float) -> str:
    """Words of a factor that a slip would give; empty for another one."""
    return next((said for nice, said in FACTORS.items() if abs(factor - nice) <= NICE * max(abs(nice), 1.0)), "")


def factor_words(factor: float) -> str:
    """Words after "is" for a factor of the right value."""
    departure = factor - 1.0
    said = (
        f"(1 {'-' if departure < 0.0 else '+'} {abs(departure):.3g})" if abs(departure) < NEAR_ONE else f"{factor:.6g}"
    )
    return nice_factor(factor) or f"{said} times the right value"


@dataclass(frozen=True)
class Candidate:
    """A change of the right equations, linear in its amounts or fixed."""

    name: str
    section: str
    """Anchor of the convention"""
    make: Callable[[], Array]
    """Rows (n - 1, c) or (n - 1, c, m) that the change adds to the balance for a unit of each amount"""
    words: Callable[[Array], str]
    """Sentence of the amounts (m,), without a full stop; begins with `the`"""
    fixed: bool = False
    """Whether the amount is 1 by definition"""
    nice: Callable[[Array], bool] = lambda _: False
    """Whether the amounts are ones that a slip would give"""
    scene: Callable[[float], Scene] | None = None
    """Scene whose right motion has the change, of an amount; None of a change that no scene has"""

    @cached_property
    def rows(self) -> Array:
        """Rows (n - 1, c, m)."""
        made = self.make()
        return made[..., None] if made.ndim == 2 else made


class Candidates:
    """Candidates of one balance, in their order."""

    def __init__(self, balance: Balance) -> None:
        """Start an empty list."""
        self.balance = balance
        self.found: list[Candidate] = []

    def rows(self, load: Load | Callable[[], Array]) -> Callable[[], Array]:
        """Maker of the rows of a load."""
        return load if callable(load) else partial(self.balance.rows, load)

    def times(self, name: str, subject: str, section: str, load: Load | Callable[[], Array]) -> None:
        """Add a term of the right equations that the engine has another number of times; subject with its verb."""
        self.found.append(
            Candidate(
                name, section, self.rows(load), lambda a: f"{subject} {factor_words(1.0 + float(a[0]))}",
                nice=lambda a: bool(nice_factor(1.0 + float(a[0]))),
            )
        )  # fmt: skip

    def added(self, name: str, words: str, unit: str, section: str, load: Load | Callable[[], Array]) -> None:
        """Add a term that no scene has; words with `{}` for the amount."""
        self.found.append(
            Candidate(name, section, self.rows(load), lambda a: words.format(f"{float(a[0]):.4g} {unit}".rstrip()))
        )

    def fixed(self, name: str, words: str, section: str, load: Load | Callable[[], Array]) -> None:
        """Add a change without an amount."""
        self.found.append(fixed(name, section, self.rows(load), words))


def fixed(name: str, section: str, make: Callable[[], Array], words: str) -> Candidate:
    """Change without an amount."""
    return Candidate(name, section, make, lambda _: words, fixed=True, nice=lambda _: True)


def uniform_words(amount: Array) -> str:
    """Words for a uniform field (2,) m/s²."""
    size, parts = float(np.hypot(*amount)), [(v, f"z{k + 1}") for k, v in enumerate(amount.tolist())]
    along = [f"{'+' if v > 0.0 else '-'}{axis}" for v, axis in parts if abs(v) > NEAR_ONE * size]
    way = f"along {along[0]}" if len(along) == 1 else f"({parts[0][0]:.4g}, {parts[1][0]:.4g}) m/s^2"
    own = ": the engine's own gravity is left on" if is_own_gravity(amount) else ""
    return f"the motion has a uniform gravity of {size:.5g} m/s^2 {way}{own}"


def is_own_gravity(amount: Array) -> bool:
    """Whether a uniform field is that of the Earth's surface, with which libraries begin."""
    return any(abs(float(np.hypot(*amount)) / g - 1.0) < NICE for g in (9.81, 9.80665, 9.8, 10.0))
