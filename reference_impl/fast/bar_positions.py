"""Positions and velocities of the bars' centres, summed from the first bar."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reference_impl.fast.layout import DX, DY, HALF, UX, UY, VX, VY, WEIGHT
from reference_impl.machine_code.functions import inlined

if TYPE_CHECKING:
    from reference_impl.machine_code.structs import Matrix, Vector


@inlined
def centres_from_first(n: int, bars: Matrix, rows: Matrix) -> tuple[float, float]:
    """Rows DX, DY: centres of the bars from the first bar's, eq. (7'); returns the centre of mass from there."""
    x = y = mean_x = mean_y = 0.0
    left_x, left_y = bars[HALF, 0] * rows[UX, 0], bars[HALF, 0] * rows[UY, 0]
    rows[DX, 0] = rows[DY, 0] = 0.0
    for i in range(1, n):
        right_x, right_y = bars[HALF, i] * rows[UX, i], bars[HALF, i] * rows[UY, i]
        x += left_x + right_x
        y += left_y + right_y
        rows[DX, i], rows[DY, i] = x, y
        mean_x += bars[WEIGHT, i] * x
        mean_y += bars[WEIGHT, i] * y
        left_x, left_y = right_x, right_y
    return mean_x, mean_y


@inlined
def velocities_from_first(n: int, y: Vector, bars: Matrix, rows: Matrix, moved: Matrix) -> tuple[float, float]:
    """Rows VX, VY of `moved`: velocities of the centres from the first bar's; returns that of the centre of mass."""
    vx = vy = mean_x = mean_y = 0.0
    reach = bars[HALF, 0] * y[n + 2]
    left_x, left_y = -reach * rows[UY, 0], reach * rows[UX, 0]
    moved[VX, 0] = moved[VY, 0] = 0.0
    for i in range(1, n):
        reach = bars[HALF, i] * y[n + 2 + i]
        right_x, right_y = -reach * rows[UY, i], reach * rows[UX, i]
        vx += left_x + right_x
        vy += left_y + right_y
        moved[VX, i], moved[VY, i] = vx, vy
        mean_x += bars[WEIGHT, i] * vx
        mean_y += bars[WEIGHT, i] * vy
        left_x, left_y = right_x, right_y
    return mean_x, mean_y
