"""Force on a bar's end, piecewise linear in time."""

from __future__ import annotations

import cmath
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from reference_impl.effects.timed import TimedEffect
from reference_impl.model.effect import EffectAccelerations, EffectState

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array
    from reference_impl.model.effect import ChainProperties


@final
@dataclass(frozen=True)
class ThrustEffect(TimedEffect):
    """Thruster; its sizes are in N."""

    bar: int
    """Counted from 0"""
    side: float
    """beta of its bar: right end; -alpha: left end; with equal levers +1 and -1"""
    inertial: bool
    direction_rad: float

    name = "thrust"

    def largest_acceleration_m_s2(self, model: ChainProperties) -> float:
        """Largest force over the chain's mass."""
        return float(np.abs(self.sizes).max() / model.mass_kg.sum())

    def accelerations(self, at: EffectState, mode: Array | None) -> EffectAccelerations:
        """Force and torque on one bar."""
        size = self.size(at, mode)
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
