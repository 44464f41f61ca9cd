"""Distributions that numbers of a scene are drawn from, ``normal(80, 1)``, parsed and checked; streams of draws."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy import stats

from scenarios import nearest
from scenarios.size_limits import LEAST_MAGNITUDE, MOST_MAGNITUDE

if TYPE_CHECKING:
    from collections.abc import Callable


class VariationError(ValueError):
    """Invalid text of a variation, or a draw outside the range of a quantity."""


@dataclass(frozen=True)
class DistributionFamily:
    """A family of distributions, with the names of its parameters."""

    parameters: tuple[str, ...]
    make: Callable[..., Any]
    valid: Callable[..., bool]
    rule: str
    """Allowed parameters in words"""


FAMILIES = {
    "normal": DistributionFamily(
        ("mean", "deviation"), stats.norm, lambda _, s: s >= 0.0, "with a deviation of 0 or more"
    ),
    "uniform": DistributionFamily(
        ("low", "high"), lambda a, b: stats.uniform(a, b - a), lambda a, b: b >= a, "with low at most high"
    ),
    "lognormal": DistributionFamily(
        ("median", "sigma"),
        lambda m, s: stats.lognorm(s, scale=m),
        lambda m, s: m > 0.0 and s > 0.0,
        "both above 0",
    ),
    "triangular": DistributionFamily(
        ("low", "mode", "high"),
        lambda a, m, b: stats.triang((m - a) / (b - a), a, b - a),
        lambda a, m, b: a <= m <= b and b > a,
        "with low <= mode <= high, and low below high",
    ),
}


def parameters(text: str, name: str, inside: str) -> tuple[float, ...]:
    """Parameters of a distribution from the text between its brackets.

    Parameters
    ----------
    text : str
        The whole variation, for messages.
    name : str
        Family of the distribution.
    inside : str
        Numbers with commas.

    Raises
    ------
    VariationError
        If there is no such family, or its parameters are others.
    """
    if name not in FAMILIES:
        raise VariationError(f"--vary: no distribution {name}{nearest(name, FAMILIES)}; allowed: {', '.join(FAMILIES)}")
    family = FAMILIES[name]
    form = f"{name}({', '.join(family.parameters)})"
    try:
        numbers = tuple(float(part) for part in inside.split(","))
    except ValueError:
        raise VariationError(f"--vary: {text!r} given, allowed: numbers in {form}") from None
    if not all(map(is_bounded, numbers)):
        raise VariationError(
            f"--vary: {text!r} given, allowed: {form} of 0 or magnitudes from {LEAST_MAGNITUDE:g} to {MOST_MAGNITUDE:g}"
        )
    if len(numbers) != len(family.parameters) or not family.valid(*numbers):
        raise VariationError(f"--vary: {text!r} given, allowed: {form} {family.rule}")
    return numbers


def is_bounded(number: float) -> bool:
    """Whether a scene file may hold a number; NaN and infinity are none."""
    return number == 0.0 or LEAST_MAGNITUDE <= abs(number) <= MOST_MAGNITUDE


def stream(seed: int, name: str) -> np.random.Generator:
    """Random numbers of one quantity, which do not depend on what else varies."""
    return np.random.default_rng([seed, zlib.crc32(name.encode())])
