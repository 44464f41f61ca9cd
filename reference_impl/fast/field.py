"""Gravity and effects on the bars, as in :mod:`reference_impl.model.gravity`, in closed form.

With s = 1 + q, Encke's change s^(-3/2) - 1 is -q (3 + 3q + q²)/(s^(3/2) (1 + s^(3/2))). No digits are lost for any
small q. One root and one division serve field and gradient torque of a bar.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from reference_impl.fast.bar_positions import centres_from_first
from reference_impl.fast.effect_calls import add_effects
from reference_impl.fast.layout import (
    ANGULAR,
    COMPLIANCE,
    DX,
    DY,
    GRADIENT,
    GX,
    GY,
    HALF,
    KXX,
    KXY,
    KYY,
    LEFT,
    LEFT_Y,
    NO_GRAVITY,
    RIGHT,
    RIGHT_Y,
    UX,
    UY,
    CompiledChain,
    Workspace,
)  # fmt: skip
from reference_impl.machine_code.functions import inlined

if TYPE_CHECKING:
    from reference_impl.machine_code.structs import Matrix, Vector


@inlined
def gravity(
    n: int, chain: CompiledChain, com_x: float, com_y: float, mean_x: float, mean_y: float, rows: Matrix
) -> None:
    """Rows GX, GY: g(Z0 + d_j) - g(Z0), m/s²; row ANGULAR: K_j/J_j, rad/s², eq. (17)."""
    inverse2 = 1.0 / (com_x * com_x + com_y * com_y)
    pull = chain.mu_m3_s2 * inverse2 * math.sqrt(inverse2)
    torque = 3.0 * pull * inverse2 if chain.gravity == GRADIENT else 0.0
    for i in range(n):
        x, y = rows[DX, i] - mean_x, rows[DY, i] - mean_y
        q = ((2.0 * com_x + x) * x + (2.0 * com_y + y) * y) * inverse2
        s = 1.0 + q
        cube = s * math.sqrt(s)  # (r_j/r)³
        inverse = 1.0 / (s * cube * (1.0 + cube))
        nearer = q * (3.0 + q * (3.0 + q)) * inverse * s  # 1 - (r/r_j)³
        faded = inverse * s * (1.0 + cube)  # (r/r_j)³
        rows[GX, i] = pull * (com_x * nearer - x * faded)
        rows[GY, i] = pull * (com_y * nearer - y * faded)
        up = rows[UX, i] * (com_x + x) + rows[UY, i] * (com_y + y)  # r_j sin(phi)
        level = rows[UX, i] * (com_y + y) - rows[UY, i] * (com_x + x)  # r_j cos(phi)
        rows[ANGULAR, i] = torque * up * level * (inverse * (1.0 + cube))


@inlined
def no_gravity(n: int, rows: Matrix) -> None:
    """Rows GX, GY, ANGULAR of free motion."""
    for i in range(n):
        rows[GX, i] = rows[GY, i] = rows[ANGULAR, i] = 0.0


@inlined
def forces(n: int, t_s: float, chain: CompiledChain, y: Vector, work: Workspace) -> None:
    """External accelerations of the bars, without reactions: rows U, D, G, ANGULAR, LEFT, RIGHT and K."""
    rows, mean_x, mean_y = work.bars, 0.0, 0.0
    if chain.gravity == NO_GRAVITY:
        no_gravity(n, rows)
    else:
        mean_x, mean_y = centres_from_first(n, chain.bars, rows)
        gravity(n, chain, y[n], y[n + 1], mean_x, mean_y, rows)
    if len(chain.effects) > 0:
        add_effects(n, t_s, y, mean_x, mean_y, chain, work)
    end_accelerations(n, chain, y, rows)


@inlined
def end_accelerations(n: int, chain: CompiledChain, y: Vector, rows: Matrix) -> None:
    """Rows LEFT and RIGHT: accelerations of the bars' ends without reactions; rows K: c n nᵀ."""
    for i in range(n):
        ux, uy, half, spin = rows[UX, i], rows[UY, i], chain.bars[HALF, i], rows[ANGULAR, i]
        centripetal = y[n + 2 + i] * y[n + 2 + i]
        ex, ey = -half * (uy * spin + ux * centripetal), half * (ux * spin - uy * centripetal)
        rows[LEFT, i], rows[LEFT_Y, i] = rows[GX, i] - ex, rows[GY, i] - ey
        rows[RIGHT, i], rows[RIGHT_Y, i] = rows[GX, i] + ex, rows[GY, i] + ey
        cx, cy = -chain.bars[COMPLIANCE, i] * uy, chain.bars[COMPLIANCE, i] * ux
        rows[KXX, i], rows[KXY, i], rows[KYY, i] = -cx * uy, cx * ux, cy * ux
