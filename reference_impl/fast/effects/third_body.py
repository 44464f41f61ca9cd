"""Third body, as :mod:`reference_impl.effects.third_body`, with Encke's change in closed form."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.fast.effects.second_moment import acceleration, angular_acceleration
from reference_impl.fast.jit import inlined
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
    CompiledEffect,
    effect_numbers,
)

if TYPE_CHECKING:
    from reference_impl.effects.third_body import ThirdBodyEffect
    from reference_impl.fast.layout import CompiledChain, Workspace
    from reference_impl.model.arrays import Array


def compiled_effect(effect: ThirdBodyEffect) -> CompiledEffect:
    """Mass and orbit, and the switches of torque and force on second moments."""
    values = {
        "mu_m3_s2": effect.mu_m3_s2,
        "distance_m": effect.distance_m,
        "longitude_rad": effect.longitude_rad,
        "rate_rad_s": effect.rate_rad_s,
        "turns": float(effect.turns),
        "second_moment": float(effect.second_moment),
    }
    return CompiledEffect(effect_numbers(effect.name, values), np.zeros((0, 0)), np.zeros(0))


@inlined
def encke_change(q: float) -> float:
    """1 - (1 + q)^(-3/2), as in :mod:`reference_impl.fast.field`."""
    s = 1.0 + q
    cube = s * math.sqrt(s)
    return q * (3.0 + q * (3.0 + q)) / (cube * (1.0 + cube))


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
    """Add the tide at the centre of mass, the differences of the attraction, and the terms of second moments."""
    given, rows, moved = effect.numbers[0].third_body, work.bars, work.effect_sums.bars
    longitude, d2 = given.longitude_rad + given.rate_rad_s * t_s, given.distance_m * given.distance_m
    body_x, body_y = given.distance_m * math.cos(longitude), given.distance_m * math.sin(longitude)
    add_common_tide(
        given.mu_m3_s2 / (d2 * given.distance_m), d2, body_x, body_y, y[n], y[n + 1], work.effect_sums.common
    )
    com_x, com_y = y[n] - body_x, y[n + 1] - body_y
    inverse2 = 1.0 / (com_x * com_x + com_y * com_y)
    strength = given.mu_m3_s2 * inverse2 * math.sqrt(inverse2)
    for i in range(n):
        dx, dy = rows[DX, i] - mean_x, rows[DY, i] - mean_y
        change = encke_change(((2.0 * com_x + dx) * dx + (2.0 * com_y + dy) * dy) * inverse2)
        moved[AX, i] += strength * (com_x * change - dx * (1.0 - change))
        moved[AY, i] += strength * (com_y * change - dy * (1.0 - change))
    if given.turns != 0.0:
        for i in range(n):
            x, z = y[n] + (rows[DX, i] - mean_x) - body_x, y[n + 1] + (rows[DY, i] - mean_y) - body_y
            rows[ANGULAR, i] += angular_acceleration(given.mu_m3_s2, x, z, rows[UX, i], rows[UY, i])
    if given.second_moment != 0.0:
        add_second_moment(given.mu_m3_s2, body_x, body_y, n, y, mean_x, mean_y, chain, work)


@inlined
def add_common_tide(
    strength: float, d2: float, body_x: float, body_y: float, x: float, y: float, common: Array
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
    y: Array,
    mean_x: float,
    mean_y: float,
    chain: CompiledChain,
    work: Workspace,
) -> None:
    """Add the force on the bars' second moments."""
    rows, bars, moved = work.bars, chain.bars, work.effect_sums.bars
    for i in range(n):
        x, z = y[n] + (rows[DX, i] - mean_x) - body_x, y[n + 1] + (rows[DY, i] - mean_y) - body_y
        px, py = acceleration(mu, x, z, rows[UX, i], rows[UY, i], bars[INVERSE_MASS, i] / bars[INVERSE_INERTIA, i])
        moved[AX, i] += px
        moved[AY, i] += py
