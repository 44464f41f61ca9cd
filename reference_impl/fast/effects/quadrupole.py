"""Force on the bars' second moments, as :mod:`reference_impl.effects.quadrupole`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from reference_impl.fast.effects.second_moment import acceleration
from reference_impl.fast.layout import (
    AX,
    AY,
    DX,
    DY,
    INVERSE_INERTIA,
    INVERSE_MASS,
    UX,
    UY,
    CompiledChain,
    Workspace,
)
from reference_impl.machine_code.functions import compiled
from reference_impl.machine_code.library import Library
from reference_impl.machine_code.structs import Struct, Vector

if TYPE_CHECKING:
    from reference_impl.effects.quadrupole import QuadrupoleEffect


@dataclass(frozen=True)
class CompiledQuadrupole(Struct):
    """Effect without constants of its own."""


def constants(_: QuadrupoleEffect) -> CompiledQuadrupole:
    """Struct without constants."""
    return CompiledQuadrupole()


@compiled
def add_effect(
    own: CompiledQuadrupole,
    n: int,
    t_s: float,
    y: Vector,
    mean_x: float,
    mean_y: float,
    chain: CompiledChain,
    work: Workspace,
) -> None:
    """Add the force; gravity adds the torque."""
    rows, bars, moved, mu = work.bars, chain.bars, work.effect_bars, chain.mu_m3_s2
    com_x, com_y = y[n], y[n + 1]
    for i in range(n):
        x, z = com_x + (rows[DX, i] - mean_x), com_y + (rows[DY, i] - mean_y)
        px, py = acceleration(mu, x, z, rows[UX, i], rows[UY, i], bars[INVERSE_MASS, i] / bars[INVERSE_INERTIA, i])
        moved[AX, i] += px
        moved[AY, i] += py


Library("quadrupole", (add_effect,))
