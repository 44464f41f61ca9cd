"""Joint system of eq. (23) in any arithmetic: block elimination, symmetric and positive definite, O(N).

The matrix equals that of :mod:`reference_impl.model.joints`, whose banded solver supports double precision only.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from reference_impl.precision.arithmetic import Values
    from reference_impl.precision.chain import ChainParameters


def blocks(bars: ChainParameters, across: Values) -> tuple[Values, Values]:
    """Diagonal blocks D, shape (2, 2, N-1, B), and off-diagonal blocks U, shape (2, 2, N-2, B), 1/kg.

    Parameters
    ----------
    bars : ChainParameters
    across : ndarray, shape (2, N, B)
        Unit vectors n_j.
    """
    outer = bars.compliance * across[:, None] * across[None, :]
    unit = np.eye(2)[:, :, None, None]
    if outer.dtype != object:
        unit = unit.astype(outer.dtype)
    heavy = unit * bars.inverse_mass
    return (heavy + outer)[:, :, :-1] + (heavy + outer)[:, :, 1:], (outer - heavy)[:, :, 1:-1]


def solve(bars: ChainParameters, across: Values, right: Values) -> Values:
    """Reactions (2, N-1, B) for right-hand sides (2, N-1, B); none of a single bar."""
    if not right.size:
        return right
    diagonal, beside = blocks(bars, across)
    joints = right.shape[1]
    rows = np.moveaxis(
        np.concatenate([diagonal, right[:, None]], axis=1), 2, 0
    ).copy()  # [D_j | b_j], before elimination
    sides = np.moveaxis(
        np.concatenate([beside, right[:, None, :-1]], axis=1), 2, 0
    ).copy()  # [U_j | eliminated right-hand side]
    for j in range(joints - 1):
        sides[j, :, 2] = rows[j, :, 2]
        carried = solve_block(rows[j], sides[j])
        rows[j + 1] -= sides[j, :, :1] * carried[:1] + sides[j, :, 1:2] * carried[1:]
    found = np.empty_like(right)
    found[:, -1] = solve_block(rows[-1], rows[-1, :, 2])
    for j in range(joints - 2, -1, -1):
        side, after = sides[j], found[:, j + 1]
        found[:, j] = solve_block(rows[j], rows[j, :, 2] - (side[:, 0] * after[0] + side[:, 1] * after[1]))
    return found


def solve_block(row: Values, right: Values) -> Values:
    """Solution of one symmetric 2x2 block, the first two columns of `row`, by its L D Lᵀ; `right` is (2, …, B).

    A determinant would lose digits by cancellation. The factorisation is as stable as Cholesky's.
    """
    factor, found = row[0, 1] / row[0, 0], np.empty_like(right)
    found[1] = (right[1] - factor * right[0]) / (row[1, 1] - factor * row[0, 1])
    found[0] = right[0] / row[0, 0] - factor * found[1]
    return found
