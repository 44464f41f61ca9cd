"""Force on a bar's end, piecewise linear in time."""

from __future__ import annotations

import cmath
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from reference_impl.model.effect import ChainEffect, EffectAccelerations, EffectState

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array
    from reference_impl.model.effect import ChainProperties

SAME_INSTANT = 1e-12  # relative; a sample this close after an instant of the table coincides with that instant


@final
@dataclass(frozen=True)
class ThrustEffect(ChainEffect):
    """Thruster; the mode is the segment of its table, counted from 0, or -1 outside."""

    bar: int
    """Counted from 0"""
    side: float
    """+1: right end, -1: left end"""
    inertial: bool
    direction_rad: float
    times_s: Array
    """(k,)"""
    force_N: Array
    """(k,)"""

    name = "thrust"

    @property
    def breaks_s(self) -> tuple[float, ...]:
        """Instants of the table."""
        return tuple(self.times_s.tolist())

    def largest_acceleration_m_s2(self, model: ChainProperties) -> float:
        """Largest force over the chain's mass."""
        return float(np.abs(self.force_N).max() / model.mass_kg.sum())

    def accelerations(self, at: EffectState, mode: Array | None) -> EffectAccelerations:
        """Force and torque on one bar."""
        segment = self.mode(at) if mode is None else mode
        difference, spin = at.zero_acceleration, at.zero_angular
        size = self.interpolated_force_N(int(segment[0]), at.t_s)
        if size == 0.0:
            return EffectAccelerations(0j, difference, spin)
        m, k, u = at.model, self.bar, at.unit[self.bar]
        force = size * cmath.rect(1.0, self.direction_rad) * (1.0 if self.inertial else u)
        difference, spin = difference.copy(), spin.copy()
        difference[k] = force / m.mass_kg[k]
        spin[k] = self.side * m.lever[k] * (np.conj(u) * force).imag
        return EffectAccelerations(0j, difference, spin)

    def interpolated_force_N(self, piece: int, t_s: float) -> float:
        """Force on a segment of the table, extrapolated beyond its ends; 0 outside the table."""
        if piece < 0:
            return 0.0
        (t0, t1), (f0, f1) = self.times_s[piece : piece + 2], self.force_N[piece : piece + 2]
        return float(f0 + (f1 - f0) * ((t_s - t0) / (t1 - t0)))

    def mode(self, at: EffectState) -> Array:
        """Segment just before an instant; at t = 0, just after."""
        return self.segment_at(at.t_s * (1.0 - SAME_INSTANT), "left" if at.t_s > 0.0 else "right")

    def segment_mode(self, start_s: float, end_s: float) -> Array:
        """Segment between two known instants."""
        return self.segment_at(0.5 * (start_s + end_s), "left")

    def segment_at(self, t_s: float, side: str) -> Array:
        """(1,) index of the segment that contains an instant."""
        after = int(np.searchsorted(self.times_s, t_s, side=side))  # type: ignore[call-overload]
        return np.array([after - 1.0 if after < len(self.times_s) else -1.0])
