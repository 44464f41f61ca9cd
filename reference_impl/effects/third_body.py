"""Third body (Moon or Sun) on a circular orbit about the central body: tides by Encke's method for both differences."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from reference_impl.effects import second_moment
from reference_impl.model.complex_vectors import squared_norm
from reference_impl.model.effect import ChainEffect, EffectAccelerations, EffectState
from reference_impl.model.gravity import complex_field_differences

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array, ComplexArray


@final
@dataclass(frozen=True)
class ThirdBodyEffect(ChainEffect):
    """Point mass on a circular orbit."""

    mu_m3_s2: float
    distance_m: float
    longitude_rad: float
    rate_rad_s: float
    turns: bool
    """Whether the body's gradient exerts a torque on the bars"""
    second_moment: bool
    """Whether to include the force on the bars' second moments"""

    name = "third_body"

    def body_position(self, t_s: float) -> complex:
        """Position of the third body from the centre, m."""
        place: complex = self.distance_m * np.exp(1j * (self.longitude_rad + self.rate_rad_s * t_s))
        return place

    def accelerations(self, at: EffectState, mode: Array | None) -> EffectAccelerations:
        """Attraction minus that on the central body, with the gradient torque and the force on second moments."""
        del mode
        body = self.body_position(at.t_s)
        if at.absolute:
            common, difference = 0j, self.tide(body, at.position_from_body)
        else:
            common = self.tide(body, np.asarray(at.com))  # type: ignore[assignment]  # a scalar of NumPy
            difference = complex_field_differences(self.mu_m3_s2, np.asarray(at.com - body), at.position)
        spin = at.zero_angular
        if self.turns:
            spin = second_moment.angular_accelerations(self.mu_m3_s2, at.position_from_body - body, at.unit)
        if self.second_moment:
            moments = second_moment.accelerations(
                self.mu_m3_s2, at.position_from_body - body, at.unit, at.model.gyration2
            )
            difference = difference + moments
        return EffectAccelerations(common, difference, spin)

    def tide(self, body: complex, place: ComplexArray) -> ComplexArray:
        """Acceleration at `place` minus that of the central body: (mu/D³)(X ((1+q)^(-3/2) - 1) - Z (1+q)^(-3/2))."""
        d2 = self.distance_m**2
        q = (squared_norm(place) - 2.0 * (body.real * place.real + body.imag * place.imag)) / d2
        change = np.expm1(-1.5 * np.log1p(q))
        tide: ComplexArray = self.mu_m3_s2 / (d2 * self.distance_m) * (body * change - place * (1.0 + change))
        return tide
