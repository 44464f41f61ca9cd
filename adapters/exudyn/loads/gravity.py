"""Gravity and frame forces on a bar, in one form for Exudyn's symbolic numbers and for NumPy arrays.

In the rotating frame on a Kepler orbit (radius r, rate w, k = mu/r³), a bar at (x, y) has the acceleration

    2 w y' + w' y + k ((e cos f - c) x - c r),   -2 w x' - w' x + k (e cos f - c) y,

where c = (1+q)^(-3/2) - 1 with q = ((2r + x) x + y²)/r² is Encke's, and w² - k = k e cos f holds on Kepler's orbit. The
large terms (870 N a bar) cancel analytically. Exudyn evaluates a symbolic expression once for each occurrence, so `c`
occurs in as few places as possible, and `q` once in `c`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.exudyn.frames.numbers import Number

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.exudyn.frames.numbers import BarMotion, OrbitNumbers


@dataclass(frozen=True)
class LoadedBar:
    """Mass properties of a bar for its loads."""

    mass_kg: float
    inertia_kg_m2: float = 0.0
    gradient: bool = False
    """Whether the gravity-gradient torque of eq. (17) acts"""


Load = tuple[Number, Number, Number]
"""Force along x and y (N), torque (N m)"""


def orbit_load(bar: LoadedBar, orbit: OrbitNumbers, m: BarMotion, xp: Any) -> Load:
    """Gravity and the rotating frame's forces on a bar."""
    r, w, k = orbit.radius_m, orbit.rate_rad_s, orbit.pull_s2
    q = ((2.0 * r + m.x_m) * m.x_m + m.y_m * m.y_m) / (r * r)
    c, cube = encke(q, xp)
    ax = 2.0 * w * m.vy_m_s + orbit.spin_up_rad_s2 * m.y_m + k * (orbit.shape * m.x_m - c * (r + m.x_m))
    ay = -2.0 * w * m.vx_m_s - orbit.spin_up_rad_s2 * m.x_m + k * (orbit.shape - c) * m.y_m
    torque = -bar.inertia_kg_m2 * orbit.spin_up_rad_s2 + 0.0 * m.x_m  # the frame turns faster: the bar falls behind
    if bar.gradient:
        torque = torque + gradient_torque(3.0 * bar.inertia_kg_m2 * k / (r * r), r + m.x_m, m, (1.0 + q) * cube)
    return bar.mass_kg * ax, bar.mass_kg * ay, torque


def encke(q: Number, xp: Any) -> tuple[Number, Number]:
    """(1+q)^(-3/2) - 1 without cancellation, and (1+q)^(3/2).

    The symbolic form contains q once: with z = -(3/4) log(1+q), the first number is exp(2z) - 1 = 2/(coth(z) - 1), and
    log(1+q) = 2 artanh(1/(1 + 2/q)). Exudyn's numbers follow IEEE 754, so that q = 0 gives 0.
    """
    cube = (1.0 + q) * xp.sqrt(1.0 + q)
    if xp is np:
        return -1.0 * q * (3.0 + q * (3.0 + q)) / (cube * (1.0 + cube)), cube
    return 2.0 / (1.0 / xp.tanh(-1.5 * xp.atanh(1.0 / (1.0 + 2.0 / q))) - 1.0), cube


def absolute_load(bar: LoadedBar, mu_m3_s2: float, m: BarMotion, sqrt: Callable[[Number], Number]) -> Load:
    """Gravity on a bar in absolute coordinates."""
    r2 = m.x_m * m.x_m + m.y_m * m.y_m
    cube = r2 * sqrt(r2)
    pull = -mu_m3_s2 * bar.mass_kg / cube
    torque = 0.0 * m.x_m
    if bar.gradient:
        torque = gradient_torque(3.0 * bar.inertia_kg_m2 * mu_m3_s2, m.x_m, m, r2 * cube)
    return pull * m.x_m, pull * m.y_m, torque


def gradient_torque(strength: Number, across: Number, m: BarMotion, fifth: Number) -> Number:
    """Torque 3 mu J sin(phi) cos(phi)/rho³ by eq. (17) with its sign corrected: towards the radial direction.

    Parameters
    ----------
    strength : number
        3 mu J in the unit of `fifth`.
    across : number
        Radial component of the bar's position: its x from the centre of the body.
    m : BarMotion
    fifth : number
        rho⁵ in that unit.
    """
    sine = m.cosine * across + m.sine * m.y_m  # rho sin(phi)
    cosine = m.cosine * m.y_m - m.sine * across  # rho cos(phi)
    return strength * sine * cosine / fifth
