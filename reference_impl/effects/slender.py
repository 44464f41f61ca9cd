"""Exact gravity on a uniform slender bar, in closed form and free of cancellation for short bars.

The effect adds only the difference from gravity on a point mass. Its factors B and C, of order (l/2r)², are sums of
small terms. See docs/effects/gravity.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, final

import numpy as np

from reference_impl.effects.quadrupole import bar_positions
from reference_impl.model.complex_vectors import as_complex, squared_norm, unit_along
from reference_impl.model.effect import ChainEffect, EffectAccelerations, EffectState

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array, ComplexArray
    from reference_impl.model.effect import ChainProperties

SERIES_BELOW = 0.1  # argument of artanh; below, ten terms of the series reach the last digit
SERIES_TERMS = 10


class EndDistances(NamedTuple):
    """Distances a and b of a bar's ends from the centre, with a b = r² (1 + delta) and a + b = 2r (1 + stretch)."""

    delta: Array
    stretch: Array
    tau: Array
    """((a + b)² - l²)/4r² - 1"""


@final
@dataclass(frozen=True)
class SlenderBarEffect(ChainEffect):
    """Exact gravity on a uniform bar minus that on a point mass; the model's gravity is "point"."""

    name = "slender"
    potential = True
    isotropic = True

    def accelerations(self, at: EffectState, mode: Array | None) -> EffectAccelerations:
        """Force and torque."""
        del mode
        m = at.model
        r2 = squared_norm(at.position_from_body)
        seen = at.unit.conj() * at.position_from_body  # p + i q
        s = end_distances(m.half_m**2 / r2, seen.real**2 / r2)
        whole = s.delta + (1.0 + s.delta) * s.stretch
        radial = whole / (1.0 + whole)
        across = (s.tau + s.delta + s.tau * s.delta - s.stretch) / ((1.0 + s.tau) * (1.0 + s.delta))
        strength = m.mu_m3_s2 / (r2 * np.sqrt(r2))
        pull = strength * (seen.real * radial + 1j * (seen.imag * across)) * at.unit
        turn = 3.0 * strength / r2 * seen.real * seen.imag
        return EffectAccelerations(0j, pull, turn / ((1.0 + s.delta) * (1.0 + s.stretch) * (1.0 + s.tau)))

    def energy(self, model: ChainProperties, com_m: Array, angle_rad: Array) -> Array:
        """Potential energy beyond that of point masses, -(mu m/r)((2r/l) artanh(l/(a+b)) - 1), (n,) J."""
        place = as_complex(com_m)[:, None] + bar_positions(model, angle_rad)
        return potential_energies(model, place, unit_along(angle_rad)).sum(axis=1)  # type: ignore[no-any-return]


def end_distances(e: Array, c2: Array) -> EndDistances:
    """Relative end distances of a bar from e = (l/2r)² and c² = (u·Z/r)²."""
    x = 2.0 * e * (1.0 - 2.0 * c2) + e * e
    delta = x / (1.0 + np.sqrt(1.0 + x))
    sigma = 0.5 * (e + delta)
    return EndDistances(delta, sigma / (1.0 + np.sqrt(1.0 + sigma)), 0.5 * (delta - e))


def potential_energies(model: ChainProperties, place: ComplexArray, unit: ComplexArray) -> Array:
    """(..., N) J; with k = l/(a + b), (2r/l) artanh k - 1 = (artanh k/k - 1 - stretch)/(1 + stretch)."""
    r2 = squared_norm(place)
    e = model.half_m**2 / r2
    s = end_distances(e, (unit.conj() * place).real ** 2 / r2)
    k = np.sqrt(e) / (1.0 + s.stretch)
    energy: Array = -model.mu_m3_s2 * model.mass_kg / np.sqrt(r2) * (artanh_excess(k) - s.stretch) / (1.0 + s.stretch)
    return energy


def artanh_excess(k: Array) -> Array:
    """artanh(k)/k - 1 for 0 <= k < 1, by its series k²/3 + k⁴/5 + ... for small k."""
    small = np.where(k < SERIES_BELOW, k, 0.0) ** 2
    series = np.zeros_like(k)
    for i in range(SERIES_TERMS, 0, -1):
        series = small * (1.0 / (2 * i + 1) + series)
    large = np.where(k < SERIES_BELOW, 0.5, k)
    return np.where(k < SERIES_BELOW, series, np.arctanh(large) / large - 1.0)
