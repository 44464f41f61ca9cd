"""Force on the bars' second moments, as :mod:`reference_impl.effects.quadrupole`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reference_impl.fast.effects.second_moment import acceleration
from reference_impl.fast.jit import inlined
from reference_impl.fast.layout import (
    AX,
    AY,
    DX,
    DY,
    INVERSE_INERTIA,
    INVERSE_MASS,
    UX,
    UY,
    CompiledEffect,
    effect_numbers,
)

if TYPE_CHECKING:
    from reference_impl.effects.quadrupole import QuadrupoleEffect
    from reference_impl.fast.layout import CompiledChain, Workspace
    from reference_impl.model.arrays import Array


def compiled_effect(effect: QuadrupoleEffect) -> CompiledEffect:
    """Effect without numbers of its own."""
    return CompiledEffect(effect_numbers(effect.name, {"nothing": 0.0}), np.zeros((0, 0)), np.zeros(0))


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
    """Add the force; gravity adds the torque."""
    rows, bars, moved, mu = work.bars, chain.bars, work.effect_sums.bars, chain.mu_m3_s2
    com_x, com_y = y[n], y[n + 1]
    for i in range(n):
        x, z = com_x + (rows[DX, i] - mean_x), com_y + (rows[DY, i] - mean_y)
        px, py = acceleration(mu, x, z, rows[UX, i], rows[UY, i], bars[INVERSE_MASS, i] / bars[INVERSE_INERTIA, i])
        moved[AX, i] += px
        moved[AY, i] += py
