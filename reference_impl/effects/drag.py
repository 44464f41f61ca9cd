"""Free-molecular drag on flat bars in a rotating exponential atmosphere; see docs/effects/drag.md."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, final

import numpy as np

from reference_impl.model.complex_vectors import squared_norm
from reference_impl.model.effect import EDGE_ON, ChainEffect, EffectAccelerations, EffectState

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array
    from reference_impl.model.effect import Indices


class RelativeWind(NamedTuple):
    """Velocity of the bars relative to the air, (N,) each."""

    along: Array
    """u·W, m/s"""
    across: Array
    """n·W, m/s"""
    turning: Array
    """theta' - rotation, rad/s"""


@final
@dataclass(frozen=True)
class DragEffect(ChainEffect):
    """Drag; the mode is the face, +1 or -1, of each bar's centre towards the wind."""

    density_kg_m3: float
    """At `radius_m` from the centre of the body"""
    radius_m: float
    scale_height_m: float
    rotation_rad_s: float
    width_m: Array
    """(N,)"""
    normal_coefficient: float
    tangential_coefficient: float

    name = "drag"
    has_state_events = True

    def accelerations(self, at: EffectState, mode: Array | None) -> EffectAccelerations:
        """Force and torque, integrated over each bar."""
        m, wind = at.model, self.wind(at)
        face = np.sign(wind.across) if mode is None else mode
        r = np.sqrt(squared_norm(at.position_from_body))
        kappa = (at.unit.conj() * at.position_from_body).real / (r * self.scale_height_m)
        length = m.length_m
        second, fourth = length**3 / 12.0, length**5 / 80.0
        v, w = wind.across, wind.turning
        strength = -0.5 * self.width_m * self.density(at, r) * face
        normal = strength * self.normal_coefficient
        across = normal * (length * v * v + second * w * (w - 2.0 * kappa * v))
        along = strength * self.tangential_coefficient * wind.along * (length * v - kappa * second * w)
        torque = normal * (2.0 * second * v * w - kappa * (second * v * v + fourth * w * w))
        return EffectAccelerations(0j, (along + 1j * across) * at.unit * m.inverse_mass, torque / m.inertia_kg_m2)

    def wind(self, at: EffectState) -> RelativeWind:
        """Velocity of the bars relative to the air, in bar axes."""
        against = at.unit.conj() * (at.velocity - 1j * self.rotation_rad_s * at.position_from_body)
        return RelativeWind(against.real, against.imag, at.rate - self.rotation_rad_s)

    def density(self, at: EffectState, r_m: Array) -> Array:
        """(N,) density at the bars' centres, kg/m³; differences of height by (2 Z0 + d)·d/(r + r0)."""
        if at.absolute:
            thin: Array = self.density_kg_m3 * np.exp((self.radius_m - r_m) / self.scale_height_m)
            return thin
        z, d = at.com, at.position
        r0 = abs(z)
        twice = 2.0 * z + d
        higher = (twice.real * d.real + twice.imag * d.imag) / (r_m + r0)
        below = self.density_kg_m3 * np.exp((self.radius_m - r0) / self.scale_height_m)
        found: Array = below * np.exp(-higher / self.scale_height_m)
        return found

    def mode(self, at: EffectState) -> Array:
        """Faces towards the wind; an edge-on bar gets its left face."""
        return np.where(self.wind(at).across < 0.0, -1.0, 1.0)

    def event_functions(self, at: EffectState, mode: Array) -> Array:
        """(N,) sines of the angles between faces and wind, plus `EDGE_ON`."""
        wind = self.wind(at)
        found: Array = mode * wind.across / np.hypot(wind.along, wind.across) + EDGE_ON
        return found

    def mode_after(self, mode: Array, crossed: Indices) -> Array:
        """Faces with those at the indices `crossed` reversed."""
        turned = mode.copy()
        turned[crossed] *= -1.0
        return turned
