"""Model of the chain: arrays in SI units, laws of prescribed rotations, and impulses."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from reference_impl.model.arrays import Array
    from reference_impl.model.effect import ChainEffect

LARGEST_ENTRY_RATIO = 31.0  # of the joint system, 1/m + l²/4J over 1/m, in a well-conditioned chain
LawFrame = Literal["inertial", "local_horizontal", "previous_bar"]
LAW_FRAMES: tuple[LawFrame, ...] = get_args(LawFrame)
GravityModel = Literal["none", "point", "gradient"]


def ill_conditioned(inverse_mass: Array, compliance: Array) -> NDArray[np.bool_]:
    """Whether the joint system is ill-conditioned: its entries (..., N) differ by more than `LARGEST_ENTRY_RATIO`.

    The entries are 1/m + l²/4J and 1/m. Their ratio is 4 for equal slender bars.
    """
    found: NDArray[np.bool_] = np.max(inverse_mass + compliance, -1) > LARGEST_ENTRY_RATIO * np.min(inverse_mass, -1)
    return found


@dataclass(frozen=True)
class BarTurn:
    """A turn from rest to rest, by eq. (28) or by 10 s³ - 15 s⁴ + 6 s⁵; or a piece of a quintic spline."""

    amplitude_rad: float
    duration_s: float
    start_s: float
    quintic: bool = False
    spline_rad: tuple[float, ...] = ()
    """Coefficients of a piece of a spline by the powers 1 to 5 of s; none for other turns. At an instant of two pieces
    the later one moves"""

    def angle_rad(self, t_s: float) -> float:
        """Angle gained, eq. (28)."""
        s = self._progress(t_s)
        if self.spline_rad:
            return self.amplitude_rad if s == 1.0 else self._spline(t_s, 0)
        if self.quintic:
            return self.amplitude_rad * s**3 * (10.0 - 15.0 * s + 6.0 * s * s)
        x = math.pi * s
        return self.amplitude_rad / 16.0 * (math.cos(3.0 * x) - 9.0 * math.cos(x) + 8.0)

    def acceleration_rad_s2(self, t_s: float) -> float:
        """Second derivative, continuous; zero at both ends but those of a piece of a spline."""
        if self.spline_rad:
            return self._spline(t_s, 2)
        s = self._progress(t_s)
        if self.quintic:
            return self.amplitude_rad / self.duration_s**2 * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s)
        x, w = math.pi * s, math.pi / self.duration_s
        return self.amplitude_rad / 16.0 * w * w * 9.0 * (math.cos(x) - math.cos(3.0 * x))

    def _spline(self, t_s: float, derivative: int) -> float:
        s = (t_s - self.start_s) / self.duration_s
        if not 0.0 <= s < 1.0:
            return 0.0
        found = 0.0
        for power in range(5, max(derivative, 1) - 1, -1):
            found = found * s + math.perm(power, derivative) * self.spline_rad[power - 1]
        return (found if derivative else found * s) / self.duration_s**derivative

    def _progress(self, t_s: float) -> float:
        return min(max((t_s - self.start_s) / self.duration_s, 0.0), 1.0)


@dataclass(frozen=True)
class Prescription:
    """Rotation of bar `bar` (counted from 0) by a law; its torque is an unknown of the equations."""

    bar: int
    turns: tuple[BarTurn, ...]
    """One after the other"""
    frame: LawFrame
    """From what the angle is measured; the local horizontal is that through the bar's own centre of mass"""
    reacts_on: int | None
    """Bar under the opposite torque (a motor in the joint between both bars); None: external torque"""

    def angle_rad(self, t_s: float) -> float:
        """Angle since the start of the law."""
        return sum(turn.angle_rad(t_s) for turn in self.turns)

    def acceleration_rad_s2(self, t_s: float) -> float:
        """Second derivative of the law."""
        return sum(turn.acceleration_rad_s2(t_s) for turn in self.turns)

    @property
    def breaks_s(self) -> tuple[float, ...]:
        """Instants at which a high derivative is discontinuous; no integration step may straddle them."""
        return tuple(t for turn in self.turns for t in (turn.start_s, turn.start_s + turn.duration_s))


