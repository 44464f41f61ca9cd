"""Exact gravity on uniform slender bars minus that on point masses, as :mod:`reference_impl.effects.slender`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from reference_impl.fast.layout import (
    ANGULAR,
    AX,
    AY,
    DX,
    DY,
    HALF,
    UX,
    UY,
    CompiledChain,
    Workspace,
)
from reference_impl.machine_code.functions import compiled
from reference_impl.machine_code.library import Library
from reference_impl.machine_code.structs import Struct, Vector

if TYPE_CHECKING:
    from reference_impl.effects.slender import SlenderBarEffect


@dataclass(frozen=True)
class CompiledSlenderBars(Struct):
    """Effect without constants of its own."""


def constants(_: SlenderBarEffect) -> CompiledSlenderBars:
    """Struct without constants."""
    return CompiledSlenderBars()


@compiled
def add_effect(
    own: CompiledSlenderBars,
    n: int,
    t_s: float,
    y: Vector,
    mean_x: float,
    mean_y: float,
    chain: CompiledChain,
    work: Workspace,
) -> None:
    """Add force and torque, as sums of small terms: docs/effects/gravity.md."""
    rows, bars, moved, mu = work.bars, chain.bars, work.effect_bars, chain.mu_m3_s2
    com_x, com_y = y[n], y[n + 1]
    for i in range(n):
        x, z = com_x + (rows[DX, i] - mean_x), com_y + (rows[DY, i] - mean_y)
        ux, uy = rows[UX, i], rows[UY, i]
        inverse2 = 1.0 / (x * x + z * z)
        up, level = ux * x + uy * z, ux * z - uy * x
        e, c2 = bars[HALF, i] * bars[HALF, i] * inverse2, up * up * inverse2
        change = 2.0 * e * (1.0 - 2.0 * c2) + e * e
        delta = change / (1.0 + math.sqrt(1.0 + change))
        sigma, tau = 0.5 * (e + delta), 0.5 * (delta - e)
        stretch = sigma / (1.0 + math.sqrt(1.0 + sigma))
        whole, outer = delta + (1.0 + delta) * stretch, (1.0 + tau) * (1.0 + delta)
        strength = mu * inverse2 * math.sqrt(inverse2)
        along = strength * up * whole / (1.0 + whole)
        across = strength * level * (tau + delta + tau * delta - stretch) / outer
        moved[AX, i] += along * ux - across * uy
        moved[AY, i] += along * uy + across * ux
        rows[ANGULAR, i] += 3.0 * strength * inverse2 * up * level / (outer * (1.0 + stretch))


Library("slender", (add_effect,))
