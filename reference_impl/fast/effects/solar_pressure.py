"""Solar radiation pressure, as :mod:`reference_impl.effects.solar_pressure`; the mode is light or shadow, and faces."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.fast.jit import inlined
from reference_impl.fast.layout import AX, AY, HALF, INVERSE_MASS, UX, UY, CompiledEffect, effect_numbers
from reference_impl.model.effect import EDGE_ON

if TYPE_CHECKING:
    from reference_impl.effects.solar_pressure import SolarPressureEffect
    from reference_impl.fast.layout import CompiledChain, Workspace
    from reference_impl.model.arrays import Array

WIDTH, SIDE = range(2)


def compiled_effect(effect: SolarPressureEffect) -> CompiledEffect:
    """Constants of light and shadow.

    The table's rows are the bars' width, m, and, in the first column, the previous distance from the shadow's axis, m.
    """
    values = {
        "pressure_Pa": effect.pressure_Pa,
        "longitude_rad": effect.longitude_rad,
        "rate_rad_s": effect.rate_rad_s,
        "reflectivity": effect.reflectivity,
        "shadow_radius_m": effect.shadow_radius_m,
    }
    table = np.array([effect.width_m, np.zeros_like(effect.width_m)], dtype=float)
    return CompiledEffect(effect_numbers(effect.name, values), table, np.ones(1 + table.shape[1]))


@inlined
def sun_direction(effect: CompiledEffect, t_s: float) -> tuple[float, float]:
    """Unit vector to the Sun."""
    given = effect.numbers[0].solar_pressure
    longitude = given.longitude_rad + given.rate_rad_s * t_s
    return math.cos(longitude), math.sin(longitude)


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
    """Add the force in light; uniform light exerts no torque on a bar."""
    if effect.mode[0] == 0.0:
        return
    given, rows, bars, moved = effect.numbers[0].solar_pressure, work.bars, chain.bars, work.effect_sums.bars
    sx, sy = sun_direction(effect, t_s)
    pressure, mirrored = -2.0 * given.pressure_Pa, 2.0 * given.reflectivity
    sx_taken, sy_taken = (1.0 - given.reflectivity) * sx, (1.0 - given.reflectivity) * sy
    for i in range(n):
        ux, uy = rows[UX, i], rows[UY, i]
        seen = ux * sy - uy * sx  # n·s; its sign is the face's
        strength = (
            pressure * effect.table[WIDTH, i] * bars[HALF, i] * bars[INVERSE_MASS, i] * (effect.mode[1 + i] * seen)
        )
        moved[AX, i] += strength * (sx_taken - mirrored * seen * uy)
        moved[AY, i] += strength * (sy_taken + mirrored * seen * ux)


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
    """Whether the chain has crossed the shadow's edge, or a bar shows its other face.

    A shadow's axis between this sample and the previous one also counts: the chain may have crossed the shadow in
    between.
    """
    radius, rows = effect.numbers[0].solar_pressure.shadow_radius_m, work.bars
    sx, sy = sun_direction(effect, t_s)
    worst = 0.0
    if radius != 0.0:
        towards, across = sx * y[n] + sy * y[n + 1], sx * y[n + 1] - sy * y[n]
        away = abs(across) if towards < 0.0 else math.hypot(towards, across)
        worst = min(0.0, (2.0 * effect.mode[0] - 1.0) * (away - radius))
        side = across if towards < 0.0 else 0.0
        if side * effect.table[SIDE, 0] < 0.0 and effect.mode[0] != 0.0:
            worst = -1.0
        effect.table[SIDE, 0] = side
    for i in range(n):
        worst = min(worst, effect.mode[1 + i] * (rows[UX, i] * sy - rows[UY, i] * sx) + EDGE_ON)
    return bool(worst < 0.0)
