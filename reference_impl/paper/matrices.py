"""Matrices E, F, W, A, B of the paper's appendices, entry by entry, with misprints corrected or kept.

Bars and joints count from 0. Bar j has rows and columns 3j, 3j+1, 3j+2 of X; the joint after bar j has components 2j,
2j+1 of the reactions.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.model.kinematics import cross
from reference_impl.paper.misprints import Misprint

if TYPE_CHECKING:
    from collections.abc import Set

    from reference_impl.model.arrays import Array
    from reference_impl.paper.state import PaperState

ROWS = 3  # of X for each bar: T_j1, T_j2, phi_j


@dataclass(frozen=True)
class Longitudes:
    """omega_j'' = alpha_j·T_j'' + beta_j·Y_0'' + gamma_j, eqs. (B.5), (B.6)."""

    alpha: Array
    """(N, 2)"""
    beta: Array
    """(N, 2)"""
    gamma: Array
    """(N,)"""

    def acceleration(self, T_acceleration: Array, Y0_acceleration: Array) -> Array:
        """omega_j'' (N,), eq. (B.5)."""
        total: Array = np.sum(self.alpha * T_acceleration, axis=-1) + self.beta @ Y0_acceleration + self.gamma
        return total


@dataclass(frozen=True)
class Matrices:
    """E X'' = E F + W R and A X'' = B, eqs. (18) and (21); NX = 3N+2, NR = 2N-2."""

    E: Array
    """(NX,) the diagonal"""
    F: Array
    """(NX,)"""
    W: Array
    """(NX, NR)"""
    A: Array
    """(NR, NX)"""
    B: Array
    """(NR,)"""
    longitudes: Longitudes


def matrices(x: PaperState, as_printed: Set[Misprint]) -> Matrices:
    """All matrices of a state."""
    half = np.full(x.bars, 0.5) if Misprint.HALF_LENGTH in as_printed else x.half
    turned = longitudes(x, as_printed)
    E = np.concatenate([np.stack([x.share, x.share, x.inertia], axis=-1).ravel(), [1.0, 1.0]])  # (B.2)
    A, B = compatibility(x, half, turned, as_printed)
    return Matrices(
        E,
        free_accelerations(x, turned, as_printed),
        reaction_columns(x, half, turned, as_printed),
        A,
        B,
        turned,
    )


def longitudes(x: PaperState, as_printed: Set[Misprint]) -> Longitudes:
    """Coefficients of (B.6)."""
    r2 = x.rho**2
    below = r2**2 if Misprint.BETA_DENOMINATOR in as_printed else r2
    beta = np.stack([-x.Y[:, 1], x.Y[:, 0]], axis=-1) / below[:, None]
    gamma = -2.0 * np.sum(x.Y * x.Y_rate, axis=-1) * cross(x.Y, x.Y_rate) / r2**2
    return Longitudes(x.ratio * beta, beta, gamma)


def tidal_sums(x: PaperState) -> Array:
    """chi_j, shape (N, 2): differences of gravity as sums over all pairs, eqs. (A.1)-(A.6)."""
    rho_j, rho_k = x.rho[:, None], x.rho[None, :]
    f = (rho_j**2 + rho_k**2 + rho_j * rho_k) / (rho_j**3 * rho_k**3 * (rho_j + rho_k))  # (A.2)
    square = np.sum(x.T**2, axis=-1)
    g = 2.0 * (x.T[None, :] - x.T[:, None]) @ x.Y0 + x.ratio * (square[None, :] - square[:, None])  # (A.5)
    sums: Array = (f * g) @ (x.share[:, None] * x.Y)  # (A.6)
    return sums


def free_accelerations(x: PaperState, turned: Longitudes, as_printed: Set[Misprint]) -> Array:
    """F of (B.3), (B.7) and (11): X'' without reactions."""
    q = -x.T / x.rho[:, None] ** 3 - tidal_sums(x)
    G0 = -(x.share / x.rho**3) @ x.Y
    sign = -1.0 if Misprint.TORQUE_SIGN in as_printed else 1.0
    torque = sign * 3.0 * np.sin(x.phi) * np.cos(x.phi) / x.rho**3
    turn = torque - turned.acceleration(q, G0)
    return np.concatenate([np.column_stack([q, turn]).ravel(), G0])


def reaction_columns(x: PaperState, half: Array, turned: Longitudes, as_printed: Set[Misprint]) -> Array:
    """W of appendix B, shape (NX, NR)."""
    W = np.zeros((ROWS * x.bars + 2, 2 * (x.bars - 1)))
    across = np.stack([-np.sin(x.theta), np.cos(x.theta)], axis=-1)
    share = 1.0 if Misprint.W_THIRD_ROW in as_printed else (x.inertia / x.share)[:, None]
    lever, longitude = half[:, None] * across, share * turned.alpha
    for j in range(x.bars):
        row, before, after = ROWS * j, slice(2 * j - 2, 2 * j), slice(2 * j, 2 * j + 2)
        if j > 0:
            W[row : row + 2, before] = -np.eye(2)
            W[row + 2, before] = lever[j] + longitude[j]
        if j < x.bars - 1:
            W[row : row + 2, after] = np.eye(2)
            W[row + 2, after] = lever[j] - longitude[j]
    return W


def compatibility(x: PaperState, half: Array, turned: Longitudes, as_printed: Set[Misprint]) -> tuple[Array, Array]:
    """A (NR, NX) and B (NR,) of (C.8) and (C.9)."""
    joints = x.bars - 1
    A, B = np.zeros((2 * joints, ROWS * x.bars + 2)), np.zeros((joints, 2))
    left, right = (
        end_accelerations(x, half, turned, -1.0, as_printed),
        end_accelerations(x, half, turned, 1.0, as_printed),
    )
    for j in range(joints):
        rows = slice(2 * j, 2 * j + 2)
        A[rows, ROWS * j : ROWS * (j + 1)] = -right.C[j]
        A[rows, ROWS * (j + 1) : ROWS * (j + 2)] = left.C[j + 1]
        A[rows, -2:] = left.T[j + 1] - right.T[j]
        printed = left.S[j + 1] - left.S[j]
        B[j] = printed if Misprint.B_INDICES in as_printed else right.S[j] - left.S[j + 1]
    return A, B.ravel()


@dataclass(frozen=True)
class EndAccelerations:
    """T_jk'' = C (T_j'', phi_j'') + T Y_0'' + S for one end k of every bar, eq. (C.2)."""

    C: Array
    """(N, 2, 3)"""
    T: Array
    """(N, 2, 2)"""
    S: Array
    """(N, 2)"""


def end_accelerations(
    x: PaperState, half: Array, turned: Longitudes, side: float, as_printed: Set[Misprint]
) -> EndAccelerations:
    """Coefficients (C.4) and (C.5) of the left (`side` = -1) or right (+1) ends."""
    along = side * half[:, None] * np.stack([np.cos(x.theta), np.sin(x.theta)], axis=-1)
    across = np.stack([-along[:, 1], along[:, 0]], axis=-1)
    C = np.zeros((x.bars, 2, ROWS))
    C[:, :, :2] = np.eye(2) + across[:, :, None] * turned.alpha[:, None, :]
    C[:, :, 2] = across
    lag = turned.gamma[:, None] * across
    if Misprint.S2_SIGN in as_printed:
        lag[:, 1] = -lag[:, 1]
    return EndAccelerations(C, across[:, :, None] * turned.beta[:, None, :], lag - (x.theta_rate**2)[:, None] * along)
