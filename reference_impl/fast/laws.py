"""Prescribed rotations: torques by which bars follow their laws, eqs. (25)-(28), as in the NumPy reference."""

from __future__ import annotations

import math

from reference_impl.fast.effect_calls import add_noncentral_acceleration
from reference_impl.fast.joints import reactions, refine
from reference_impl.fast.layout import (
    AMPLITUDE,
    ANGULAR,
    BAR,
    DURATION,
    HALF,
    INVERSE_INERTIA,
    INVERSE_MASS,
    LEFT,
    LEFT_Y,
    LEVER,
    LOCAL,
    REACTS_ON,
    REFINED,
    RIGHT,
    RIGHT_Y,
    RX,
    RY,
    START,
    UNIT,
    UX,
    UY,
    WEIGHT,
    CompiledChain,
    Workspace,
)  # fmt: skip
from reference_impl.machine_code.functions import compiled
from reference_impl.machine_code.structs import Matrix, Vector


@compiled
def law_acceleration(law: Vector, t_s: float) -> float:
    """Second derivative of eq. (28), rad/s²."""
    progress = min(max((t_s - law[START]) / law[DURATION], 0.0), 1.0)
    x, w = math.pi * progress, math.pi / law[DURATION]
    return law[AMPLITUDE] / 16.0 * w * w * 9.0 * (math.cos(x) - math.cos(3.0 * x))


@compiled
def rotation_per_unit_torque(law: Vector, bar: int, bars: Matrix) -> float:
    """Angular acceleration of `bar` per unit torque of `law`, without reactions, 1/(kg m²)."""
    if bar == int(law[BAR]):
        return bars[INVERSE_INERTIA, bar]
    if bar == int(law[REACTS_ON]):
        return -bars[INVERSE_INERTIA, bar]
    return 0.0


@compiled
def unit_torque_reactions(n: int, chain: CompiledChain, work: Workspace) -> bool:
    """`Workspace.responses`: reactions to a unit of each prescribed torque, by the same sweeps."""
    rows, well = work.bars, True
    for k in range(len(chain.laws)):
        for i in range(n):
            turned = chain.bars[HALF, i] * rotation_per_unit_torque(chain.laws[k], i, chain.bars)
            rows[RIGHT, i], rows[RIGHT_Y, i] = -turned * rows[UY, i], turned * rows[UX, i]
            rows[LEFT, i], rows[LEFT_Y, i] = turned * rows[UY, i], -turned * rows[UX, i]
        well = reactions(n, chain.bars, rows) and well
        if chain.bars[REFINED, 0] != 0.0:
            well = refine(n, chain.bars, rows) and well
        for j in range(n - 1):
            work.responses[2 * k, j], work.responses[2 * k + 1, j] = rows[RX, j], rows[RY, j]
    return well


@compiled
def rotation_from_reactions(n: int, bar: int, x: Vector, y: Vector, chain: CompiledChain, rows: Matrix) -> float:
    """Angular acceleration of `bar` from reactions (x, y): (l/2J) n·(R_j + R_{j-1})."""
    sum_x = (x[bar] if bar < n - 1 else 0.0) + (x[bar - 1] if bar > 0 else 0.0)
    sum_y = (y[bar] if bar < n - 1 else 0.0) + (y[bar - 1] if bar > 0 else 0.0)
    return chain.bars[LEVER, bar] * (rows[UX, bar] * sum_y - rows[UY, bar] * sum_x)


@compiled
def actual_angle_acceleration(
    n: int, law: Vector, angular: float, x: Vector, y: Vector, place_x: float, place_y: float, chain: CompiledChain
) -> float:
    """Acceleration of the angle prescribed by `law`: the bar's, minus the longitude's for the local horizontal.

    Gravity is central. Only reactions and noncentral effects accelerate the bar's longitude; for effects see
    :func:`reference_impl.fast.effect_calls.add_noncentral_acceleration`.
    """
    if law[LOCAL] == 0.0:
        return angular
    bar = int(law[BAR])
    pull_x = (x[bar] if bar < n - 1 else 0.0) - (x[bar - 1] if bar > 0 else 0.0)
    pull_y = (y[bar] if bar < n - 1 else 0.0) - (y[bar - 1] if bar > 0 else 0.0)
    turned = chain.bars[INVERSE_MASS, bar] * (place_x * pull_y - place_y * pull_x)
    return angular - turned / (place_x * place_x + place_y * place_y)


