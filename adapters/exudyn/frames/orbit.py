"""Kepler's orbit of a point injected horizontally, in polar coordinates for a frame that rotates with it.

The closed form of :mod:`adapters.common.kepler`, with lengths in units of the initial radius r0, times in units of
sqrt(r0³/mu), and an apsis at the start. With kappa = beta² - 1 (the eccentricity, negative for a start at the apogee)
and alpha = 2 - beta², the universal functions s = G1 and c = G2 of alpha give

    r = 1 + kappa c,   x = 1 - c,   y = beta s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.kepler import universal_anomaly, universal_functions

if TYPE_CHECKING:
    from adapters.trajectory import Array


@dataclass(frozen=True)
class OrbitTrack:
    """The orbit at n instants in SI units, in polar coordinates."""

    radius_m: Array
    """(n,) r"""
    radial_velocity_m_s: Array
    """(n,) r'"""
    longitude_rad: Array
    """(n,) unwrapped"""
    rate_rad_s: Array
    """(n,) omega, rate of the longitude"""
    spin_up_rad_s2: Array
    """(n,) omega' = -2 r' omega/r"""
    pull_s2: Array
    """(n,) mu/r³, 1/s²"""
    shape: Array
    """(n,) e cos f = omega² r³/mu - 1, without the cancellation"""


@dataclass(frozen=True)
class KeplerOrbit:
    """Orbit with its apsis at t = 0."""

    mu_m3_s2: float
    radius0_m: float
    speed_factor: float
    longitude0_rad: float

    @property
    def circular(self) -> bool:
        """Whether every number but the longitude is constant."""
        return self.speed_factor == 1.0

    def at(self, t_s: Array) -> OrbitTrack:
        """Orbit at the instants `t_s`, (n,)."""
        unit_s = math.sqrt(self.radius0_m**3 / self.mu_m3_s2)
        beta, kappa, alpha = self._numbers()
        tau = np.asarray(t_s, dtype=float) / unit_s
        turns = np.zeros_like(tau)
        if alpha > 0.0:
            period = 2.0 * math.pi / alpha**1.5
            turns = np.round(tau / period)
            tau = tau - turns * period
        _, s, c, _ = universal_functions(alpha, universal_anomaly(1.0, 1.0, 0.0, alpha, tau))
        with np.errstate(divide="ignore", invalid="ignore"):  # a radial fall reaches r = 0, below the surface
            r = 1.0 + kappa * c
            climb, rate = kappa * s / r, beta / r**2
            return OrbitTrack(
                radius_m=self.radius0_m * r,
                radial_velocity_m_s=self.radius0_m / unit_s * climb,
                longitude_rad=self.longitude0_rad + 2.0 * math.pi * turns + anomaly(beta * s, 1.0 - c, tau),
                rate_rad_s=rate / unit_s,
                spin_up_rad_s2=-2.0 * climb * rate / r / unit_s**2,
                pull_s2=1.0 / (r**3 * unit_s**2),
                shape=kappa * (1.0 - c) / r,
            )

    def _numbers(self) -> tuple[float, float, float]:
        """beta, kappa, alpha; (beta-1)(beta+1) keeps the digits of a nearly circular orbit."""
        beta = self.speed_factor
        kappa = (beta - 1.0) * (beta + 1.0)
        return beta, kappa, 1.0 - kappa


def anomaly(y: Array, x: Array, tau: Array) -> Array:
    """Angle of (x, y) from the apsis, with the sign of `tau`.

    Half a revolution after the start, round-off in y must not decide the sign.
    """
    angle = np.arctan2(y, x)
    wrong = (angle * tau < 0.0) & (np.abs(angle) > 1.0)
    unwrapped: Array = np.where(wrong, angle + 2.0 * math.pi * np.sign(tau), angle)
    return unwrapped
