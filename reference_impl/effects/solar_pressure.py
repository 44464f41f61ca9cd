"""Solar radiation pressure on flat bars, with the central body's shadow; see docs/effects/solar_pressure.md."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from reference_impl.model.effect import EDGE_ON, ChainEffect, EffectAccelerations, EffectState

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array
    from reference_impl.model.effect import Indices


@final
@dataclass(frozen=True)
class SolarPressureEffect(ChainEffect):
    """Solar radiation pressure; the mode is 1 in light or 0 in shadow, then each bar's face to the Sun, +1 or -1."""

    pressure_Pa: float
    longitude_rad: float
    """Direction to the Sun at t = 0"""
    rate_rad_s: float
    width_m: Array
    """(N,)"""
    reflectivity: float
    shadow_radius_m: float
    """0: no shadow"""

    name = "solar_pressure"
    has_state_events = True
    has_short_modes = True

    def sun_direction(self, t_s: float) -> complex:
        """Unit vector to the Sun."""
        direction: complex = np.exp(1j * (self.longitude_rad + self.rate_rad_s * t_s))
        return direction

    def accelerations(self, at: EffectState, mode: Array | None) -> EffectAccelerations:
        """Force; uniform light exerts no torque on a bar."""
        held = self.mode(at) if mode is None else mode
        s, m, lit, face = self.sun_direction(at.t_s), at.model, held[..., :1], held[..., 1:]
        k = lit * face * (at.unit.conj() * s).imag
        strength = -self.pressure_Pa * self.width_m * m.length_m * m.inverse_mass * k
        mirror = 2.0 * self.reflectivity * k * face
        return EffectAccelerations(
            0j, strength * ((1.0 - self.reflectivity) * s + mirror * 1j * at.unit), at.zero_angular
        )

    def shadow_clearance_m(self, at: EffectState) -> Array | float:
        """Distance of the centre of mass from the shadow, m, negative inside; height on the day side."""
        if not self.shadow_radius_m:
            return 1.0
        seen = self.sun_direction(at.t_s).conjugate() * at.com
        aside: Array = np.where(seen.real < 0.0, abs(seen.imag), abs(seen))
        return aside - self.shadow_radius_m

    def mode(self, at: EffectState) -> Array:
        """Light and faces; an edge-on bar gets its left face."""
        across = (at.unit.conj() * self.sun_direction(at.t_s)).imag
        face = np.where(across < 0.0, -1.0, 1.0)
        lit = np.where(self.shadow_clearance_m(at) >= 0.0, 1.0, 0.0) * np.ones_like(face[..., :1])
        return np.concatenate([lit, face], axis=-1)

    def event_functions(self, at: EffectState, mode: Array) -> Array:
        """(1 + N,) distance from the shadow's edge, m, and sines of the angles between the Sun and each face."""
        across = (at.unit.conj() * self.sun_direction(at.t_s)).imag
        return np.concatenate([[(2.0 * mode[0] - 1.0) * self.shadow_clearance_m(at)], mode[1:] * across + EDGE_ON])

    def short_mode_indicator(self, at: EffectState) -> float:
        """Distance from the shadow's axis, m: far out, one step may cross the whole shadow."""
        seen = self.sun_direction(at.t_s).conjugate() * at.com
        return seen.imag if self.shadow_radius_m and seen.real < 0.0 else 0.0

    def mode_after(self, mode: Array, crossed: Indices) -> Array:
        """Light and shadow exchanged, faces reversed."""
        turned = mode.copy()
        turned[crossed] *= -1.0
        turned[0] = abs(turned[0] + 1.0) if 0 in crossed else mode[0]
        return turned
