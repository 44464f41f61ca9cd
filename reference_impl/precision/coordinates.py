"""Integrator's state vectors in any arithmetic, for many runs; see docs/explanation/numerics.md.

A vector is an array (rows, B): positions, then velocities, one column per run.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from reference_impl.integrate.roundings import ROUNDINGS
from reference_impl.precision.chain import (
    AbsoluteState,
    ChainAccelerations,
    ChainParameters,
    RelativeState,
    bar_centres,
    consistent_chain_state,
    directions,
)
from reference_impl.precision.formulations import absolute, relative

if TYPE_CHECKING:
    from reference_impl.precision.arithmetic import Arithmetic, Values


@dataclass(frozen=True)
class InitialChains:
    """Initial states of chains with closed joints, in an arithmetic finer than that of any run."""

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
        """Relative positions d_j, (2, N, B)."""
        return bar_centres(self.bars, self.bars.half_m * directions(self.a, self.angle_rad)[0])

    @cached_property
    def velocity_m_s(self) -> Values:
        """Relative velocities d_j', (2, N, B)."""
        return bar_centres(self.bars, self.bars.half_m * self.rate_rad_s * directions(self.a, self.angle_rad)[1])


@dataclass(frozen=True)
class ChainObservables:
    """Observables at one instant, in the arithmetic of the run."""

    angle_rad: Values
    """(N, B)"""
    reaction_N: Values
    """(2, N-1, B)"""
    gap_m: Values
    """(B,) largest joint gap"""
    com_m: Values
    """(2, B)"""


@dataclass(frozen=True)
class ErrorScales:
    """Units of the errors in each run."""

    radius_m: Values
    """(B,)"""
    length_m: Values
    """(B,)"""
    rate_rad_s: Values
    """(B,)"""


