"""Drag, as :mod:`reference_impl.effects.drag`; the mode is the face of each bar in the wind."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.fast.bar_positions import velocities_from_first
from reference_impl.fast.jit import inlined
from reference_impl.fast.layout import (
    ANGULAR,
    AX,
    AY,
    DX,
    DY,
    HALF,
    INVERSE_INERTIA,
    INVERSE_MASS,
    UX,
    UY,
    VX,
    VY,
    CompiledEffect,
    effect_numbers,
)
from reference_impl.model.effect import EDGE_ON

if TYPE_CHECKING:
    from reference_impl.effects.drag import DragEffect
    from reference_impl.fast.layout import CompiledChain, Workspace
    from reference_impl.model.arrays import Array


def compiled_effect(effect: DragEffect) -> CompiledEffect:
    """Constants of the atmosphere; the table's row is the bars' width, m."""
    values = {
        "density_kg_m3": effect.density_kg_m3,
        "radius_m": effect.radius_m,
        "per_height_1_m": 1.0 / effect.scale_height_m,
        "rotation_rad_s": effect.rotation_rad_s,
        "normal_coefficient": effect.normal_coefficient,
        "tangential_coefficient": effect.tangential_coefficient,
    }
    width = np.array(effect.width_m, dtype=float)[None]
    return CompiledEffect(effect_numbers(effect.name, values), width, np.ones(width.shape[1]))


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
    """Add force and torque, integrated over each bar."""
    given, rows, bars, moved = effect.numbers[0].drag, work.bars, chain.bars, work.effect_sums.bars
    com_x, com_y, per_height, rotation = y[n], y[n + 1], given.per_height_1_m, given.rotation_rad_s
    on_normal, on_tangent = given.normal_coefficient, given.tangential_coefficient
    drift_x, drift_y = velocities_from_first(n, y, bars, rows, moved)
    r0 = math.sqrt(com_x * com_x + com_y * com_y)
    below = -0.5 * given.density_kg_m3 * math.exp((given.radius_m - r0) * per_height)
    for i in range(n):
        dx, dy = rows[DX, i] - mean_x, rows[DY, i] - mean_y
        ux, uy, x, z = rows[UX, i], rows[UY, i], com_x + dx, com_y + dy
        wind_x = y[2 * n + 2] + (moved[VX, i] - drift_x) + rotation * z
        wind_y = y[2 * n + 3] + (moved[VY, i] - drift_y) - rotation * x
        t, v, w = ux * wind_x + uy * wind_y, ux * wind_y - uy * wind_x, y[n + 2 + i] - rotation
        r = math.sqrt(x * x + z * z)
        higher = ((2.0 * com_x + dx) * dx + (2.0 * com_y + dy) * dy) / (r + r0)
        kappa, length = (ux * x + uy * z) / r * per_height, 2.0 * bars[HALF, i]
        second = length * length * length * (1.0 / 12.0)
        fourth = second * length * length * (12.0 / 80.0)
        strength = below * math.exp(-higher * per_height) * effect.table[0, i] * effect.mode[i]
        across = strength * on_normal * (length * v * v + second * w * (w - 2.0 * kappa * v)) * bars[INVERSE_MASS, i]
        along = strength * on_tangent * t * (length * v - kappa * second * w) * bars[INVERSE_MASS, i]
        moved[AX, i] += along * ux - across * uy
        moved[AY, i] += along * uy + across * ux
        turned = strength * on_normal * (2.0 * second * v * w - kappa * (second * v * v + fourth * w * w))
        rows[ANGULAR, i] += turned * bars[INVERSE_INERTIA, i]


@inlined
def mode_ended(
    effect: CompiledEffect,
    n: int,
    t_s: float,
    y: Array,
    mean_x: float,
    mean_y: float,
    chain: CompiledChain,
    work: Workspace,
) -> bool:
    """Whether any bar meets the wind with its other face."""
    rows, moved, rotation, worst = work.bars, work.effect_sums.bars, effect.numbers[0].drag.rotation_rad_s, 0.0
    drift_x, drift_y = velocities_from_first(n, y, chain.bars, rows, moved)
    for i in range(n):
        x, z = y[n] + (rows[DX, i] - mean_x), y[n + 1] + (rows[DY, i] - mean_y)
        wind_x = y[2 * n + 2] + (moved[VX, i] - drift_x) + rotation * z
        wind_y = y[2 * n + 3] + (moved[VY, i] - drift_y) - rotation * x
        across = effect.mode[i] * (rows[UX, i] * wind_y - rows[UY, i] * wind_x)
        worst = min(worst, across + EDGE_ON * math.hypot(wind_x, wind_y))
    return bool(worst < 0.0)
