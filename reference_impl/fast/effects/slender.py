"""The exact pull on uniform slender bars, less that on point masses; as :mod:`reference_impl.effects.slender`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.fast.jit import inlined
from reference_impl.fast.layout import AX, AY, DX, DY, HALF, SPIN, UX, UY, Acting, numbers

if TYPE_CHECKING:
    from reference_impl.effects.slender import Slender
    from reference_impl.fast.layout import Chain, Work
    from reference_impl.model.arrays import Array


def acting(effect: Slender) -> Acting:
    """It has no numbers of its own."""
    return Acting(numbers(effect.name, {"nothing": 0.0}), np.zeros((0, 0)), np.zeros(0))


@inlined
def act(effect: Acting, n: int, t_s: float, y: Array, mean_x: float, mean_y: float, chain: Chain, work: Work) -> None:
    """Force and torque, of terms that are all small themselves: docs/effects/gravity.md."""
    rows, bars, moved, mu = work.bars, chain.bars, work.pushed.bars, chain.mu_m3_s2
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
        rows[SPIN, i] += 3.0 * strength * inverse2 * up * level / (outer * (1.0 + stretch))
