"""One evaluation of the relative formulation: rates of the state, reactions and torques."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from reference_impl.fast.effect_calls import add_common_acceleration
from reference_impl.fast.field import end_accelerations, forces
from reference_impl.fast.joints import reactions, refine
from reference_impl.fast.laws import apply_prescribed_torques, rotation_per_unit_torque, unit_torque_reactions
from reference_impl.fast.layout import (
    ANGULAR,
    GX,
    GY,
    LEVER,
    NO_GRAVITY,
    REFINED,
    RX,
    RY,
    UX,
    UY,
    WEIGHT,
    CompiledChain,
    Workspace,
)
from reference_impl.fast.trigonometry import unit_vectors
from reference_impl.machine_code.functions import compiled, inlined
from reference_impl.machine_code.structs import Vector

if TYPE_CHECKING:
    from reference_impl.machine_code.structs import Matrix


@compiled
def evaluate(t_s: float, y: Vector, rates: Vector, chain: CompiledChain, work: Workspace) -> bool:
    """Time derivative of a state into `rates`; reactions and torques into `work`.

    Parameters
    ----------
    t_s : float
        Time, for the prescribed laws.
    y, rates : ndarray, shape (2N+4,)
        See :mod:`reference_impl.fast.layout`.
    chain : CompiledChain
    work : Workspace

    Returns
    -------
    bool
        False if the joint system is not positive definite in double precision.
    """
    n, rows, well = chain.bars.shape[1], work.bars, True
    unit_vectors(n, y, rows)
    forces(n, t_s, chain, y, work)
    if len(chain.laws) > 0:
        well = unit_torque_reactions(n, chain, work)
        end_accelerations(n, chain, y, rows)
    well = reactions(n, chain.bars, rows) and well
    if chain.bars[REFINED, 0] != 0.0:
        well = refine(n, chain.bars, rows) and well
    if len(chain.laws) > 0:
        apply_prescribed_torques(n, t_s, y, chain, work)
    for i in range(n + 2):
        rates[i] = y[n + 2 + i]
    angular_accelerations(n, chain, rows, rates)
    for k in range(len(chain.laws)):
        for i in range(n):
            rates[n + 2 + i] += work.torque_N_m[k] * rotation_per_unit_torque(chain.laws[k], i, chain.bars)
    rates[2 * n + 2], rates[2 * n + 3] = com_acceleration(n, chain, y, rows)
    if len(chain.effects) > 0:
        add_common_acceleration(n, chain, work, rates)
    return well


@inlined
def angular_accelerations(n: int, chain: CompiledChain, rows: Matrix, rates: Vector) -> None:
    """Angular accelerations under field and reactions, eq. (15), into `rates`."""
    before_x = before_y = 0.0
    for i in range(n - 1):
        x, y = rows[RX, i], rows[RY, i]
        turned = rows[UX, i] * (y + before_y) - rows[UY, i] * (x + before_x)
        rates[n + 2 + i] = rows[ANGULAR, i] + chain.bars[LEVER, i] * turned
        before_x, before_y = x, y
    i = n - 1
    turned = rows[UX, i] * before_y - rows[UY, i] * before_x
    rates[n + 2 + i] = rows[ANGULAR, i] + chain.bars[LEVER, i] * turned


@inlined
def com_acceleration(n: int, chain: CompiledChain, y: Vector, rows: Matrix) -> tuple[float, float]:
    """Z0'' = g(Z0) + the mean of the differences from g(Z0), eqs. (9), (11)."""
    if chain.gravity == NO_GRAVITY:
        return 0.0, 0.0
    mean_x = mean_y = 0.0
    for i in range(n):
        mean_x += chain.bars[WEIGHT, i] * rows[GX, i]
        mean_y += chain.bars[WEIGHT, i] * rows[GY, i]
    r2 = y[n] * y[n] + y[n + 1] * y[n + 1]
    pull = -chain.mu_m3_s2 / (r2 * math.sqrt(r2))
    return pull * y[n] + mean_x, pull * y[n + 1] + mean_y
