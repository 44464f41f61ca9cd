"""Quantities that vary from copy to copy, ``angle_deg=normal(80, 1)``: parsed, checked and drawn."""

from __future__ import annotations

import re
import zlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy import stats

from scenarios import nearest

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.trajectory import Array

PER_BAR = {"mass_kg": True, "length_m": True, "inertia_kg_m2": True, "angle_deg": False, "rate_factor": False}
"""Keys of a scene's chain that may vary, and whether they must be positive"""
SINGLE = {"altitude_m": True, "speed_factor": False, "longitude_deg": False}
"""The same of its orbit"""
NOT_NEGATIVE = {"speed_factor"}
ALLOWED = PER_BAR | SINGLE
PATTERN = re.compile(r"\s*(?:chain\.|orbit\.)?(\w+)\s*(?:\[\s*(\d+|\*)\s*\])?\s*=\s*(\w+)\s*\(([^()]*)\)\s*")
FORM = "KEY=DISTRIBUTION(NUMBERS), KEY[BAR]=... or KEY[*]=..., e.g. angle_deg=normal(80, 1)"


class VariationError(ValueError):
    """A variation that can't be understood or drawn."""


@dataclass(frozen=True)
class DistributionFamily:
    """A family of distributions, with the names of its parameters."""

    parameters: tuple[str, ...]
    make: Callable[..., Any]
    valid: Callable[..., bool]


FAMILIES = {
    "normal": DistributionFamily(("mean", "deviation"), stats.norm, lambda _, s: s >= 0.0),
    "uniform": DistributionFamily(("low", "high"), lambda a, b: stats.uniform(a, b - a), lambda a, b: b >= a),
    "lognormal": DistributionFamily(
        ("median", "sigma"), lambda m, s: stats.lognorm(s, scale=m), lambda m, s: m > 0.0 and s > 0.0
    ),
    "triangular": DistributionFamily(
        ("low", "mode", "high"),
        lambda a, m, b: stats.triang((m - a) / (b - a), a, b - a),
        lambda a, m, b: a <= m <= b and b > a,
    ),
}


@dataclass(frozen=True)
class Variation:
    """One quantity that varies."""

    text: str
    key: str
    bar: int | None
    """Counted from 1; 0: every bar by its own draw; None: all bars by the same draw, or nothing of a bar's"""
    family: str
    numbers: tuple[float, ...]

    def draw(self, runs: int, bars: int, seed: int) -> Array:
        """Values, shape (runs, k): k = N with a draw for each bar, else 1.

        The draws of one quantity do not depend on what else varies.

        Raises
        ------
        VariationError
            If a draw is out of what the scene allows.
        """
        rng = np.random.default_rng([seed, zlib.crc32(f"{self.key}[{self.bar}]".encode())])
        columns = bars if self.bar == 0 else 1
        made = FAMILIES[self.family].make(*self.numbers)
        values: Array = np.asarray(made.rvs(size=(runs, columns), random_state=rng), dtype=float)
        wrong = values <= 0.0 if ALLOWED[self.key] else values < (0.0 if self.key in NOT_NEGATIVE else -np.inf)
        if wrong.any():
            run, least = int(np.argmax(wrong.any(axis=1))), "greater than 0" if ALLOWED[self.key] else "0 or more"
            raise VariationError(
                f"--vary {self.text}: run {run + 1} draws {values[run].min():g}, allowed: {least}; "
                "bounds or a lognormal distribution keep draws there"
            )
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
    if key not in ALLOWED:
        raise VariationError(f"--vary: {key} can't vary{nearest(key, ALLOWED)}; allowed: {', '.join(ALLOWED)}")
    if name not in FAMILIES:
        raise VariationError(f"--vary: no distribution {name}{nearest(name, FAMILIES)}; allowed: {', '.join(FAMILIES)}")
    return Variation(text.strip(), key, which_bar(key, index, bars), name, parameters(text, name, inside))


def which_bar(key: str, index: str | None, bars: int) -> int | None:
    """Bar that ``KEY[index]`` means; 0 for each by itself."""
    if index is None:
        return None
    if key in SINGLE:
        raise VariationError(f"--vary: {key} is not a bar's; allowed: {key}=... without [{index}]")
    if index == "*":
        return 0
    if not 1 <= int(index) <= bars:
        raise VariationError(f"--vary: bar {index} given, allowed: 1 to {bars}, or * for each by itself")
    return int(index)


def parameters(text: str, name: str, inside: str) -> tuple[float, ...]:
    """Numbers between the brackets, as many as the distribution has and such as it allows."""
    family = FAMILIES[name]
    form = f"{name}({', '.join(family.parameters)})"
    try:
        numbers = tuple(float(part) for part in inside.split(","))
    except ValueError:
        raise VariationError(f"--vary: {text!r} given, allowed: numbers in {form}") from None
    right = len(numbers) == len(family.parameters) and all(np.isfinite(numbers))
    if not right or not family.valid(*numbers):
        raise VariationError(f"--vary: {text!r} given, allowed: {form} that make a distribution")
    return numbers