class HighPrecisionCoordinates(ABC):
    """Set of coordinates of chains, in one arithmetic."""

    name: ClassVar[str]

    def __init__(self, a: Arithmetic, bars: ChainParameters) -> None:
        """Prepare for chains `bars`, given in any arithmetic."""
        self.a, self.bars = a, bars.cast(a)
        self.n = int(self.bars.mass_kg.shape[0])

    def pack(self, start: InitialChains) -> Values:
        """Vector (rows, B) of initial chains, computed in their arithmetic and then rounded."""
        return self.a.cast(stacked(self.initial_parts(start)))

    def rates(self, y: Values) -> Values:
        """Time derivative of a vector."""
        return np.concatenate([y[len(y) // 2 :], stacked(self.accelerations(self.chain_accelerations(y)))])

    def error_scales(self, u: ErrorScales) -> Values:
        """Unit of the error in each row, (rows, B)."""
        return with_rates(u, self.position_scales(u))

    def roundoff_floor(self, u: ErrorScales) -> Values:
        """Round-off error (rows, B) in one step; smaller tolerances make the step size collapse."""
        return 2.0 * ROUNDINGS * self.a.unit_roundoff * self.error_scales(u)

    def observables(self, y: Values) -> ChainObservables:
        """Observables of a vector."""
        place, com, angle = self.bar_positions(y)
        reach = self.bars.half_m * directions(self.a, angle)[0]
        gap = (place[:, 1:] - place[:, :-1]) - (reach[:, 1:] + reach[:, :-1])
        opened = self.a.sqrt(gap[0] * gap[0] + gap[1] * gap[1]).max(axis=0, initial=0.0)
        return ChainObservables(angle, self.chain_accelerations(y).reaction_N, opened, com)

    @abstractmethod
    def initial_parts(self, start: InitialChains) -> tuple[Values, ...]:
        """Positions, then velocities, in the arithmetic of the initial chains."""

    @abstractmethod
    def chain_accelerations(self, y: Values) -> ChainAccelerations:
        """Reactions and accelerations at a vector."""

    @abstractmethod
    def accelerations(self, found: ChainAccelerations) -> tuple[Values, ...]:
        """Second derivatives, in the order of the positions."""

    @abstractmethod
    def position_scales(self, u: ErrorScales) -> list[tuple[Values, int]]:
        """Units of the errors in the positions, each with its number of rows."""

    @abstractmethod
    def bar_positions(self, y: Values) -> tuple[Values, Values, Values]:
        """Bars' centres (2, N, B) from the origin of these coordinates, the centre of mass (2, B), and angles."""


class HighPrecisionMinimal(HighPrecisionCoordinates):
    """Centre of mass and angles: the reference's coordinates."""

    name = "minimal"

    def initial_parts(self, start: InitialChains) -> tuple[Values, ...]:
        """Z0, theta."""
        return start.com_m, start.angle_rad, start.com_velocity_m_s, start.rate_rad_s

    def chain_accelerations(self, y: Values) -> ChainAccelerations:
        """Relative formulation of a chain with joints closed by construction."""
        return relative(
            self.a, self.bars, consistent_chain_state(self.a, self.bars, y[:2], y[2 : 2 + self.n], y[4 + self.n :])
        )

    def accelerations(self, found: ChainAccelerations) -> tuple[Values, ...]:
        """Accelerations of the centre of mass and the angles."""
        return found.com_m_s2, found.angle_rad_s2

    def position_scales(self, u: ErrorScales) -> list[tuple[Values, int]]:
        """Radius and radian."""
        return [(u.radius_m, 2), (np.ones_like(u.radius_m), self.n)]

    def bar_positions(self, y: Values) -> tuple[Values, Values, Values]:
        """Positions from the centre of mass, by the angles."""
        angle = y[2 : 2 + self.n]
        return bar_centres(self.bars, self.bars.half_m * directions(self.a, angle)[0]), y[:2], angle


class HighPrecisionRedundant(HighPrecisionCoordinates):
    """Centre of mass, relative positions, and angles: the paper's unknowns."""

    name = "relative"

    def initial_parts(self, start: InitialChains) -> tuple[Values, ...]:
        """Z0, d, theta."""
        return (
            start.com_m, start.position_m, start.angle_rad,
            start.com_velocity_m_s, start.velocity_m_s, start.rate_rad_s,
        )  # fmt: skip

    def state(self, y: Values) -> RelativeState:
        """State including its drift."""
        n = self.n
        return RelativeState(y[:2], y[2 : 2 + 2 * n].reshape(2, n, -1), y[2 + 2 * n : 2 + 3 * n], y[4 + 5 * n :])

    def chain_accelerations(self, y: Values) -> ChainAccelerations:
        """Relative formulation."""
        return relative(self.a, self.bars, self.state(y))

    def accelerations(self, found: ChainAccelerations) -> tuple[Values, ...]:
        """Accelerations of the centre of mass, the positions and the angles."""
        return found.com_m_s2, found.place_m_s2, found.angle_rad_s2

    def position_scales(self, u: ErrorScales) -> list[tuple[Values, int]]:
        """Radius, bar length and radian."""
        return [(u.radius_m, 2), (u.length_m, 2 * self.n), (np.ones_like(u.radius_m), self.n)]

    def bar_positions(self, y: Values) -> tuple[Values, Values, Values]:
        """Positions from the centre of mass, as integrated."""
        state = self.state(y)
        return state.position_m, state.com_m, state.angle_rad


class HighPrecisionAbsolute(HighPrecisionCoordinates):
    """Positions from the centre of the body, and angles."""

    name = "absolute"

    def initial_parts(self, start: InitialChains) -> tuple[Values, ...]:
        """Z, theta."""
        place, velocity = start.com_m[:, None] + start.position_m, start.com_velocity_m_s[:, None] + start.velocity_m_s
        return place, start.angle_rad, velocity, start.rate_rad_s

    def state(self, y: Values) -> AbsoluteState:
        """State including its drift."""
        n = self.n
        return AbsoluteState(y[: 2 * n].reshape(2, n, -1), y[2 * n : 3 * n], y[5 * n :])

    def chain_accelerations(self, y: Values) -> ChainAccelerations:
        """Absolute formulation."""
        return absolute(self.a, self.bars, self.state(y))

    def accelerations(self, found: ChainAccelerations) -> tuple[Values, ...]:
        """Accelerations of the positions and the angles."""
        return found.place_m_s2, found.angle_rad_s2

    def position_scales(self, u: ErrorScales) -> list[tuple[Values, int]]:
        """Bar length and radian: joints need positions to a bar's accuracy."""
        return [(u.length_m, 2 * self.n), (np.ones_like(u.radius_m), self.n)]

    def roundoff_floor(self, u: ErrorScales) -> Values:
        """Round-off of the radius, and the angle error that it causes over a bar."""
        place = 2.0 * ROUNDINGS * self.a.unit_roundoff * u.radius_m
        return with_rates(u, [(place, 2 * self.n), (place / u.length_m, self.n)])

    def bar_positions(self, y: Values) -> tuple[Values, Values, Values]:
        """Positions from the body's centre."""
        state = self.state(y)
        return state.place_m, (state.place_m * self.bars.weight).sum(axis=1), state.angle_rad


HIGH_PRECISION_SETS: dict[str, type[HighPrecisionCoordinates]] = {
    s.name: s for s in (HighPrecisionMinimal, HighPrecisionRedundant, HighPrecisionAbsolute)
}


def stacked(parts: tuple[Values, ...]) -> Values:
    """Rows of several arrays, stacked."""
    return np.concatenate([part.reshape(-1, part.shape[-1]) for part in parts])


def with_rates(u: ErrorScales, positions: list[tuple[Values, int]]) -> Values:
    """Error units of positions, then the same times the rate."""
    rows = np.concatenate([np.broadcast_to(value, (times, len(value))) for value, times in positions])
    return np.concatenate([rows, rows * u.rate_rad_s])
