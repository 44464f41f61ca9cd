"""The joint system of eq. (23) in any arithmetic: block elimination, symmetric and positive definite, O(N).

The same matrix as in :mod:`reference_impl.joints`, whose banded solver knows double precision only.
"""

from __future__ import annotations

import numpy as np

from reference_impl.precision.arithmetic import Values
from reference_impl.precision.chain import Bars


def blocks(bars: Bars, across: Values) -> tuple[Values, Values]:
    """Diagonal blocks D, shape (2, 2, N-1, B), and those beside them U, shape (2, 2, N-2, B), 1/kg.

    Parameters
    ----------
    bars : Bars
    across : ndarray, shape (2, N, B)
        Unit vectors n_j.
    """
    outer = bars.compliance * across[:, None] * across[None, :]
    unit = np.eye(2)[:, :, None, None]
    if outer.dtype != object:
        unit = unit.astype(outer.dtype)
    heavy = unit * bars.inverse_mass
    return (heavy + outer)[:, :, :-1] + (heavy + outer)[:, :, 1:], (outer - heavy)[:, :, 1:-1]


def solve(bars: Bars, across: Values, right: Values) -> Values:
    """Reactions (2, N-1, B) for right-hand sides (2, N-1, B)."""
    diagonal, beside = blocks(bars, across)
    joints = right.shape[1]
    rows = np.concatenate([diagonal, right[:, None]], axis=1)  # [D_j | b_j], reduced from joint to joint
    rows = [rows[:, :, j] for j in range(joints)]
    sides = [beside[:, :, j] for j in range(joints - 1)]
    for j, side in enumerate(sides):
        carried = halved(rows[j], np.concatenate([side, rows[j][:, 2:]], axis=1))
        rows[j + 1] = rows[j + 1] - (side[:, :1] * carried[:1] + side[:, 1:] * carried[1:])
    found = [halved(rows[-1], rows[-1][:, 2])]
    for row, side in zip(rows[-2::-1], sides[::-1], strict=True):
        found.append(halved(row, row[:, 2] - (side[:, 0] * found[-1][0] + side[:, 1] * found[-1][1])))
    return np.stack(found[::-1], axis=1)


def halved(row: Values, right: Values) -> Values:
    """Solve one symmetric 2x2 block, the first two columns of `row`, by its L D Lᵀ; `right` is (2, …, B).

    A determinant would lose what cancels in it; this is as stable as Cholesky.
    """
    factor = row[0, 1] / row[0, 0]
    second = (right[1] - factor * right[0]) / (row[1, 1] - factor * row[0, 1])
    return np.stack([right[0] / row[0, 0] - factor * second, second])
