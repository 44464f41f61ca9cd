"""States in which one evaluation is judged: exact numbers, the same for every formulation and arithmetic.

A state is drawn once; its members differ by a longitude, which no reaction knows of in a spherical field, and by a unit
in the last place of a double here and there. So each member rounds differently, and none is special.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

import gmpy2
import numpy as np

from reference_impl.precision.arithmetic import EXACT, Values
from reference_impl.precision.chain import ChainParameters, RelativeState, consistent_chain_state

if TYPE_CHECKING:
    from numpy.random import Generator

    from adapters.trajectory import Array

MU_M3_S2, EQUATOR_M, ALTITUDE_M = 3.986004418e14, 6378e3, 350e3
MASS_KG = 100.0
SPIN_FACTOR = 100.0  # rates of the fast state over the orbital one
MASS_RATIO = 1e6
MEMBERS = 32


class StateKind(StrEnum):
    """Kinds of states."""

    GENERIC = "generic"
    """Any attitude and rates, lengths and masses of one order."""
    STRAIGHT = "80°"
    """The paper's straight chain at 80° from the horizontal, turning with the orbit."""
    HORIZONTAL = "horizontal"
    """The same exactly horizontal: reactions nearly vanish."""
    SPIN = "fast spin"
    """As generic, each bar turning a hundred times as fast as the orbit."""
    UNEQUAL = "unequal masses"
    """As generic, masses alternating 1 : 1e6."""


@dataclass(frozen=True)
class EvaluationCase:
    """One point of the study: a state at a size ratio."""

    kind: StateKind
    bars: int
    ratio: float
    """epsilon: length of a bar over the Earth's radius"""
    members: int = MEMBERS


@dataclass(frozen=True)
class Exact:
    """A case's members in exact numbers."""

    bars: ChainParameters
    state: RelativeState

    @property
    def yard_N(self) -> Values:
        """(B,) mean mass times n² times the longest bar: what reactions of an ordinary state are of the order of."""
        com, bars = self.state.com_m, self.bars
        r2 = com[0] * com[0] + com[1] * com[1]
        rate2 = bars.mu_m3_s2 / (r2 * EXACT.sqrt(r2))
        return bars.mass_kg.sum(axis=0) / len(bars.mass_kg) * rate2 * bars.length_m.max(axis=0)


def exact_case(case: EvaluationCase) -> Exact:
    """Members of a case; to be called where exact numbers are in force.

    The same draw serves all size ratios, so that they differ by nothing else.
    """
    random = np.random.default_rng(zlib.crc32(f"{case.kind} {case.bars}".encode()))
    mass, length, angle, factor = configuration(case, random)
    blurred = case.kind is not StateKind.HORIZONTAL  # which must stay exactly so
    shape = (case.bars, case.members)
    lengths = EXACT.cast(length)[:, None] * gmpy2.mpfr(case.ratio) * EQUATOR_M * ulps(random, shape)
    masses = EXACT.cast(mass)[:, None] * ulps(random, shape)
    radius = gmpy2.mpfr(EQUATOR_M + ALTITUDE_M) * ulps(random, shape[1:])
    longitude = EXACT.cast(random.uniform(0.0, 2.0 * np.pi, case.members))
    from_horizontal = EXACT.cast(angle)[:, None] * (ulps(random, shape) if blurred else EXACT.cast(np.ones(shape)))
    mu = EXACT.cast(np.full(case.members, MU_M3_S2))
    rate = EXACT.sqrt(mu / radius) / radius * (EXACT.cast(factor)[:, None] * EXACT.cast(np.ones(shape)))
    bars = ChainParameters(mu, masses, lengths, masses * lengths * lengths / 12)
    com = np.stack([radius * EXACT.cos(longitude), radius * EXACT.sin(longitude)])
    turned = from_horizontal + (longitude - gmpy2.const_pi() / 2)
    return Exact(bars, consistent_chain_state(EXACT, bars, com, turned, rate * (ulps(random, shape) if blurred else 1)))


def configuration(case: EvaluationCase, random: Generator) -> tuple[Array, Array, Array, Array]:
    """Masses, lengths over the nominal one, angles from the horizontal and rates over the orbital one, each (N,)."""
    n = case.bars
    if case.kind in (StateKind.STRAIGHT, StateKind.HORIZONTAL):
        angle = np.radians(80.0) if case.kind is StateKind.STRAIGHT else 0.0
        return np.full(n, MASS_KG), np.ones(n), np.full(n, angle), np.ones(n)
    mass, length = MASS_KG * 10.0 ** random.uniform(-0.5, 0.5, n), random.uniform(0.5, 1.0, n)
    angle, factor = random.uniform(-np.pi, np.pi, n), random.uniform(-3.0, 3.0, n)
    if case.kind is StateKind.SPIN:
        factor = np.full(n, SPIN_FACTOR)
    if case.kind is StateKind.UNEQUAL:
        mass[1::2] /= MASS_RATIO
    return mass, length, angle, factor


def ulps(random: Generator, shape: tuple[int, ...]) -> Values:
    """Exact factors of 1, or a unit in a double's last place more or less."""
    return EXACT.cast(1.0 + random.integers(-1, 2, shape) * np.finfo(float).eps)


def longitude_rad(exact: Exact) -> Array:
    """Longitudes of a case's members, (B,), in [0, 2 pi)."""
    x, y = (v.astype(float) for v in exact.state.com_m)
    found: Array = np.arctan2(y, x) % (2.0 * np.pi)
    return found
