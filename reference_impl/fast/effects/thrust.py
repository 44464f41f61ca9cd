"""Force on a bar's end, as :mod:`reference_impl.effects.thrust`; the mode is the segment of its table."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.fast.layout import (
    ANGULAR,
    AX,
    AY,
    INVERSE_MASS,
    LEVER,
    UX,
    UY,
    CompiledChain,
    Workspace,
)
from reference_impl.machine_code.functions import compiled
from reference_impl.machine_code.library import Library
from reference_impl.machine_code.structs import Matrix, Struct, Vector

if TYPE_CHECKING:
    from reference_impl.effects.thrust import ThrustEffect

TIME, FORCE = range(2)


@dataclass(frozen=True)
class CompiledThrust(Struct):
    """Thrust in compiled code."""

    bar: int
    side: float
    """-1 at the first end, 1 at the other"""
    inertial: int
    """1 for a direction in the inertial frame, 0 in the bar's"""
    forwards: float
    leftwards: float
    table: Matrix
    """(2, k) rows TIME, FORCE"""
    mode: Vector
    """(1,) segment of the table; -1: none"""


def constants(effect: ThrustEffect) -> CompiledThrust:
    """Point and direction of application, and the table of instants, s, and forces, N."""
    return CompiledThrust(
        effect.bar,
        effect.side,
        int(effect.inertial),
        math.cos(effect.direction_rad),
        math.sin(effect.direction_rad),
        np.array([effect.times_s, effect.force_N], dtype=float),
        np.full(1, -1.0),
    )


@compiled
def add_effect(
    own: CompiledThrust,
    n: int,
    t_s: float,
    y: Vector,
    mean_x: float,
    mean_y: float,
    chain: CompiledChain,
    work: Workspace,
) -> None:
    """Add force and torque on one bar, on a segment of the table extrapolated beyond its ends."""
    piece = int(own.mode[0])
    if piece < 0:
        return
    rows, bars, moved = work.bars, chain.bars, work.effect_bars
    i, t0, f0 = own.bar, own.table[TIME, piece], own.table[FORCE, piece]
    share = (t_s - t0) / (own.table[TIME, piece + 1] - t0)
    size = f0 + (own.table[FORCE, piece + 1] - f0) * share
    ux, uy = rows[UX, i], rows[UY, i]
    push_x, push_y = size * own.forwards, size * own.leftwards
    if own.inertial == 0:
        push_x, push_y = ux * push_x - uy * push_y, uy * push_x + ux * push_y
    moved[AX, i] += push_x * bars[INVERSE_MASS, i]
    moved[AY, i] += push_y * bars[INVERSE_MASS, i]
    rows[ANGULAR, i] += own.side * bars[LEVER, i] * (ux * push_y - uy * push_x)


Library("thrust", (add_effect,))
