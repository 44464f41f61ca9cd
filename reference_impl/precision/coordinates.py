"""What an integration carries from step to step, in any arithmetic: sets of design/coordinates.md, for many runs.

A vector is an array (rows, B): positions, then velocities, one column for each run.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from reference_impl.precision.chain import (
    AbsoluteState,
    ChainAccelerations,
    ChainParameters,
    RelativeState,
    bar_centres,
    directions,
    joined_chain_state,
)
from reference_impl.precision.formulations import absolute, relative

if TYPE_CHECKING:
    from reference_impl.precision.arithmetic import Arithmetic, Values

ROUNDINGS = 4.0  # roundings of a stage that a coordinate keeps, as in reference_impl.integrate.simulate


@dataclass(frozen=True)
class InitialChains:
    """Joined chains and their centres of mass, in an arithmetic finer than any that they are run in."""

    a: Arithmetic
    bars: ChainParameters
    com_m: Values
    """(2, B)"""
    com_velocity_m_s: Values
    """(2, B)"""
    angle_rad: Values
    """(N, B)"""
    rate_rad_s: Values
    """(N, B)"""

    @cached_property
    def position_m(self) -> Values:
        """d_j, (2, N, B)."""
        return bar_centres(self.bars, self.bars.half_m * directions(self.a, self.angle_rad)[0])

    @cached_property
    def velocity_m_s(self) -> Values:
        """d_j', (2, N, B)."""
        return bar_centres(self.bars, self.bars.half_m * self.rate_rad_s * directions(self.a, self.angle_rad)[1])


@dataclass(frozen=True)
class ChainObservables:
    """What is looked at at an instant, in the arithmetic of the run."""

    angle_rad: Values
    """(N, B)"""
    reaction_N: Values
    """(2, N-1, B)"""
    gap_m: Values
    """(B,) largest"""
    com_m: Values
    """(2, B)"""


@dataclass(frozen=True)
class ErrorScales:
    """What counts as 1, in each run."""

    radius_m: Values
    """(B,)"""
    length_m: Values
    """(B,)"""
    rate_rad_s: Values
    """(B,)"""


