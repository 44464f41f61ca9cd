"""Kepler's orbit of a point injected horizontally, exactly, at any time: what the moving frame follows.

Universal variables serve the ellipse, the parabola, the hyperbola and the radial fall alike. Lengths
are in units of the initial radius r0, times in units of sqrt(r0³/mu); the start is an apsis, so that
with kappa = beta² - 1 (the eccentricity, negative when the start is the apogee) and alpha = 2 - beta²

    tau = chi + kappa (chi - s)/alpha,   r = 1 + kappa c,   x = 1 - c,   y = beta s,
    s = chi (1 - z S(z)),  c = chi² C(z),  z = alpha chi²   (C, S: Stumpff's functions).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from adapters.engine import Array, EngineError

SERIES_BELOW = 0.25  # |z| up to which Stumpff's series is better than the closed forms, which cancel
SERIES_TERMS = 9  # 0.25^9/21! is far below round-off
SWEEPS = 60  # Laguerre's iteration needs 3 to 6
CONVERGED = 4e-16  # relative: a unit or two in the last place


@dataclass(frozen=True)
class OrbitTrack:
    """The orbit at n instants, SI units, perifocal quantities already turned into usable ones."""

    radius_m: Array
    """(n,) r"""
    climb_m_s: Array
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
        chi = solve_kepler(tau, kappa, alpha)
        s, c, _ = universal(chi, alpha)
        with np.errstate(divide="ignore", invalid="ignore"):  # a radial fall reaches r = 0, below the surface
            r = 1.0 + kappa * c
            climb, rate = kappa * s / r, beta / r**2
            return OrbitTrack(
                radius_m=self.radius0_m * r,
                climb_m_s=self.radius0_m / unit_s * climb,
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

    Half a turn away from the start, round-off in y must not decide it.
    """
    angle = np.arctan2(y, x)
    wrong = (angle * tau < 0.0) & (np.abs(angle) > 1.0)
    unwrapped: Array = np.where(wrong, angle + 2.0 * math.pi * np.sign(tau), angle)
    return unwrapped


def universal(chi: Array, alpha: float) -> tuple[Array, Array, Array]:
    """s, c and (chi - s)/alpha of the universal anomaly, each (n,)."""
    z = alpha * chi**2
    small = np.abs(z) < SERIES_BELOW
    root = math.sqrt(abs(alpha)) if alpha else 1.0
    angle = np.where(small, 0.0, root * chi)
    sine, half = (np.sin, np.sin(0.5 * angle)) if alpha > 0.0 else (np.sinh, np.sinh(0.5 * angle))
    s_far, c_far = sine(angle) / root, 2.0 * half**2 / root**2
    stumpff_c, stumpff_s = stumpff_series(np.where(small, z, 0.0))
    excess_near = chi**3 * stumpff_s
    s = np.where(small, chi - alpha * excess_near, s_far)
    c = np.where(small, chi**2 * stumpff_c, c_far)
    excess = np.where(small, excess_near, (chi - s_far) / (alpha or 1.0))
    return s, c, excess


def stumpff_series(z: Array) -> tuple[Array, Array]:
    """C(z) = 1/2! - z/4! + ..., S(z) = 1/3! - z/5! + ..., each (n,), for small z."""
    c, s = np.zeros_like(z), np.zeros_like(z)
    for k in reversed(range(SERIES_TERMS)):
        c = 1.0 / math.factorial(2 * k + 2) - z * c
        s = 1.0 / math.factorial(2 * k + 3) - z * s
    return c, s


def solve_kepler(tau: Array, kappa: float, alpha: float) -> Array:
    """Universal anomaly chi(tau), (n,), by Laguerre's iteration of degree 5 (Conway 1986).

    Raises
    ------
    EngineError
        If it does not converge.
    """
    chi = tau / (1.0 + max(kappa, 0.0) * np.abs(tau) / (1.0 + np.abs(tau)))
    for _ in range(SWEEPS):
        s, c, excess = universal(chi, alpha)
        value, slope, bend = chi + kappa * excess - tau, 1.0 + kappa * c, kappa * s
        root = np.sqrt(np.abs(16.0 * slope**2 - 20.0 * value * bend))
        step = 5.0 * value / (slope + root)  # the slope is the radius, so never negative
        chi = chi - step
        if np.all(np.abs(step) <= CONVERGED * np.maximum(np.abs(chi), 1.0)):
            return chi
    if np.all(np.abs(step) <= 1e3 * CONVERGED * np.maximum(np.abs(chi), 1.0)):  # round-off juggles the last digits
        return chi
    raise EngineError("Kepler's equation of the moving frame did not converge")