@compiled
def bar_position_and_velocity(
    n: int, bar: int, y: Vector, chain: CompiledChain, rows: Matrix
) -> tuple[float, float, float, float]:
    """Position and velocity of a bar's centre from the centre of the body."""
    place_x = place_y = motion_x = motion_y = 0.0
    centre_x = centre_y = drift_x = drift_y = 0.0
    x = z = vx = vz = 0.0
    for i in range(n):
        half, rate = chain.bars[HALF, i], y[n + 2 + i]
        rx, rz = half * rows[UX, i], half * rows[UY, i]
        if i > 0:
            x, z, vx, vz = x + rx, z + rz, vx - rate * rz, vz + rate * rx
        if i == bar:
            place_x, place_y, motion_x, motion_y = x, z, vx, vz
        share = chain.bars[WEIGHT, i]
        centre_x, centre_y = centre_x + share * x, centre_y + share * z
        drift_x, drift_y = drift_x + share * vx, drift_y + share * vz
        x, z, vx, vz = x + rx, z + rz, vx - rate * rz, vz + rate * rx
    return (
        y[n] + (place_x - centre_x), y[n + 1] + (place_y - centre_y),
        y[2 * n + 2] + (motion_x - drift_x), y[2 * n + 3] + (motion_y - drift_y),
    )  # fmt: skip


@compiled
def prescribed_angle_acceleration(law: Vector, t_s: float, x: float, y: float, vx: float, vy: float) -> float:
    """Prescribed value of :func:`actual_angle_acceleration`.

    The value is the law's acceleration minus the velocity-dependent part of the longitude's, 2 (Z·Z')(Z×Z')/r⁴.
    """
    law_s2 = law_acceleration(law, t_s)
    if law[LOCAL] == 0.0:
        return law_s2
    r2 = x * x + y * y
    return law_s2 - 2.0 * (x * vx + y * vy) * (x * vy - y * vx) / (r2 * r2)


@compiled
def solve(matrix: Matrix, found: Vector) -> None:
    """Solve the small dense system [A | b] by Gaussian elimination with row pivots, in place."""
    size = len(found)
    for k in range(size):
        pivot = k
        for i in range(k + 1, size):
            if abs(matrix[i, k]) > abs(matrix[pivot, k]):
                pivot = i
        for j in range(k, size + 1):
            matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
        for i in range(k + 1, size):
            factor = matrix[i, k] / matrix[k, k]
            for j in range(k, size + 1):
                matrix[i, j] -= factor * matrix[k, j]
    for solved in range(size):
        k = size - 1 - solved
        total = matrix[k, size]
        for j in range(k + 1, size):
            total -= matrix[k, j] * found[j]
        found[k] = total / matrix[k, k]


@compiled
def apply_prescribed_torques(n: int, t_s: float, y: Vector, chain: CompiledChain, work: Workspace) -> None:
    """`Workspace.torque_N_m`, from the free reactions and the responses; adds the torques' part to the reactions."""
    rows, laws = work.bars, chain.laws
    free_x, free_y = rows[RX], rows[RY]
    for k in range(len(laws)):
        law, bar = laws[k], int(laws[k, BAR])
        x, z, vx, vz = bar_position_and_velocity(n, bar, y, chain, rows)
        angular = rows[ANGULAR, bar] + rotation_from_reactions(n, bar, free_x, free_y, chain, rows)
        lacking = prescribed_angle_acceleration(law, t_s, x, z, vx, vz) - actual_angle_acceleration(
            n, law, angular, free_x, free_y, x, z, chain
        )
        work.matrix[k, len(laws)] = law[UNIT] * lacking
        if len(chain.effects) > 0:
            add_noncentral_acceleration(k, law, x, z, work.matrix, work)
        for other in range(len(laws)):
            rx, rz = work.responses[2 * other], work.responses[2 * other + 1]
            turned = rotation_from_reactions(n, bar, rx, rz, chain, rows) + rotation_per_unit_torque(
                laws[other], bar, chain.bars
            )
            # nondimensional, as pivots chosen across bars of very different size lose the laws of light bars
            unit = law[UNIT] * laws[other, UNIT]
            work.matrix[k, other] = unit * actual_angle_acceleration(n, law, turned, rx, rz, x, z, chain)
    solve(work.matrix, work.torque_N_m)
    for k in range(len(laws)):
        work.torque_N_m[k] *= laws[k, UNIT]
        for j in range(n - 1):
            rows[RX, j] += work.torque_N_m[k] * work.responses[2 * k, j]
            rows[RY, j] += work.torque_N_m[k] * work.responses[2 * k + 1, j]
