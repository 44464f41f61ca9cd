"""Motion about a point mass in closed form, any conic: universal variables and Stumpff functions.

With s the universal anomaly (ds = dt/r), beta = 2 mu/r0 - v0², eta = x0·v0 and G_k = s^k c_k(beta s²),

    t  = r0 G1 + eta G2 + mu G3          (increasing in s: its derivative is r)
    r  = r0 G0 + eta G1 + mu G2
    x  = x0 - (mu/r0) G2 x0 + (r0 G1 + eta G2) v0
    x' = -(mu/(r r0)) G1 x0 + (1 - (mu/r) G2) v0

No term is a difference of large numbers where eta >= 0, and x - x0 results without subtraction of x0.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from adapters.trajectory import Array

SERIES_BELOW = 2.0  # |z| up to which Stumpff functions are summed; beyond, x - sin x keeps all but 2 bits
SERIES_TERMS = 14  # 2^14/(2*14+2)! is far below round-off
MOST_ITERATIONS = 200  # bisection alone needs about 60 for the last bit; Newton takes 5 to 10
STEP_FLOOR = 4.0 * np.finfo(float).eps  # of the anomaly: a smaller last step is converged, whatever the residual
EXCESS_FLOOR = 4.0 * np.finfo(float).eps  # of Kepler's equation's terms: below it the residual is round-off


def propagate(mu_m3_s2: float, position_m: Array, velocity_m_s: Array, t_s: Array) -> tuple[Array, Array]:
    """Position and velocity at `t_s` of a particle from its state at t = 0.

    Parameters
    ----------
    mu_m3_s2 : float
        Positive.
    position_m, velocity_m_s : ndarray, shape (2,)
        State at t = 0; any conic. A radial orbit reflects at the centre.
    t_s : ndarray, shape (n,)
        Either sign.

    Returns
    -------
    position_m, velocity_m_s : ndarray, shape (n, 2)
    """
    moved, velocity = displacements(mu_m3_s2, position_m, velocity_m_s, t_s)
    return position_m + moved, velocity


def displacements(mu_m3_s2: float, position_m: Array, velocity_m_s: Array, t_s: Array) -> tuple[Array, Array]:
    """Displacement x - x0 (n, 2), accurate for short times, and velocity (n, 2); see :func:`propagate`."""
    r0 = math.hypot(*position_m)
    eta = float(position_m @ velocity_m_s)
    beta = 2.0 * mu_m3_s2 / r0 - float(velocity_m_s @ velocity_m_s)
    s = universal_anomaly(mu_m3_s2, r0, eta, beta, np.asarray(t_s, dtype=float))
    g0, g1, g2, _ = universal_functions(beta, s)
    r = (r0 * g0 + eta * g1 + mu_m3_s2 * g2)[:, None]
    g1, g2 = g1[:, None], g2[:, None]
    moved = -(mu_m3_s2 / r0) * g2 * position_m + (r0 * g1 + eta * g2) * velocity_m_s
    velocity = -(mu_m3_s2 / r0) * g1 / r * position_m + (1.0 - mu_m3_s2 * g2 / r) * velocity_m_s
    return moved, velocity


def universal_anomaly(mu_m3_s2: float, r0_m: float, eta_m2_s: float, beta_m2_s2: float, t_s: Array) -> Array:
    """Solve Kepler's equation for s, (n,) s/m, by Newton's method inside a shrinking bracket.

    Raises
    ------
    ArithmeticError
        If an anomaly has not converged.
    """
    if beta_m2_s2 > 0.0:
        rate = math.sqrt(beta_m2_s2)
        period = 2.0 * math.pi * mu_m3_s2 / rate**3
        t_s = t_s - period * np.round(t_s / period)
        bracket = np.full_like(t_s, 2.0 * math.pi / rate)  # half a period, and the phase that eta adds
        guess = t_s * beta_m2_s2 / mu_m3_s2
    else:
        bracket = open_bracket(mu_m3_s2, r0_m, eta_m2_s, beta_m2_s2, t_s)
        guess = np.copysign(bracket, t_s)
    low, high = -bracket, bracket
    s, step = np.clip(guess, low, high), bracket
    for _ in range(MOST_ITERATIONS):
        g0, g1, g2, g3 = universal_functions(beta_m2_s2, s)
        terms = np.stack([r0_m * g1, eta_m2_s * g2, mu_m3_s2 * g3, -t_s])
        excess = terms.sum(axis=0)
        unconverged = np.abs(excess) > EXCESS_FLOOR * np.abs(terms).sum(axis=0)
        if not unconverged.any():
            return s
        high, low = np.where(excess >= 0.0, s, high), np.where(excess <= 0.0, s, low)
        radius = r0_m * g0 + eta_m2_s * g1 + mu_m3_s2 * g2
        with np.errstate(divide="ignore", invalid="ignore"):
            newton = s - excess / radius
        # false for a NaN, at the centre of a radial orbit; and where Newton's steps are slow to shrink
        good = (newton >= low) & (newton <= high) & (np.abs(newton - s) <= 0.5 * step)
        after = np.where(unconverged, np.where(good, newton, 0.5 * (low + high)), s)
        s, step = after, np.abs(after - s)
    if (unconverged & (step > STEP_FLOOR * np.abs(s))).any():
        raise ArithmeticError(f"Kepler's equation has not converged after {MOST_ITERATIONS} iterations")
    return s


def open_bracket(mu_m3_s2: float, r0_m: float, eta_m2_s: float, beta_m2_s2: float, t_s: Array) -> Array:
    """Anomaly (n,) whose time exceeds `|t_s|` in both directions, on an unbound orbit."""
    target, rate = np.abs(t_s), math.sqrt(-beta_m2_s2)
    bracket = target / r0_m  # where eta = 0 each term alone stays below the time: r0 G1, here, and mu G3 >= mu s³/6
    bracket = bracket if rate == 0.0 else np.arcsinh(rate * bracket) / rate
    bracket = np.minimum(bracket, np.cbrt(6.0 * target / mu_m3_s2))
    while True:
        too_small = np.zeros(t_s.shape, dtype=bool)
        for sign in (-1.0, 1.0):
            _, g1, g2, g3 = universal_functions(beta_m2_s2, sign * bracket)
            too_small |= sign * (r0_m * g1 + eta_m2_s * g2 + mu_m3_s2 * g3) < target
        if not too_small.any():
            return bracket
        bracket = np.where(too_small, 1.5 * bracket, bracket)


def universal_functions(beta_m2_s2: float, s: Array) -> tuple[Array, Array, Array, Array]:
    """G_0 to G_3 at anomaly s, each (n,)."""
    z = beta_m2_s2 * s * s
    c2, c3 = stumpff(z)
    return 1.0 - z * c2, s * (1.0 - z * c3), s * s * c2, s * s * s * c3


def stumpff(z: Array) -> tuple[Array, Array]:
    """Stumpff's c2 and c3, (n,): (1 - cos √z)/z and (√z - sin √z)/√z³, continued to z <= 0."""
    near = np.abs(z) < SERIES_BELOW
    c2, c3 = stumpff_series(np.where(near, z, 0.0))
    elliptic, hyperbolic = z >= SERIES_BELOW, z <= -SERIES_BELOW
    x = np.sqrt(np.abs(z))
    b, f = x[elliptic], x[hyperbolic]
    c2[elliptic], c3[elliptic] = 2.0 * (np.sin(0.5 * b) / b) ** 2, (b - np.sin(b)) / b**3
    c2[hyperbolic], c3[hyperbolic] = 2.0 * (np.sinh(0.5 * f) / f) ** 2, (np.sinh(f) - f) / f**3
    return c2, c3


def stumpff_series(z: Array) -> tuple[Array, Array]:
    """Sums of (-z)^k/(2k+2)! and (-z)^k/(2k+3)! over k, for small z."""
    c2, c3 = np.zeros_like(z), np.zeros_like(z)
    for k in range(SERIES_TERMS - 1, -1, -1):  # Horner's scheme
        c2 = 1.0 / math.factorial(2 * k + 2) - z * c2
        c3 = 1.0 / math.factorial(2 * k + 3) - z * c3
    return c2, c3
