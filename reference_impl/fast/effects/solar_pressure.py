"""Solar radiation pressure, as :mod:`reference_impl.effects.solar_pressure`; the mode is light or shadow, and faces."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.fast.layout import (
    AX,
    AY,
    HALF,
    INVERSE_MASS,
    UX,
    UY,
    CompiledChain,
    Workspace,
)
from reference_impl.machine_code.functions import compiled, inlined
from reference_impl.machine_code.library import Library
from reference_impl.machine_code.structs import Struct, Vector
from reference_impl.model.effect import EDGE_ON

if TYPE_CHECKING:
    from reference_impl.effects.solar_pressure import SolarPressureEffect


@dataclass(frozen=True)
class CompiledSunlight(Struct):
    """Solar pressure in compiled code."""

    pressure_Pa: float
    longitude_rad: float
    rate_rad_s: float
    reflectivity: float
    shadow_radius_m: float
    width_m: Vector
    """(N,)"""
    side_m: Vector
    """(1,) previous distance from the shadow's axis"""
    mode: Vector
    """(1+N,) light 1 or shadow 0, and face of each bar"""


def constants(effect: SolarPressureEffect) -> CompiledSunlight:
    """Constants of light and shadow, and the bars' widths."""
    return CompiledSunlight(
        effect.pressure_Pa,
        effect.longitude_rad,
        effect.rate_rad_s,
        effect.reflectivity,
        effect.shadow_radius_m,
        np.array(effect.width_m, dtype=float),
        np.zeros(1),
        np.ones(1 + len(effect.width_m)),
    )


@inlined
def sun_direction(own: CompiledSunlight, t_s: float) -> tuple[float, float]:
    """Unit vector to the Sun."""
    longitude = own.longitude_rad + own.rate_rad_s * t_s
    return math.cos(longitude), math.sin(longitude)


@compiled
def add_effect(
    own: CompiledSunlight,
    n: int,
    t_s: float,
    y: Vector,
    mean_x: float,
    mean_y: float,
    chain: CompiledChain,
    work: Workspace,
) -> None:
    """Add the force in light; uniform light exerts no torque on a bar."""
    if own.mode[0] == 0.0:
        return
    rows, bars, moved = work.bars, chain.bars, work.effect_bars
    sx, sy = sun_direction(own, t_s)
    pressure, mirrored = -2.0 * own.pressure_Pa, 2.0 * own.reflectivity
    sx_taken, sy_taken = (1.0 - own.reflectivity) * sx, (1.0 - own.reflectivity) * sy
    for i in range(n):
        ux, uy = rows[UX, i], rows[UY, i]
        seen = ux * sy - uy * sx  # n·s; its sign is the face's
        strength = pressure * own.width_m[i] * bars[HALF, i] * bars[INVERSE_MASS, i] * (own.mode[1 + i] * seen)
        moved[AX, i] += strength * (sx_taken - mirrored * seen * uy)
        moved[AY, i] += strength * (sy_taken + mirrored * seen * ux)


@compiled
def mode_ended(
    own: CompiledSunlight,
    n: int,
    t_s: float,
    y: Vector,
    mean_x: float,
    mean_y: float,
    chain: CompiledChain,
    work: Workspace,
) -> bool:
    """Whether the chain has crossed the shadow's edge, or a bar shows its other face.

    A shadow's axis between this sample and the previous one also counts: the chain may have crossed the shadow in
    between.
    """
    radius, rows = own.shadow_radius_m, work.bars
    sx, sy = sun_direction(own, t_s)
    worst = 0.0
    if radius != 0.0:
        towards, across = sx * y[n] + sy * y[n + 1], sx * y[n + 1] - sy * y[n]
        away = abs(across) if towards < 0.0 else math.hypot(towards, across)
        worst = min(0.0, (2.0 * own.mode[0] - 1.0) * (away - radius))
        side = across if towards < 0.0 else 0.0
        if side * own.side_m[0] < 0.0 and own.mode[0] != 0.0:
            worst = -1.0
        own.side_m[0] = side
    for i in range(n):
        worst = min(worst, own.mode[1 + i] * (rows[UX, i] * sy - rows[UY, i] * sx) + EDGE_ON)
    return bool(worst < 0.0)


Library("solar_pressure", (add_effect, mode_ended))
