"""Torque and force on a bar's second moment in the field of a distant mass."""

from __future__ import annotations

import math

from reference_impl.machine_code.functions import inlined


@inlined
def angular_acceleration(mu_m3_s2: float, x: float, y: float, ux: float, uy: float) -> float:
    """Torque over moment of inertia, 3 mu (u·Z)(n·Z)/|Z|⁵, rad/s²; Z counts from the mass."""
    r2 = x * x + y * y
    return 3.0 * mu_m3_s2 * (ux * x + uy * y) * (ux * y - uy * x) / (r2 * r2 * math.sqrt(r2))


@inlined
def acceleration(mu_m3_s2: float, x: float, y: float, ux: float, uy: float, gyration2: float) -> tuple[float, float]:
    """Acceleration beyond a point mass's, (3 mu J/2m|Z|⁵) (2 (u·Z) u + Z - 5 c² Z), m/s², for given J/m."""
    inverse2 = 1.0 / (x * x + y * y)
    up = ux * x + uy * y
    strength = 1.5 * mu_m3_s2 * gyration2 * inverse2 * inverse2 * math.sqrt(inverse2)
    flat = 1.0 - 5.0 * up * up * inverse2
    return strength * (2.0 * up * ux + flat * x), strength * (2.0 * up * uy + flat * y)
