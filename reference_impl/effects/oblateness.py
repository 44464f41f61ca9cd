"""J2 of the central body in its equatorial plane: U = -B/r³ per unit mass, B = mu J2 R²/2."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from reference_impl.effects.quadrupole import bar_positions
from reference_impl.model.complex_vectors import as_complex, squared_norm, unit_along
from reference_impl.model.effect import ChainEffect, EffectAccelerations, EffectState

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array, ComplexArray
    from reference_impl.model.effect import ChainProperties


@final
@dataclass(frozen=True)
class OblatenessEffect(ChainEffect):
    """J2 term of the central body's field."""

    strength_m5_s2: float
    """B"""
    turns: bool
    """Whether the field's gradient exerts a torque on the bars"""
    second_moment: bool
    """Whether to include the force on the bars' second moments"""

    name = "oblateness"

    @property
    def central(self) -> bool:  # type: ignore[override]
        """False with the force on second moments, which is not central."""
        return not self.second_moment

    @property
    def potential(self) -> bool:  # type: ignore[override]
        """True if torque and force on second moments occur together, or neither."""
        return self.turns == self.second_moment

    @property
    def isotropic(self) -> bool:  # type: ignore[override]
        """As the potential: a torque without its force belongs to no central field."""
        return self.potential

    def accelerations(self, at: EffectState, mode: Array | None) -> EffectAccelerations:
        """-3B Z/r⁵, with torque and force on second moments of a central field of fifth power."""
        del mode
        common, difference = self.field(at)
        if not self.turns:
            return EffectAccelerations(common, difference, at.zero_angular)
        r2 = squared_norm(at.position_from_body)
        seen = at.unit.conj() * at.position_from_body
        seventh = r2 * r2 * r2 * np.sqrt(r2)
        spin = 15.0 * self.strength_m5_s2 * seen.real * seen.imag / seventh
        if self.second_moment:
            share = 7.5 * self.strength_m5_s2 * at.model.gyration2 / seventh
            flat = (1.0 - 7.0 * seen.real * seen.real / r2) * at.position_from_body
            difference = difference + share * (2.0 * seen.real * at.unit + flat)
        return EffectAccelerations(common, difference, spin)

    def field(self, at: EffectState) -> tuple[complex, ComplexArray]:
        """Acceleration of the centre of mass and each bar's difference, by Encke's change of the fifth power."""
        if at.absolute:
            r2 = squared_norm(at.position_from_body)
            return 0j, -3.0 * self.strength_m5_s2 / (r2 * r2 * np.sqrt(r2)) * at.position_from_body
        z, d = at.com, at.position
        distance = abs(z)
        strength = -3.0 * self.strength_m5_s2 / distance**5
        twice = 2.0 * z + d
        change = np.expm1(-2.5 * np.log1p((twice.real * d.real + twice.imag * d.imag) / distance**2))
        return strength * z, strength * (d * (1.0 + change) + z * change)

    def energy(self, model: ChainProperties, com_m: Array, angle_rad: Array) -> Array:
        """Potential energy, (n,) J.

        Of the bars' energy minus that of the whole mass at the centre of mass, the part linear in d sums to zero, eq.
        (6). The rest of (1 + q)^(-3/2) - 1 beyond -3q/2 is (s - 1)² (3s³/2 + 3s² + 2s + 1)/s³ with s = sqrt(1 + q).
        """
        z, d = as_complex(com_m)[:, None], bar_positions(model, angle_rad)
        r2 = squared_norm(z)
        twice = 2.0 * z + d
        q = (twice.real * d.real + twice.imag * d.imag) / r2
        s = np.sqrt(1.0 + q)
        curved = (q / (1.0 + s)) ** 2 * (1.5 * s**3 + 3.0 * s**2 + 2.0 * s + 1.0) / s**3 - 1.5 * squared_norm(d) / r2
        bars = (1.0 + curved) * model.mass_kg
        if self.second_moment:
            place, unit = z + d, unit_along(angle_rad)
            c2 = ((unit.conj() * place).real ** 2) / squared_norm(place)
            bars = bars - 1.5 * model.inertia_kg_m2 / squared_norm(place) * (1.0 - 5.0 * c2) * s**-3
        total: Array = (-self.strength_m5_s2 / (r2 * np.sqrt(r2)) * bars).sum(axis=1)
        return total