@dataclass(frozen=True)
class BarImpulse:
    """Impulse on one end of a bar."""

    bar: int
    """Counted from 0"""
    side: float
    """beta of its bar: right end; -alpha: left end; with equal levers +1 and -1"""
    inertial: bool
    direction_rad: float
    impulse_N_s: float
    at_s: float


@dataclass(frozen=True)
class ChainModel:
    """Masses, lengths, moments of inertia and loads of a chain of N bars."""

    mu_m3_s2: float
    mass_kg: Array
    """(N,)"""
    length_m: Array
    """(N,)"""
    inertia_kg_m2: Array
    """(N,) about each bar's own centre of mass"""
    gravity: GravityModel
    body_radius_m: float = 0.0
    """Radius of the surface on which a run ends; 0: no surface"""
    prescriptions: tuple[Prescription, ...] = ()
    effects: tuple[ChainEffect, ...] = ()
    """Loads besides central gravity and prescribed rotations"""
    impulses: tuple[BarImpulse, ...] = ()
    spring_rate_rad_s: float = 0.0
    """Upper bound of the fastest oscillation or decay rate of joint springs and dampers; 0: none"""
    com_share: Array | None = None
    """(N,) share of each length from the left end to the centre of mass; None: midway in all bars"""

    @property
    def breaks_s(self) -> tuple[float, ...]:
        """Instants at which the equations are not smooth in time; no integration step may straddle them."""
        laws = [t for p in self.prescriptions for t in p.breaks_s]
        return tuple(laws + [t for e in self.effects for t in e.breaks_s] + [p.at_s for p in self.impulses])

    @property
    def bars(self) -> int:
        """Number of bars N."""
        return len(self.mass_kg)

    @cached_property
    def weight(self) -> Array:
        """(N,) mass fractions mu_j = m_j/M."""
        share: Array = self.mass_kg / self.mass_kg.sum()
        return share

    @cached_property
    def half_m(self) -> Array:
        """(N,) half lengths l_j/2."""
        half: Array = 0.5 * self.length_m
        return half

    @cached_property
    def left_share(self) -> Array:
        """(N,) alpha_j: distance of the left end from the centre of mass, over l_j/2."""
        return np.ones(self.bars) if self.com_share is None else 2.0 * self.com_share

    @cached_property
    def right_share(self) -> Array:
        """(N,) beta_j = 2 - alpha_j: that of the right end."""
        return np.ones(self.bars) if self.com_share is None else 2.0 * (1.0 - self.com_share)

    @cached_property
    def left_m(self) -> Array:
        """(N,) distances of the left ends from the centres of mass."""
        distance: Array = self.left_share * self.half_m
        return distance

    @cached_property
    def right_m(self) -> Array:
        """(N,) those of the right ends."""
        distance: Array = self.right_share * self.half_m
        return distance

    @cached_property
    def compliance(self) -> Array:
        """(N,) l_j²/(4 J_j), 1/kg: transverse acceleration of a bar's end by rotation, per unit force on that end.

        With unequal levers it is alpha² times as large at the left end, and beta² times at the right end.
        """
        gives: Array = self.half_m**2 / self.inertia_kg_m2
        return gives

    @cached_property
    def ill_conditioned(self) -> bool:
        """Whether solving the joints costs angular accelerations digits: bars too unequal or too compact."""
        longer = np.maximum(self.left_share, self.right_share)
        return bool(ill_conditioned(self.inverse_mass, longer**2 * self.compliance))

    @cached_property
    def gyration2(self) -> Array:
        """(N,) J_j/m_j, m²: squared radii of gyration."""
        square: Array = self.inertia_kg_m2 / self.mass_kg
        return square

    @cached_property
    def lever(self) -> Array:
        """(N,) l_j/(2 J_j), 1/(kg m): angular acceleration of a bar per unit transverse force on its end."""
        lever: Array = self.half_m / self.inertia_kg_m2
        return lever

    @cached_property
    def inverse_mass(self) -> Array:
        """(N,) 1/m_j, 1/kg."""
        inverse: Array = 1.0 / self.mass_kg
        return inverse
