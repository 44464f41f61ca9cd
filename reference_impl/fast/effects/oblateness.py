"""J2 of the central body; as :mod:`reference_impl.effects.oblateness`.

With s = 1 + q, Encke's change of the fifth power s^(-5/2) - 1 is -(s⁵ - 1)/(s^(5/2) (1 + s^(5/2))), where s⁵ - 1 is a
polynomial in q without a constant.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from reference_impl.fast.layout import (
    ANGULAR,
    AX,
    AY,
    COMMON_X,
    COMMON_Y,
    DX,
    DY,
    GX,
    GY,
    INVERSE_INERTIA,
    INVERSE_MASS,
    UX,
    UY,
    CompiledChain,
    Workspace,
)
from reference_impl.machine_code.functions import compiled, inlined
from reference_impl.machine_code.library import Library
from reference_impl.machine_code.structs import Struct, Vector

if TYPE_CHECKING:
    from reference_impl.effects.oblateness import OblatenessEffect


@dataclass(frozen=True)
class CompiledOblateness(Struct):
    """J2 in compiled code."""

    strength_m5_s2: float
    """B"""
    turns: int
    """1 with torque on second moments"""
    second_moment: int
    """1 with force on second moments"""


def constants(effect: OblatenessEffect) -> CompiledOblateness:
    """Strength and switches."""
    return CompiledOblateness(effect.strength_m5_s2, int(effect.turns), int(effect.turns and effect.second_moment))


@compiled
def add_effect(
    own: CompiledOblateness,
    n: int,
    t_s: float,
    y: Vector,
    mean_x: float,
    mean_y: float,
    chain: CompiledChain,
    work: Workspace,
) -> None:
    """Add -3B Z/r⁵, central; torque, and the noncentral force on second moments."""
    rows, common = work.bars, work.effect_common
    com_x, com_y = y[n], y[n + 1]
    inverse2 = 1.0 / (com_x * com_x + com_y * com_y)
    pull = 3.0 * own.strength_m5_s2 * inverse2 * inverse2 * math.sqrt(inverse2)
    common[COMMON_X] -= pull * com_x
    common[COMMON_Y] -= pull * com_y
    for i in range(n):
        dx, dy = rows[DX, i] - mean_x, rows[DY, i] - mean_y
        q = ((2.0 * com_x + dx) * dx + (2.0 * com_y + dy) * dy) * inverse2
        s = 1.0 + q
        fifth = s * s * math.sqrt(s)  # (r_j/r)⁵
        inverse = 1.0 / (fifth * (1.0 + fifth))
        nearer = q * (5.0 + q * (10.0 + q * (10.0 + q * (5.0 + q)))) * inverse  # 1 - (r/r_j)⁵
        faded = inverse * (1.0 + fifth)  # (r/r_j)⁵
        rows[GX, i] += pull * (com_x * nearer - dx * faded)
        rows[GY, i] += pull * (com_y * nearer - dy * faded)
    if own.turns != 0:
        add_second_moment(own.strength_m5_s2, float(own.second_moment), n, y, mean_x, mean_y, chain, work)


@inlined
def add_second_moment(
    strength: float,
    second_moment: float,
    n: int,
    y: Vector,
    mean_x: float,
    mean_y: float,
    chain: CompiledChain,
    work: Workspace,
) -> None:
    """Add 15 B (u·Z)(n·Z)/r⁷, and (15 B J/2m r⁷) (Z + 2 (u·Z) u - 7 c² Z) if `second_moment` is 1 instead of 0."""
    rows, bars, moved = work.bars, chain.bars, work.effect_bars
    com_x, com_y = y[n], y[n + 1]
    for i in range(n):
        x, z = com_x + (rows[DX, i] - mean_x), com_y + (rows[DY, i] - mean_y)
        ux, uy = rows[UX, i], rows[UY, i]
        inverse2 = 1.0 / (x * x + z * z)
        up, level = ux * x + uy * z, ux * z - uy * x
        seventh = strength * inverse2 * inverse2 * inverse2 * math.sqrt(inverse2)
        rows[ANGULAR, i] += 15.0 * seventh * up * level
        share = second_moment * 7.5 * seventh * bars[INVERSE_MASS, i] / bars[INVERSE_INERTIA, i]
        flat = 1.0 - 7.0 * up * up * inverse2
        moved[AX, i] += share * (2.0 * up * ux + flat * x)
        moved[AY, i] += share * (2.0 * up * uy + flat * z)


Library("oblateness", (add_effect,))