class HighPrecisionCoordinates(ABC):
    """A set of coordinates of chains, in one arithmetic."""

    name: ClassVar[str]

    def __init__(self, a: Arithmetic, bars: ChainParameters) -> None:
        """Prepare for chains `bars`, given in any arithmetic."""
        self.a, self.bars = a, bars.cast(a)
        self.n = int(self.bars.mass_kg.shape[0])

    def pack(self, start: InitialChains) -> Values:
        """Vector (rows, B) of a start: made in its arithmetic, then rounded."""
        return self.a.cast(stacked(self.initial_parts(start)))

    def rates(self, y: Values) -> Values:
        """Time derivative of a vector."""
        return np.concatenate([y[len(y) // 2 :], stacked(self.accelerations(self.chain_accelerations(y)))])

    def error_scales(self, u: ErrorScales) -> Values:
        """What counts as 1 in each row, (rows, B)."""
        return with_rates(u, self.position_scales(u))

    def roundoff_floor(self, u: ErrorScales) -> Values:
        """Error (rows, B) that rounding makes anyway: to ask for less makes steps collapse."""
        return 2.0 * ROUNDINGS * self.a.unit_roundoff * self.error_scales(u)

    def observables(self, y: Values) -> ChainObservables:
        """Observables of a vector."""
        place, com, angle = self.bar_positions(y)
        reach = self.bars.half_m * directions(self.a, angle)[0]
        gap = (place[:, 1:] - place[:, :-1]) - (reach[:, 1:] + reach[:, :-1])
        opened = self.a.sqrt(gap[0] * gap[0] + gap[1] * gap[1]).max(axis=0)
        return ChainObservables(angle, self.chain_accelerations(y).reaction_N, opened, com)

    @abstractmethod
    def initial_parts(self, start: InitialChains) -> tuple[Values, ...]:
        """Positions, then velocities, in the arithmetic of the start."""

    @abstractmethod
    def chain_accelerations(self, y: Values) -> ChainAccelerations:
        """Reactions and accelerations at a vector."""

    @abstractmethod
    def accelerations(self, found: ChainAccelerations) -> tuple[Values, ...]:
        """Second derivatives, in the order of the positions."""

    @abstractmethod
    def position_scales(self, u: ErrorScales) -> list[tuple[Values, int]]:
        """What counts as 1 in the positions, and how many rows each holds for."""

    @abstractmethod
    def bar_positions(self, y: Values) -> tuple[Values, Values, Values]:
        """Bars' centres (2, N, B), from where these coordinates count them, the centre of mass (2, B) and angles."""


class HighPrecisionMinimal(HighPrecisionCoordinates):
    """Centre of mass and angles: what the reference integrates."""

    name = "minimal"

    def initial_parts(self, start: InitialChains) -> tuple[Values, ...]:
        """Z0, theta."""
        return start.com_m, start.angle_rad, start.com_velocity_m_s, start.rate_rad_s

    def chain_accelerations(self, y: Values) -> ChainAccelerations:
        """Relative formulation of a chain whose joints are closed by construction."""
        return relative(
            self.a, self.bars, joined_chain_state(self.a, self.bars, y[:2], y[2 : 2 + self.n], y[4 + self.n :])
        )

    def accelerations(self, found: ChainAccelerations) -> tuple[Values, ...]:
        """Of the centre and the angles."""
        return found.com_m_s2, found.angle_rad_s2

    def position_scales(self, u: ErrorScales) -> list[tuple[Values, int]]:
        """Radius and radian."""
        return [(u.radius_m, 2), (np.ones_like(u.radius_m), self.n)]

    def bar_positions(self, y: Values) -> tuple[Values, Values, Values]:
        """From the centre of mass, by the angles."""
        angle = y[2 : 2 + self.n]
        return bar_centres(self.bars, self.bars.half_m * directions(self.a, angle)[0]), y[:2], angle


class HighPrecisionRedundant(HighPrecisionCoordinates):
    """Centre of mass, places relative to it, and angles: the paper's unknowns."""

    name = "relative"

    def initial_parts(self, start: InitialChains) -> tuple[Values, ...]:
        """Z0, d, theta."""
        return (
            start.com_m, start.position_m, start.angle_rad,
            start.com_velocity_m_s, start.velocity_m_s, start.rate_rad_s,
        )  # fmt: skip

    def state(self, y: Values) -> RelativeState:
        """State as it is, drift and all."""
        n = self.n
        return RelativeState(y[:2], y[2 : 2 + 2 * n].reshape(2, n, -1), y[2 + 2 * n : 2 + 3 * n], y[4 + 5 * n :])

    def chain_accelerations(self, y: Values) -> ChainAccelerations:
        """Relative formulation."""
        return relative(self.a, self.bars, self.state(y))

    def accelerations(self, found: ChainAccelerations) -> tuple[Values, ...]:
        """Of the centre, the places and the angles."""
        return found.com_m_s2, found.place_m_s2, found.angle_rad_s2

    def position_scales(self, u: ErrorScales) -> list[tuple[Values, int]]:
        """Radius, bar length and radian."""
        return [(u.radius_m, 2), (u.length_m, 2 * self.n), (np.ones_like(u.radius_m), self.n)]

    def bar_positions(self, y: Values) -> tuple[Values, Values, Values]:
        """From the centre of mass, as integrated."""
        state = self.state(y)
        return state.position_m, state.com_m, state.angle_rad


class HighPrecisionAbsolute(HighPrecisionCoordinates):
    """Places from the centre of the body, and angles."""

    name = "absolute"

    def initial_parts(self, start: InitialChains) -> tuple[Values, ...]:
        """Z, theta."""
        place, velocity = start.com_m[:, None] + start.position_m, start.com_velocity_m_s[:, None] + start.velocity_m_s
        return place, start.angle_rad, velocity, start.rate_rad_s

    def state(self, y: Values) -> AbsoluteState:
        """State as it is."""
        n = self.n
        return AbsoluteState(y[: 2 * n].reshape(2, n, -1), y[2 * n : 3 * n], y[5 * n :])

    def chain_accelerations(self, y: Values) -> ChainAccelerations:
        """Absolute formulation."""
        return absolute(self.a, self.bars, self.state(y))

    def accelerations(self, found: ChainAccelerations) -> tuple[Values, ...]:
        """Of the places and the angles."""
        return found.place_m_s2, found.angle_rad_s2

    def position_scales(self, u: ErrorScales) -> list[tuple[Values, int]]:
        """Bar length and radian: joints need places to a bar's accuracy."""
        return [(u.length_m, 2 * self.n), (np.ones_like(u.radius_m), self.n)]

    def roundoff_floor(self, u: ErrorScales) -> Values:
        """Units in the last place of the radius, and of what an angle makes of them over a bar."""
        place = 2.0 * ROUNDINGS * self.a.unit_roundoff * u.radius_m
        return with_rates(u, [(place, 2 * self.n), (place / u.length_m, self.n)])

    def bar_positions(self, y: Values) -> tuple[Values, Values, Values]:
        """From the body's centre."""
        state = self.state(y)
        return state.place_m, (state.place_m * self.bars.weight).sum(axis=1), state.angle_rad


HIGH_PRECISION_SETS: dict[str, type[HighPrecisionCoordinates]] = {
    s.name: s for s in (HighPrecisionMinimal, HighPrecisionRedundant, HighPrecisionAbsolute)
}


def stacked(parts: tuple[Values, ...]) -> Values:
    """Rows of several arrays, one below the other."""
    return np.concatenate([part.reshape(-1, part.shape[-1]) for part in parts])


def with_rates(u: ErrorScales, positions: list[tuple[Values, int]]) -> Values:
    """Rows of units: those of the positions, then the same times the rate."""
    rows = np.concatenate([np.broadcast_to(value, (times, len(value))) for value, times in positions])
    return np.concatenate([rows, rows * u.rate_rad_s])
