"""Joint reactions of ill-conditioned chains: block Cholesky from one end to the other.

The sweeps of :mod:`reference_impl.fast.joints` are faster, but propagate inverses. System entries may differ by 1e8 and
more: nearly massless or nearly point-like bars, straight or folded. Inverses then lose the small entries, and
refinement does not converge. Cholesky's pivots keep the small entries. The system is that of
:mod:`reference_impl.model.joints`.
"""

from __future__ import annotations

import math

from reference_impl.fast.layout import (
    HXX,
    HXY,
    HYX,
    HYY,
    INVERSE_MASS,
    KXX,
    KXY,
    KYY,
    LEFT,
    LEFT_Y,
    LXX,
    LXY,
    LYY,
    RIGHT,
    RIGHT_Y,
    RX,
    RY,
)
from reference_impl.machine_code.functions import compiled
from reference_impl.machine_code.structs import Matrix
from reference_impl.model.joints import ROUNDING


@compiled
def solve_by_cholesky(n: int, bars: Matrix, rows: Matrix) -> bool:
    """Reactions into rows RX, RY, from rows LEFT, RIGHT and K; False if a pivot is lost in round-off.

    Rows L hold each joint's factor, rows H the coupling to the next joint's block.
    """
    x = y = xx = xy = yy = 0.0
    for j in range(n - 1):
        w, other = bars[INVERSE_MASS, j], bars[INVERSE_MASS, j + 1]
        kxx, kxy, kyy = rows[KXX, j + 1], rows[KXY, j + 1], rows[KYY, j + 1]
        dxx, dxy, dyy = (w + other) + (rows[KXX, j] + kxx), rows[KXY, j] + kxy, (w + other) + (rows[KYY, j] + kyy)
        pivot = dxx - xx
        if pivot <= ROUNDING * dxx:  # the stepper detects NaN
            return False
        lxx = math.sqrt(pivot)
        lxy = (dxy - xy) / lxx
        pivot = (dyy - yy) - lxy * lxy
        if pivot <= ROUNDING * dyy:
            return False
        lyy = math.sqrt(pivot)
        zx = ((rows[LEFT, j + 1] - rows[RIGHT, j]) - x) / lxx
        zy = ((rows[LEFT_Y, j + 1] - rows[RIGHT_Y, j]) - y - lxy * zx) / lyy
        uxx, uyy = kxx - other, kyy - other
        hxx, hyx = uxx / lxx, kxy / lxx
        hxy, hyy = (kxy - lxy * hxx) / lyy, (uyy - lxy * hyx) / lyy
        rows[LXX, j], rows[LXY, j], rows[LYY, j] = lxx, lxy, lyy
        rows[HXX, j], rows[HXY, j], rows[HYX, j], rows[HYY, j] = hxx, hxy, hyx, hyy
        rows[RX, j], rows[RY, j] = zx, zy
        x, y = hxx * zx + hxy * zy, hyx * zx + hyy * zy
        xx, xy, yy = hxx * hxx + hxy * hxy, hxx * hyx + hxy * hyy, hyx * hyx + hyy * hyy
    x = y = 0.0
    for k in range(n - 1):
        j = n - 2 - k
        zx = rows[RX, j] - (rows[HXX, j] * x + rows[HYX, j] * y)
        zy = rows[RY, j] - (rows[HXY, j] * x + rows[HYY, j] * y)
        y = zy / rows[LYY, j]
        x = (zx - rows[LXY, j] * y) / rows[LXX, j]
        rows[RX, j], rows[RY, j] = x, y
    return True
