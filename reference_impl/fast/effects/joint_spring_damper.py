"""Springs and dampers in the joints, as :mod:`reference_impl.effects.joint_spring_damper`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.fast.layout import (
    ANGULAR,
    INVERSE_INERTIA,
    CompiledChain,
    Workspace,
)
from reference_impl.machine_code.functions import compiled
from reference_impl.machine_code.library import Library
from reference_impl.machine_code.structs import Matrix, Struct, Vector

if TYPE_CHECKING:
    from reference_impl.effects.joint_spring_damper import JointSpringDamperEffect

STIFFNESS, DAMPING, REST = range(3)


@dataclass(frozen=True)
class CompiledSprings(Struct):
    """Springs and dampers in compiled code."""

    table: Matrix
    """(3, N-1) rows STIFFNESS, DAMPING, REST"""


def constants(effect: JointSpringDamperEffect) -> CompiledSprings:
    """Table of the joints."""
    return CompiledSprings(np.array([effect.stiffness_N_m_rad, effect.damping_N_m_s_rad, effect.rest_rad], dtype=float))


@compiled
def add_effect(
    own: CompiledSprings,
    n: int,
    t_s: float,
    y: Vector,
    mean_x: float,
    mean_y: float,
    chain: CompiledChain,
    work: Workspace,
) -> None:
    """Add equal and opposite torques on both bars of each joint."""
    rows, table, before = work.bars, own.table, 0.0
    for i in range(n - 1):
        bent, bending = y[i + 1] - y[i] - table[REST, i], y[n + 3 + i] - y[n + 2 + i]
        torque = table[STIFFNESS, i] * bent + table[DAMPING, i] * bending
        rows[ANGULAR, i] += (torque - before) * chain.bars[INVERSE_INERTIA, i]
        before = torque
    rows[ANGULAR, n - 1] -= before * chain.bars[INVERSE_INERTIA, n - 1]


Library("joint_spring_damper", (add_effect,))
