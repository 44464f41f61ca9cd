"""Springs and dampers in the joints, as :mod:`reference_impl.effects.joint_spring_damper`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reference_impl.fast.jit import inlined
from reference_impl.fast.layout import ANGULAR, INVERSE_INERTIA, CompiledEffect, effect_numbers

if TYPE_CHECKING:
    from reference_impl.effects.joint_spring_damper import JointSpringDamperEffect
    from reference_impl.fast.layout import CompiledChain, Workspace
    from reference_impl.model.arrays import Array

STIFFNESS, DAMPING, REST = range(3)


def compiled_effect(effect: JointSpringDamperEffect) -> CompiledEffect:
    """Table with rows stiffness, damping and angle at rest, one column per joint."""
    table = np.array([effect.stiffness_N_m_rad, effect.damping_N_m_s_rad, effect.rest_rad], dtype=float)
    return CompiledEffect(effect_numbers(effect.name, {"nothing": 0.0}), table, np.zeros(0))


@inlined
def add_effect(
    effect: CompiledEffect,
    n: int,
    t_s: float,
    y: Array,
    mean_x: float,
    mean_y: float,
    chain: CompiledChain,
    work: Workspace,
) -> None:
    """Add equal and opposite torques on both bars of each joint."""
    rows, table, before = work.bars, effect.table, 0.0
    for i in range(n - 1):
        bent, bending = y[i + 1] - y[i] - table[REST, i], y[n + 3 + i] - y[n + 2 + i]
        torque = table[STIFFNESS, i] * bent + table[DAMPING, i] * bending
        rows[ANGULAR, i] += (torque - before) * chain.bars[INVERSE_INERTIA, i]
        before = torque
    rows[ANGULAR, n - 1] -= before * chain.bars[INVERSE_INERTIA, n - 1]
