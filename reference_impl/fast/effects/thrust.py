"""Force on a bar's end, as :mod:`reference_impl.effects.thrust`; the mode is the segment of its table."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.fast.jit import inlined
from reference_impl.fast.layout import ANGULAR, AX, AY, INVERSE_MASS, LEVER, UX, UY, CompiledEffect, effect_numbers

if TYPE_CHECKING:
    from reference_impl.effects.thrust import ThrustEffect
    from reference_impl.fast.layout import CompiledChain, Workspace
    from reference_impl.model.arrays import Array

TIME, FORCE = range(2)


def compiled_effect(effect: ThrustEffect) -> CompiledEffect:
    """Point and direction of application; the table's rows are instants, s, and forces, N."""
    values = {
        "bar": float(effect.bar),
        "side": effect.side,
        "inertial": float(effect.inertial),
        "forwards": math.cos(effect.direction_rad),
        "leftwards": math.sin(effect.direction_rad),
    }
    table = np.array([effect.times_s, effect.force_N], dtype=float)
    return CompiledEffect(effect_numbers(effect.name, values), table, np.full(1, -1.0))


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
    """Add force and torque on one bar, on a segment of the table extrapolated beyond its ends."""
    piece = int(effect.mode[0])
    if piece < 0:
        return
    given, rows, bars, moved = effect.numbers[0].thrust, work.bars, chain.bars, work.effect_sums.bars
    i, t0, f0 = int(given.bar), effect.table[TIME, piece], effect.table[FORCE, piece]
    share = (t_s - t0) / (effect.table[TIME, piece + 1] - t0)
    size = f0 + (effect.table[FORCE, piece + 1] - f0) * share
    ux, uy = rows[UX, i], rows[UY, i]
    push_x, push_y = size * given.forwards, size * given.leftwards
    if given.inertial == 0.0:
        push_x, push_y = ux * push_x - uy * push_y, uy * push_x + ux * push_y
    moved[AX, i] += push_x * bars[INVERSE_MASS, i]
    moved[AY, i] += push_y * bars[INVERSE_MASS, i]
    rows[ANGULAR, i] += given.side * bars[LEVER, i] * (ux * push_y - uy * push_x)
