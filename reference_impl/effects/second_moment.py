"""Torque and force on a bar's second moment in the field of a distant mass."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reference_impl.model.complex_vectors import squared_norm

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array, ComplexArray


def angular_accelerations(mu_m3_s2: float, from_mass_m: ComplexArray, along: ComplexArray) -> Array:
    """Torque over moment of inertia, 3 mu (u·Z)(n·Z)/|Z|⁵, (N,) rad/s²; Z counts from the mass."""
    r2 = squared_norm(from_mass_m)
    seen = along.conj() * from_mass_m  # u·Z + i n·Z
    spin: Array = 3.0 * mu_m3_s2 * seen.real * seen.imag / (r2 * r2 * np.sqrt(r2))
    return spin


def accelerations(mu_m3_s2: float, from_mass_m: ComplexArray, along: ComplexArray, gyration2_m2: Array) -> ComplexArray:
    """Acceleration beyond a point mass's, (3 mu J/2m|Z|⁵) (2 (u·Z) u + Z - 5 c² Z), (N,) m/s², for given J/m."""
    r2 = squared_norm(from_mass_m)
    up = (along.conj() * from_mass_m).real
    strength = 1.5 * mu_m3_s2 * gyration2_m2 / (r2 * r2 * np.sqrt(r2))
    pull: ComplexArray = strength * (2.0 * up * along + (1.0 - 5.0 * up * up / r2) * from_mass_m)
    return pull


def potential_energies(mu_m3_s2: float, from_mass_m: ComplexArray, along: ComplexArray, inertia_kg_m2: Array) -> Array:
    """Potential energy beyond a point mass's, -(mu J/2|Z|³)(3c² - 1), (..., N) J."""
    r2 = squared_norm(from_mass_m)
    up = (along.conj() * from_mass_m).real
    energy: Array = -0.5 * mu_m3_s2 * inertia_kg_m2 / (r2 * np.sqrt(r2)) * (3.0 * up * up / r2 - 1.0)
    return energy
