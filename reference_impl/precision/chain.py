"""Chains and their states in any arithmetic: axes are plane component, bar, state."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from reference_impl.precision.arithmetic import Arithmetic, Values


@dataclass(frozen=True)
class ChainParameters:
    """Parameters of a chain of N bars in each of B states (B = 1: the same in all)."""

    mu_m3_s2: Values
    """(B,)"""
    mass_kg: Values
    """(N, B)"""
    length_m: Values
    """(N, B)"""
    inertia_kg_m2: Values
    """(N, B)"""
    gradient: bool = field(default=True, kw_only=True)
    """Whether the gradient of gravity turns the bars"""

    @cached_property
    def weight(self) -> Values:
        """(N, B) mass fractions."""
        return self.mass_kg / self.mass_kg.sum(axis=0)

    @cached_property
    def half_m(self) -> Values:
        """(N, B) half lengths."""
        return self.length_m * 0.5

    @cached_property
    def lever(self) -> Values:
        """(N, B) l/(2 J)."""
        return self.half_m / self.inertia_kg_m2

    @cached_property
    def compliance(self) -> Values:
        """(N, B) l²/(4 J)."""
        return self.half_m * self.lever

    @cached_property
    def inverse_mass(self) -> Values:
        """(N, B) 1/m."""
        return 1.0 / self.mass_kg

    def cast(self, to: Arithmetic) -> ChainParameters:
        """Parameters rounded to another arithmetic."""
        own = map(to.cast, (self.mu_m3_s2, self.mass_kg, self.length_m, self.inertia_kg_m2))
        return ChainParameters(*own, gradient=self.gradient)


@dataclass(frozen=True)
class RelativeState:
    """State in relative coordinates: the centre of mass, and each bar relative to the centre of mass."""

    com_m: Values
    """(2, B) Z0"""
    position_m: Values
    """(2, N, B) d_j"""
    angle_rad: Values
    """(N, B)"""
    rate_rad_s: Values
    """(N, B)"""

    def cast(self, to: Arithmetic) -> RelativeState:
        """State rounded to another arithmetic."""
        return RelativeState(*map(to.cast, (self.com_m, self.position_m, self.angle_rad, self.rate_rad_s)))

    @property
    def absolute(self) -> AbsoluteState:
        """The state in absolute coordinates, with the rounding of the sum."""
        return AbsoluteState(self.com_m[:, None] + self.position_m, self.angle_rad, self.rate_rad_s)


@dataclass(frozen=True)
class AbsoluteState:
    """State in absolute coordinates: each bar from the body's centre."""

    place_m: Values
    """(2, N, B) Z_j"""
    angle_rad: Values
    """(N, B)"""
    rate_rad_s: Values
    """(N, B)"""

    def cast(self, to: Arithmetic) -> AbsoluteState:
        """State rounded to another arithmetic."""
        return AbsoluteState(*map(to.cast, (self.place_m, self.angle_rad, self.rate_rad_s)))


@dataclass(frozen=True)
class ChainAccelerations:
    """Reactions and accelerations of a chain."""

    reaction_N: Values
    """(2, N-1, B) force on bar j from bar j+1"""
    angle_rad_s2: Values
    """(N, B)"""
    place_m_s2: Values
    """(2, N, B): Z_j'' in absolute coordinates, d_j'' in relative coordinates"""
    com_m_s2: Values
    """(2, B) Z0''"""


def directions(a: Arithmetic, angle_rad: Values) -> tuple[Values, Values]:
    """Unit vectors u along the bars and n across them, each (2, N, B)."""
    cosine, sine = a.cos(angle_rad), a.sin(angle_rad)
    return np.array([cosine, sine]), np.array([-sine, cosine])


def dot(v: Values, w: Values) -> Values:
    """Scalar product over the first axis."""
    return v[0] * w[0] + v[1] * w[1]


def bar_centres(bars: ChainParameters, reach_m: Values) -> Values:
    """Positions of the bars' centres relative to the centre of mass, given each centre's vector to its right end.

    Eqs. (6) and (7'), linear in `reach_m`, shape (2, N, B).
    """
    between = np.cumsum(reach_m[:, :-1] + reach_m[:, 1:], axis=1)
    from_first = np.concatenate([0.0 * reach_m[:, :1], between], axis=1)
    return from_first - (from_first * bars.weight).sum(axis=1)[:, None]


def consistent_chain_state(
    a: Arithmetic, bars: ChainParameters, com_m: Values, angle_rad: Values, rate_rad_s: Values
) -> RelativeState:
    """State with closed joints."""
    along, _ = directions(a, angle_rad)
    return RelativeState(com_m, bar_centres(bars, bars.half_m * along), angle_rad, rate_rad_s)
