"""Joint reactions: a symmetric positive definite, block-tridiagonal system, solved by banded Cholesky in O(N).

It is the paper's A E^-1 W of eq. (23), in SI units and with the inertial angles for unknowns.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg.lapack import dpbsv

if TYPE_CHECKING:
    from reference_impl.chain import Array, ChainModel
    from reference_impl.plane import ComplexArray

BAND = 4  # a diagonal and three below it hold 2x2 blocks and their neighbours


def joint_matrix(model: ChainModel, across: ComplexArray) -> Array:
    """Lower band of the joint system, shape (4, 2(N-1)), 1/kg.

    Row i, column k holds the entry (k+i, k) of the matrix with blocks

    D_j = (1/m_j + 1/m_{j+1}) I + c_j n_j n_jᵀ + c_{j+1} n_{j+1} n_{j+1}ᵀ,
    U_j = -I/m_{j+1} + c_{j+1} n_{j+1} n_{j+1}ᵀ, c_j = l_j²/(4 J_j).

    Parameters
    ----------
    model : ChainModel
    across : ndarray of complex, shape (N,)
        Unit vectors n_j.
    """
    x, y = across.real, across.imag
    cx, w = model.compliance * x, model.inverse_mass
    xx, xy, yy = cx * x, cx * y, model.compliance * y * y
    band = np.zeros((BAND, 2 * (model.bars - 1)))
    neighbours = w[:-1] + w[1:]
    band[0, 0::2] = neighbours + xx[:-1] + xx[1:]
    band[0, 1::2] = neighbours + yy[:-1] + yy[1:]
    band[1, 0::2] = xy[:-1] + xy[1:]
    band[2, 0:-2:2] = xx[1:-1] - w[1:-1]
    band[3, 0:-2:2] = xy[1:-1]
    band[1, 1:-2:2] = xy[1:-1]
    band[2, 1:-2:2] = yy[1:-1] - w[1:-1]
    return band


def solve_joints(band: Array, right: Array) -> Array:
    """Solve the joint system for one or more right-hand sides.

    Parameters
    ----------
    band : ndarray, shape (4, 2(N-1))
        From :func:`joint_matrix`.
    right : ndarray, shape (2(N-1), k)

    Returns
    -------
    ndarray, shape (2(N-1), k)

    Raises
    ------
    numpy.linalg.LinAlgError
        If the matrix is not positive definite: masses or inertias so unequal that a joint is
        lost in round-off.
    """
    if not len(right):
        return right
    _, solution, status = dpbsv(band, right, lower=1)  # a third of the time that solveh_banded takes at N = 5
    if status != 0:
        raise np.linalg.LinAlgError("the joint system is not positive definite in double precision")
    found: Array = solution
    return found


def condition_number(band: Array) -> float:
    """Two-norm condition number of the joint system; 1 where there are no joints. O(N²): for diagnosis."""
    size = band.shape[1]
    if size == 0:
        return 1.0
    full = np.zeros((size, size))
    for i in range(min(BAND, size)):
        rows = np.arange(size - i)
        full[rows + i, rows] = full[rows, rows + i] = band[i, : size - i]
    return float(np.linalg.cond(full))
