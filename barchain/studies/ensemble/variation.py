"""Quantities that vary from copy to copy, ``angle_deg=normal(80, 1)``: parsed, checked and drawn."""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING

import numpy as np

from barchain.studies.distributions import FAMILIES, VariationError, parameters, stream
from scenarios import nearest
from scenarios.size_limits import LEAST_MAGNITUDE, MOST_MAGNITUDE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from adapters.trajectory import Array


class ValueRange(Enum):
    """Values that a quantity may have."""

    ANY = "any"
    POSITIVE = "greater than 0"
    NOT_NEGATIVE = "0 or more"

    def excludes(self, values: Array) -> NDArray[np.bool_]:
        """Flags of values outside the range, in the shape of `values`."""
        least = {ValueRange.ANY: -MOST_MAGNITUDE, ValueRange.POSITIVE: LEAST_MAGNITUDE, ValueRange.NOT_NEGATIVE: 0.0}
        inside = (values >= least[self]) & (values <= MOST_MAGNITUDE)  # false of NaN
        return np.asarray(~inside)


PER_BAR = {
    "mass_kg": ValueRange.POSITIVE,
    "length_m": ValueRange.POSITIVE,
    "inertia_kg_m2": ValueRange.POSITIVE,
    "angle_deg": ValueRange.ANY,
    "rate_factor": ValueRange.ANY,
}
"""Ranges of the keys of a scene's chain that may vary"""
SINGLE = {
    "altitude_m": ValueRange.POSITIVE,
    "speed_factor": ValueRange.NOT_NEGATIVE,
    "longitude_deg": ValueRange.ANY,
}
"""Ranges of the keys of its orbit that may vary"""
RANGES = PER_BAR | SINGLE
PATTERN = re.compile(r"\s*(?:chain\.|orbit\.)?(\w+)\s*(?:\[\s*(\d+|\*)\s*\])?\s*=\s*(\w+)\s*\(([^()]*)\)\s*")
FORM = "KEY=DISTRIBUTION(NUMBERS), KEY[BAR]=... or KEY[*]=..., e.g. angle_deg=normal(80, 1)"


@dataclass(frozen=True)
class Variation:
    """One quantity that varies."""

    text: str
    key: str
    bar: int | None
    """Counted from 1; 0: one draw for each bar; None: one draw for all bars, or a key of the orbit"""
    family: str
    numbers: tuple[float, ...]

    def overlaps(self, other: Variation) -> bool:
        """Whether two variations change the same quantity of some bar."""
        return self.key == other.key and (not self.bar or not other.bar or self.bar == other.bar)


class DrawStream:
    """Values of one quantity, copy after copy.

    They depend neither on what else varies, nor on how many copies are drawn at a time.
    """

    def __init__(self, variation: Variation, bars: int, seed: int) -> None:
        """Begin with the first copy."""
        self.variation, self.drawn = variation, 0
        self.columns = bars if variation.bar == 0 else 1
        self.made = FAMILIES[variation.family].make(*variation.numbers)
        self.rng = stream(seed, f"{variation.key}[{variation.bar}]")

    def take(self, runs: int) -> Array:
        """Values of the next copies, shape (runs, k): k = N with a draw for each bar, else 1.

        Raises
        ------
        VariationError
            If a draw is out of what the scene allows.
        """
        with np.errstate(over="ignore"):  # infinity is out of every range
            values: Array = np.asarray(self.made.rvs(size=(runs, self.columns), random_state=self.rng), dtype=float)
        valid = RANGES[self.variation.key]
        wrong = valid.excludes(values)
        if wrong.any():
            run = int(np.argmax(wrong.any(axis=1)))
            drawn = values[run][wrong[run]][0]
            raise VariationError(
                f"--vary {self.variation.text}: run {self.drawn + run + 1} draws {drawn:g}, allowed: {valid.value}, "
                f"up to {MOST_MAGNITUDE:g}; bounds or a lognormal distribution keep draws there"
            )
        self.drawn += runs
        return values


def parse(text: str, bars: int) -> Variation:
    """Variation from its text, for a chain of `bars` bars.

    Raises
    ------
    VariationError
        If it has another form, or an unknown key, bar, distribution or number of parameters.
    """
    found = PATTERN.fullmatch(text)
    if not found:
        raise VariationError(f"--vary: {text!r} given, allowed: {FORM}")
    key, index, name, inside = found.groups()
    if key not in RANGES:
        raise VariationError(
            f"--vary: {key} can't vary{nearest(key, RANGES)}; allowed: {', '.join(RANGES)}; "
            "barchain sweep varies any number of a scene"
        )
    return Variation(text.strip(), key, which_bar(key, index, bars), name, parameters(text, name, inside))


def which_bar(key: str, index: str | None, bars: int) -> int | None:
    """Bar of ``KEY[index]``, counted from 1; 0 for ``[*]``, None without an index."""
    if index is None:
        return None
    if key in SINGLE:
        raise VariationError(f"--vary: {key} is not a bar's; allowed: {key}=... without [{index}]")
    if index == "*":
        return 0
    if not 1 <= int(index) <= bars:
        raise VariationError(f"--vary: bar {index} given, allowed: 1 to {bars}, or * for each by itself")
    return int(index)
