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
SMALLEST = np.nextafter(0.0, 1.0)


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
        size = self.interpolated_force_N(self.mode(at) if mode is None else mode, at.t_s)
        difference, spin = at.zero_acceleration, at.zero_angular
        if not size.any():
            return EffectAccelerations(0j, difference, spin)
        m, own = at.model, slice(self.bar, self.bar + 1)
        u = at.unit[..., own]
        force = size * (cmath.rect(1.0, self.direction_rad) * (1.0 if self.inertial else u))
        difference, spin = difference.copy(), spin.copy()
        difference[..., own] = force / m.mass_kg[own]
        spin[..., own] = self.side * m.lever[own] * (np.conj(u) * force).imag
        return EffectAccelerations(0j, difference, spin)

    def interpolated_force_N(self, piece: Array, t_s: float) -> Array:
        """Force on segments of the table, extrapolated beyond their ends; 0 outside the table."""
        k = piece.astype(int)
        t0, f0, t1, f1 = self.times_s[k], self.force_N[k], self.times_s[k + 1], self.force_N[k + 1]
        found: Array = np.where(k < 0, 0.0, f0 + (f1 - f0) * ((t_s - t0) / (t1 - t0)))
        return found

    def mode(self, at: EffectState) -> Array:
        """Segment just before an instant; at t = 0, just after."""
        return self.segment_at(np.maximum(at.t_s * (1.0 - SAME_INSTANT), SMALLEST))

    def segment_mode(self, start_s: float, end_s: float) -> Array:
        """Segment between two known instants."""
        return self.segment_at(0.5 * (start_s + end_s))

    def segment_at(self, t_s: float) -> Array:
        """(1,) index of the segment that contains an instant; of instants (k, 1) as many."""
        after = np.searchsorted(self.times_s, np.atleast_1d(t_s))
        found: Array = np.where(after < len(self.times_s), after - 1.0, -1.0)
        return found
