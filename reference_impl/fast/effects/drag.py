"""Drag, as :mod:`reference_impl.effects.drag`; the mode is the face of each bar in the wind."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.fast.bar_positions import velocities_from_first
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
    CompiledChain,
    Workspace,
)
from reference_impl.machine_code.functions import compiled
from reference_impl.machine_code.library import Library
from reference_impl.machine_code.structs import Struct, Vector
from reference_impl.model.effect import EDGE_ON

if TYPE_CHECKING:
    from reference_impl.effects.drag import DragEffect


@dataclass(frozen=True)
class CompiledDrag(Struct):
    """Drag in compiled code."""

    density_kg_m3: float
    radius_m: float
    per_height_1_m: float
    rotation_rad_s: float
    normal_coefficient: float
    tangential_coefficient: float
    width_m: Vector
    """(N,)"""
    mode: Vector
    """(N,) face in the wind: 1 or -1"""


def constants(effect: DragEffect) -> CompiledDrag:
    """Constants of the atmosphere, and the bars' widths."""
    return CompiledDrag(
        effect.density_kg_m3,
        effect.radius_m,
        1.0 / effect.scale_height_m,
        effect.rotation_rad_s,
        effect.normal_coefficient,
        effect.tangential_coefficient,
        np.array(effect.width_m, dtype=float),
        np.ones(len(effect.width_m)),
    )


@compiled
def add_effect(
    own: CompiledDrag,
    n: int,
    t_s: float,
    y: Vector,
    mean_x: float,
    mean_y: float,
    chain: CompiledChain,
    work: Workspace,
) -> None:
    """Add force and torque, integrated over each bar."""
    rows, bars, moved = work.bars, chain.bars, work.effect_bars
    com_x, com_y, per_height, rotation = y[n], y[n + 1], own.per_height_1_m, own.rotation_rad_s
    on_normal, on_tangent = own.normal_coefficient, own.tangential_coefficient
    drift_x, drift_y = velocities_from_first(n, y, bars, rows, moved)
    r0 = math.sqrt(com_x * com_x + com_y * com_y)
    below = -0.5 * own.density_kg_m3 * math.exp((own.radius_m - r0) * per_height)
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
        strength = below * math.exp(-higher * per_height) * own.width_m[i] * own.mode[i]
        across = strength * on_normal * (length * v * v + second * w * (w - 2.0 * kappa * v)) * bars[INVERSE_MASS, i]
        along = strength * on_tangent * t * (length * v - kappa * second * w) * bars[INVERSE_MASS, i]
        moved[AX, i] += along * ux - across * uy
        moved[AY, i] += along * uy + across * ux
        turned = strength * on_normal * (2.0 * second * v * w - kappa * (second * v * v + fourth * w * w))
        rows[ANGULAR, i] += turned * bars[INVERSE_INERTIA, i]


@compiled
def mode_ended(
    own: CompiledDrag,
    n: int,
    t_s: float,
    y: Vector,
    mean_x: float,
    mean_y: float,
    chain: CompiledChain,
    work: Workspace,
) -> bool:
    """Whether any bar meets the wind with its other face."""
    rows, moved, rotation, worst = work.bars, work.effect_bars, own.rotation_rad_s, 0.0
    drift_x, drift_y = velocities_from_first(n, y, chain.bars, rows, moved)
    for i in range(n):
        x, z = y[n] + (rows[DX, i] - mean_x), y[n + 1] + (rows[DY, i] - mean_y)
        wind_x = y[2 * n + 2] + (moved[VX, i] - drift_x) + rotation * z
        wind_y = y[2 * n + 3] + (moved[VY, i] - drift_y) - rotation * x
        across = own.mode[i] * (rows[UX, i] * wind_y - rows[UY, i] * wind_x)
        worst = min(worst, across + EDGE_ON * math.hypot(wind_x, wind_y))
    return bool(worst < 0.0)


Library("drag", (add_effect, mode_ended))
