"""The paper's formulation, equation by equation: reactions (23), accelerations (24), prescribed rotations (27).

The formulation serves as a check of :mod:`reference_impl.model.relative`, its O(N) equivalent, and to measure the
effect of each of the paper's misprints. Dense, O(N³).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.model.state import Accelerations, State
from reference_impl.paper.matrices import ROWS, Longitudes, Matrices, matrices
from reference_impl.paper.misprints import Misprint
from reference_impl.paper.state import PaperUnits, paper_state, units_of

if TYPE_CHECKING:
    from collections.abc import Set

    from reference_impl.model.arrays import Array
    from reference_impl.model.chain import ChainModel, Prescription


class NotSquareError(ValueError):
    """Equation (27) as printed has more unknowns than equations."""


@dataclass(frozen=True)
class PaperSolution:
    """Solution of the paper's equations, in the paper's units."""

    X_acceleration: Array
    """(NX,)"""
    reaction: Array
    """(N-1, 2) in units of epsilon M g_eq"""
    torque: Array
    """(P,)"""
    longitudes: Longitudes

    @property
    def bars(self) -> Array:
        """T_j1'', T_j2'', phi_j'' of each bar, shape (N, 3)."""
        return self.X_acceleration[:-2].reshape(-1, ROWS)

    @property
    def theta_acceleration(self) -> Array:
        """theta_j'' = phi_j'' + omega_j'', shape (N,)."""
        omega = self.longitudes.acceleration(self.bars[:, :2], self.X_acceleration[-2:])
        total: Array = self.bars[:, 2] + omega
        return total


def paper_accelerations(
    model: ChainModel, t_s: float, state: State, as_printed: Set[Misprint] = frozenset()
) -> Accelerations:
    """Accelerations, reactions and torques of a state by the paper's equations.

    Parameters
    ----------
    model : ChainModel
        Chain with gravity "gradient", the paper's only gravity model.
    t_s : float
        Time, for the prescribed laws.
    state : State
    as_printed : set of Misprint, optional
        Misprints to keep; by default all are corrected.

    Returns
    -------
    Accelerations
        In SI units and inertial angles, as :func:`reference_impl.model.relative.accelerations` gives them.

    Raises
    ------
    ValueError
        If the model has another gravity.
    NotSquareError
        If (27) is requested as printed and a rotation is prescribed.
    """
    units = units_of(model, state.com_m)
    found = solve(model, t_s, state, units, as_printed)
    rate2 = 1.0 / units.time_s**2
    return Accelerations(
        com_m_s2=found.X_acceleration[-2:] * (units.radius_m * rate2),
        angle_rad_s2=found.theta_acceleration * rate2,
        position_m_s2=found.bars[:, :2] * (units.length_m * rate2),
        reaction_N=found.reaction * units.force_N,
        torque_N_m=found.torque * units.torque_N_m,
    )


def solve(model: ChainModel, t_s: float, state: State, units: PaperUnits, as_printed: Set[Misprint]) -> PaperSolution:
    """Solution in the paper's units; see :func:`paper_accelerations`."""
    if model.gravity != "gradient":
        raise ValueError(f'the paper\'s formulation supports gravity "gradient" only, not "{model.gravity}"')
    m = matrices(paper_state(model, state, units), as_printed)
    H, G = prescribed_rows(model, t_s, units, m.longitudes)
    if not len(G):
        reaction = solve_dense(m.A @ (m.W / m.E[:, None]), m.B - m.A @ m.F)  # (23)
        return PaperSolution(m.F + m.W @ reaction / m.E, reaction.reshape(-1, 2), np.empty(0), m.longitudes)  # (24)
    return solve_with_controls(m, H, G, control_columns(model, as_printed), m.longitudes)


def solve_with_controls(m: Matrices, H: Array, G: Array, D: Array, longitudes: Longitudes) -> PaperSolution:
    """Equation (27), with columns D for the control forces in place of an identity."""
    pushed = np.column_stack([m.W, D]) / m.E[:, None]
    asked = np.vstack([m.A, H])
    left = asked @ pushed
    if left.shape[0] != left.shape[1]:
        raise NotSquareError(
            f"(27) as printed is not square: {left.shape[0]} equations (joints and prescribed motions) "
            f"for {left.shape[1]} unknowns (reactions and an identity of full width for the control forces)"
        )
    unknown = solve_dense(left, np.concatenate([m.B, G]) - asked @ m.F)
    joints = m.W.shape[1]
    return PaperSolution(m.F + pushed @ unknown, unknown[:joints].reshape(-1, 2), unknown[joints:], longitudes)


def solve_dense(matrix: Array, right: Array) -> Array:
    """Solve a square system, in double precision."""
    found: Array = np.linalg.solve(matrix, right).astype(np.float64, copy=False)
    return found


def prescribed_rows(model: ChainModel, t_s: float, units: PaperUnits, longitudes: Longitudes) -> tuple[Array, Array]:
    """H (P, NX) and G (P,) of eq. (25): phi_p'' itself, phi_p'' + omega_p'' for an inertial angle, or two of these."""
    laws = model.prescriptions
    H, G = np.zeros((len(laws), ROWS * model.bars + 2)), np.zeros(len(laws))
    for row, p in enumerate(laws):
        G[row] = p.acceleration_rad_s2(t_s) * units.time_s**2
        for bar, sign in ((p.bar, 1.0), (p.bar - 1, -1.0))[: 2 if p.frame == "previous_bar" else 1]:
            first = ROWS * bar
            H[row, first + 2] = sign
            if p.frame != "local_horizontal":
                H[row, first : first + 2] = sign * longitudes.alpha[bar]
                H[row, -2:] += sign * longitudes.beta[bar]
                G[row] -= sign * longitudes.gamma[bar]
    return H, G


def control_columns(model: ChainModel, as_printed: Set[Misprint]) -> Array:
    """Rows of X on which each control torque acts, shape (NX, P).

    The columns equal the transpose of H only if H selects phi_p. For inertial angles H also contains the longitude's
    terms, but a torque accelerates no centre of mass.
    """
    size = ROWS * model.bars + 2
    if Misprint.CONTROL_IDENTITY in as_printed:
        return np.eye(size)
    return np.stack([control_column(p, size) for p in model.prescriptions], axis=-1)


def control_column(p: Prescription, size: int) -> Array:
    """Column of one torque: on its bar, and for a joint motor the opposite on the neighbour."""
    column = np.zeros(size)
    column[ROWS * p.bar + 2] = 1.0
    if p.reacts_on is not None:
        column[ROWS * p.reacts_on + 2] = -1.0
    return column
