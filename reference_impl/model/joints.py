"""Joint reactions: a symmetric positive definite, block-tridiagonal system, solved in O(N) to the last digits.

Banded Cholesky solves the system; iterative refinement restores the digits lost in the factorisation. The system is the
paper's A E^-1 W of eq. (23), in SI units and with inertial angles as unknowns.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg.lapack import dpbtrf, dpbtrs

from reference_impl.model.kinematics import by_levers

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array, ComplexArray
    from reference_impl.model.chain import ChainModel

BANDWIDTH = 4  # a diagonal and three below it hold 2x2 blocks and their neighbours
REFINEMENTS = 5  # at most; one is enough up to condition numbers of 1e8
CONVERGED = 1e-10  # last correction over the reactions, after which refinement ends
DIVERGED = 1e-6  # last correction over the reactions, above which refinement has failed
ROUNDING = 2.0**-51  # pivot over its terms; a pivot not above this may have either sign
NOT_POSITIVE_DEFINITE = (
    "the joint system is not positive definite in double precision: its bars are too unequal, too compact or too many"
)


def joint_matrix(model: ChainModel, across: ComplexArray) -> Array:
    """Lower diagonals of the joint system, shape (4, 2(N-1)), 1/kg.

    Row i, column k holds the entry (k+i, k) of the matrix with blocks

    D_j = (1/m_j + 1/m_{j+1}) I + beta_j² c_j n_j n_jᵀ + alpha_{j+1}² c_{j+1} n_{j+1} n_{j+1}ᵀ,
    U_j = -I/m_{j+1} + alpha_{j+1} beta_{j+1} c_{j+1} n_{j+1} n_{j+1}ᵀ, c_j = l_j²/(4 J_j).

    Parameters
    ----------
    model : ChainModel
    across : ndarray of complex, shape (N,)
        Unit vectors n_j.
    """
    x, y = across.real, across.imag
    cx, w = model.compliance * x, model.inverse_mass
    turned = np.array([cx * x, cx * y, model.compliance * y * y])
    alpha, beta = model.left_share, model.right_share
    right, left = beta[:-1] ** 2 * turned[:, :-1], alpha[1:] ** 2 * turned[:, 1:]  # ends of a joint's two bars
    xx, xy, yy = (alpha * beta)[1:-1] * turned[:, 1:-1]
    lower = np.zeros((BANDWIDTH, 2 * (model.bars - 1)))
    neighbours = w[:-1] + w[1:]
    lower[0, 0::2] = neighbours + right[0] + left[0]
    lower[0, 1::2] = neighbours + right[2] + left[2]
    lower[1, 0::2] = right[1] + left[1]
    lower[2, 0:-2:2] = xx - w[1:-1]
    lower[3, 0:-2:2] = xy
    lower[1, 1:-2:2] = xy
    lower[2, 1:-2:2] = yy - w[1:-1]
    return lower


class JointSystem:
    """Cholesky factors of the joint system at one attitude."""

    def __init__(self, model: ChainModel, unit: ComplexArray) -> None:
        """Factor the system.

        Parameters
        ----------
        model : ChainModel
        unit : ndarray of complex, shape (N,)
            Unit vectors u_j along the bars.

        Raises
        ------
        numpy.linalg.LinAlgError
            If the matrix is not positive definite in double precision: masses or inertias are too unequal.
        """
        self.model, self.unit = model, unit
        self.joints = model.bars - 1
        if self.joints:
            matrix = joint_matrix(model, 1j * unit)
            self.factor, status = dpbtrf(matrix, lower=1)
            if status != 0 or (self.factor[0] ** 2 <= ROUNDING * matrix[0]).any():
                raise np.linalg.LinAlgError(NOT_POSITIVE_DEFINITE)

    def solve(self, right: ComplexArray, *, refine: bool) -> ComplexArray:
        """Reactions for each row of right-hand sides, both (k, N-1), N and m/s².

        Banded Cholesky loses as many digits as the condition number has, which grows as N² and as the ratio of masses.
        The reactions themselves are better conditioned: a unit in the last place of masses, lengths and angles changes
        the reactions of a straight chain of 500 bars by a similar relative amount. `refine` restores the lost digits.
        The residual, computed as in :meth:`openings`, is small and accurate to its own last digits.

        Raises
        ------
        numpy.linalg.LinAlgError
            If refinement does not converge: some reactions consist of round-off alone.
        """
        if not self.joints:
            return right
        found = self.raw(right)
        if not refine:
            return found
        for _ in range(REFINEMENTS):
            correction = self.raw(right - self.openings(found))
            found = found + correction
            left, largest = np.abs(correction).max(), np.abs(found).max()
            if not left > CONVERGED * largest:  # each correction gains as many digits as the previous one
                break
        if left > DIVERGED * largest:
            raise np.linalg.LinAlgError(NOT_POSITIVE_DEFINITE)
        return found

    def raw(self, right: ComplexArray) -> ComplexArray:
        """Reactions from the Cholesky factors, without refinement."""
        columns = np.ascontiguousarray(right).view(float).T
        solution, _ = dpbtrs(self.factor, columns, lower=1)
        return np.ascontiguousarray(solution.T).view(np.complex128)

    def openings(self, reaction: ComplexArray) -> ComplexArray:
        """Relative accelerations of the joined ends under reactions (k, N-1): the matrix times the reactions.

        Neighbouring reactions are subtracted before any multiplication. In a chain under tension neighbours are nearly
        equal, and their difference is exact.
        """
        ends = np.zeros((len(reaction), self.joints + 2), complex)
        ends[:, 1:-1] = reaction
        pull = self.model.inverse_mass * (ends[:, 1:] - ends[:, :-1])
        before, after = by_levers(self.model, ends[:, :-1], ends[:, 1:])
        turned = self.model.compliance * (self.unit.conj() * (after + before)).imag * (1j * self.unit)
        left, right = by_levers(self.model, turned, turned)
        opened: ComplexArray = (pull[:, :-1] - pull[:, 1:]) + (right[:, :-1] + left[:, 1:])
        return opened


def condition_number(lower: Array) -> float:
    """Two-norm condition number of the joint system; 1 for a chain without joints. O(N²), for diagnosis."""
    size = lower.shape[1]
    if size == 0:
        return 1.0
    full = np.zeros((size, size))
    for i in range(min(BANDWIDTH, size)):
        rows = np.arange(size - i)
        full[rows + i, rows] = full[rows, rows + i] = lower[i, : size - i]
    return float(np.linalg.cond(full))
