"""Third body, as :mod:`reference_impl.effects.third_body`, with Encke's change in closed form."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from reference_impl.fast.effects.second_moment import acceleration, angular_acceleration
from reference_impl.fast.layout import (
    ANGULAR,
    AX,
    AY,
    COMMON_X,
    COMMON_Y,
    DX,
    DY,
    INVERSE_INERTIA,
    INVERSE_MASS,
    NONCENTRAL_X,
    NONCENTRAL_Y,
    UX,
    UY,
    CompiledChain,
    Workspace,
)
from reference_impl.machine_code.functions import compiled, inlined
from reference_impl.machine_code.library import Library
from reference_impl.machine_code.structs import Struct, Vector

if TYPE_CHECKING:
    from reference_impl.effects.third_body import ThirdBodyEffect


@dataclass(frozen=True)
class CompiledThirdBody(Struct):
    """Third body in compiled code."""

    mu_m3_s2: float
    distance_m: float
    longitude_rad: float
    rate_rad_s: float
    turns: int
    """1 with torque on second moments"""
    second_moment: int
    """1 with force on second moments"""


def constants(effect: ThirdBodyEffect) -> CompiledThirdBody:
    """Mass, orbit and switches."""
    return CompiledThirdBody(
        effect.mu_m3_s2,
        effect.distance_m,
        effect.longitude_rad,
        effect.rate_rad_s,
        int(effect.turns),
        int(effect.second_moment),
    )


@inlined
def encke_change(q: float) -> float:
    """1 - (1 + q)^(-3/2), as in :mod:`reference_impl.fast.field`."""
    s = 1.0 + q
    cube = s * math.sqrt(s)
    return q * (3.0 + q * (3.0 + q)) / (cube * (1.0 + cube))


@compiled
def add_effect(
    own: CompiledThirdBody,
    n: int,
    t_s: float,
    y: Vector,
    mean_x: float,
    mean_y: float,
    chain: CompiledChain,
    work: Workspace,
) -> None:
    """Add the tide at the centre of mass, the differences of the attraction, and the terms of second moments."""
    rows, moved = work.bars, work.effect_bars
    longitude, d2 = own.longitude_rad + own.rate_rad_s * t_s, own.distance_m * own.distance_m
    body_x, body_y = own.distance_m * math.cos(longitude), own.distance_m * math.sin(longitude)
    add_common_tide(own.mu_m3_s2 / (d2 * own.distance_m), d2, body_x, body_y, y[n], y[n + 1], work.effect_common)
    com_x, com_y = y[n] - body_x, y[n + 1] - body_y
    inverse2 = 1.0 / (com_x * com_x + com_y * com_y)
    strength = own.mu_m3_s2 * inverse2 * math.sqrt(inverse2)
    for i in range(n):
        dx, dy = rows[DX, i] - mean_x, rows[DY, i] - mean_y
        change = encke_change(((2.0 * com_x + dx) * dx + (2.0 * com_y + dy) * dy) * inverse2)
        moved[AX, i] += strength * (com_x * change - dx * (1.0 - change))
        moved[AY, i] += strength * (com_y * change - dy * (1.0 - change))
    if own.turns != 0:
        for i in range(n):
            x, z = y[n] + (rows[DX, i] - mean_x) - body_x, y[n + 1] + (rows[DY, i] - mean_y) - body_y
            rows[ANGULAR, i] += angular_acceleration(own.mu_m3_s2, x, z, rows[UX, i], rows[UY, i])
    if own.second_moment != 0:
        add_second_moment(own.mu_m3_s2, body_x, body_y, n, y, mean_x, mean_y, chain, work)


@inlined
def add_common_tide(
    strength: float, d2: float, body_x: float, body_y: float, x: float, y: float, common: Vector
) -> None:
    """Add the acceleration at (x, y) minus that of the central body: (mu/D³)(X ((1+q)^(-3/2) - 1) - Z (1+q)^(-3/2))."""
    change = encke_change((x * x + y * y - 2.0 * (body_x * x + body_y * y)) / d2)
    tide_x = -strength * (body_x * change + x * (1.0 - change))
    tide_y = -strength * (body_y * change + y * (1.0 - change))
    common[COMMON_X] += tide_x
    common[COMMON_Y] += tide_y
    common[NONCENTRAL_X] += tide_x
    common[NONCENTRAL_Y] += tide_y


@inlined
def add_second_moment(
    mu: float,
    body_x: float,
    body_y: float,
    n: int,
    y: Vector,
    mean_x: float,
    mean_y: float,
    chain: CompiledChain,
    work: Workspace,
) -> None:
    """Add the force on the bars' second moments."""
    rows, bars, moved = work.bars, chain.bars, work.effect_bars
    for i in range(n):
        x, z = y[n] + (rows[DX, i] - mean_x) - body_x, y[n + 1] + (rows[DY, i] - mean_y) - body_y
        px, py = acceleration(mu, x, z, rows[UX, i], rows[UY, i], bars[INVERSE_MASS, i] / bars[INVERSE_INERTIA, i])
        moved[AX, i] += px
        moved[AY, i] += py


Library("third_body", (add_effect,))
