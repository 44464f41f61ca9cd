"""Joint reactions in O(N): two simultaneous sweeps from both ends of the chain to its middle.

The part of a chain up to the right end of one of its bars responds to a force F there with the acceleration a + Y F; Y
(2x2) is its mobility. The next bar has, at its own ends,

    A = w I + c n nᵀ (an end and a force on it),  X = w I - c n nᵀ (an end and a force on the other).

Joining the bar gives the reaction in between as R = S⁻¹ (g_left - a) + S⁻¹ X R_next with S = Y + A, and a mobility of
the longer part

    Y' = A - X S⁻¹ X = 4wc/(w+c) n nᵀ + B Y S⁻¹ X,  B = X A⁻¹ = I - 2c/(w+c) n nᵀ.

The second form contains no difference of large terms. Mass ratios along the chain cost no more digits than the system's
condition number, and the division runs beside the products. Two sweeps halve the chain of dependent operations.
Ill-conditioned chains (:attr:`reference_impl.model.chain.ChainModel.ill_conditioned`) are solved by
:mod:`reference_impl.fast.cholesky`, unless a pivot is lost. Their reactions are refined, as are all reactions at
samples. Notation: w = 1/m, c = l²/(4J), n the unit vector across the bar. The system is that of
:mod:`reference_impl.model.joints`.
"""

from __future__ import annotations

from reference_impl.fast.cholesky import solve_by_cholesky
from reference_impl.fast.layout import (
    BX,
    BY,
    COMPLIANCE,
    DX,
    DY,
    FREED,
    HXX,
    HXY,
    HYX,
    HYY,
    ILL_CONDITIONED,
    INVERSE_MASS,
    KXX,
    KXY,
    KYY,
    LEFT,
    LEFT_Y,
    PASSED,
    PX,
    PY,
    RIGHT,
    RIGHT_Y,
    RX,
    RY,
    UX,
    UY,
)  # fmt: skip
from reference_impl.machine_code.functions import compiled, inlined
from reference_impl.machine_code.structs import Matrix
from reference_impl.model.joints import CONVERGED, DIVERGED, REFINEMENTS, ROUNDING

SubChain = tuple[float, float, float, float, float, bool]
"""Mobility (xx, xy, yy) and free acceleration (x, y) of a part's end, and whether all pivots are positive."""


@inlined
def single_bar(i: int, far: int, bars: Matrix, rows: Matrix) -> SubChain:
    """Bar `i` alone, at the end whose rows begin with `far`: LEFT or RIGHT."""
    w = bars[INVERSE_MASS, i]
    return w + rows[KXX, i], rows[KXY, i], w + rows[KYY, i], rows[far, i], rows[far + 1, i], True


@inlined
def join_bar(sub: SubChain, i: int, joint: int, near: int, far: int, bars: Matrix, rows: Matrix) -> SubChain:
    """Join bar `i` by its end `near` to a part; the result is at its end `far`. Stores P and H of the joint."""
    yxx, yxy, yyy, free_x, free_y, well = sub
    w, kxx, kxy, kyy = bars[INVERSE_MASS, i], rows[KXX, i], rows[KXY, i], rows[KYY, i]
    sxx, sxy, syy = yxx + (w + kxx), yxy + kxy, yyy + (w + kyy)
    determinant = sxx * syy - sxy * sxy
    inverse = 1.0 / determinant
    xxx, xyy = w - kxx, w - kyy  # X, whose xy is -kxy
    hxx, hxy = (syy * xxx + sxy * kxy) * inverse, -(syy * kxy + sxy * xyy) * inverse
    hyx, hyy = -(sxx * kxy + sxy * xxx) * inverse, (sxx * xyy + sxy * kxy) * inverse
    apart_x, apart_y = rows[near, i] - free_x, rows[near + 1, i] - free_y
    px, py = (syy * apart_x - sxy * apart_y) * inverse, (sxx * apart_y - sxy * apart_x) * inverse
    rows[PX, joint], rows[PY, joint] = px, py
    rows[HXX, joint], rows[HXY, joint], rows[HYX, joint], rows[HYY, joint] = hxx, hxy, hyx, hyy
    passed, freed = bars[PASSED, i], bars[FREED, i]
    bxx, bxy = yxx - passed * (kxx * yxx + kxy * yxy), yxy - passed * (kxx * yxy + kxy * yyy)
    byx, byy = yxy - passed * (kxy * yxx + kyy * yxy), yyy - passed * (kxy * yxy + kyy * yyy)
    return (
        freed * kxx + (bxx * hxx + bxy * hyx),
        freed * kxy + (bxx * hxy + bxy * hyy),
        freed * kyy + (byx * hxy + byy * hyy),
        rows[far, i] - (xxx * px - kxy * py),
        rows[far + 1, i] - (xyy * py - kxy * px),
        well and not determinant <= ROUNDING * (sxx * syy),  # the stepper detects NaN
    )


@inlined
def back_substitute(joint: int, x: float, y: float, side: float, rows: Matrix) -> tuple[float, float]:
    """Reaction in `joint` from that in its neighbour nearer to the middle."""
    return (
        side * rows[PX, joint] + (rows[HXX, joint] * x + rows[HXY, joint] * y),
        side * rows[PY, joint] + (rows[HYX, joint] * x + rows[HYY, joint] * y),
    )


@inlined
def reactions(n: int, bars: Matrix, rows: Matrix) -> bool:
    """Rows RX, RY: force on bar j from bar j+1, by rows LEFT, RIGHT and K; False if a pivot is lost in round-off."""
    if n == 1:
        return True
    if bars[ILL_CONDITIONED, 0] != 0.0 and solve_by_cholesky(n, bars, rows):
        return True
    return solve_by_sweeps(n, bars, rows)


@inlined
def solve_by_sweeps(n: int, bars: Matrix, rows: Matrix) -> bool:
    """Rows RX, RY by the sweeps; False if a pivot is lost in round-off."""
    last, middle = n - 1, (n - 1) // 2
    both = last - 1 - middle  # joints that both sweeps process at once
    left, right = single_bar(0, RIGHT, bars, rows), single_bar(last, LEFT, bars, rows)
    for k in range(both):
        left = join_bar(left, k + 1, k, LEFT, RIGHT, bars, rows)
        right = join_bar(right, last - 1 - k, last - 1 - k, RIGHT, LEFT, bars, rows)
    if middle > both:
        left = join_bar(left, middle, middle - 1, LEFT, RIGHT, bars, rows)
    sxx, sxy, syy = left[0] + right[0], left[1] + right[1], left[2] + right[2]
    determinant = sxx * syy - sxy * sxy
    apart_x, apart_y = right[3] - left[3], right[4] - left[4]
    x, y = (syy * apart_x - sxy * apart_y) / determinant, (sxx * apart_y - sxy * apart_x) / determinant
    rows[RX, middle], rows[RY, middle] = x, y
    right_x, right_y = x, y
    if middle > both:
        x, y = back_substitute(middle - 1, x, y, 1.0, rows)
        rows[RX, middle - 1], rows[RY, middle - 1] = x, y
    for k in range(both):
        j, i = both - 1 - k, middle + 1 + k
        x, y = back_substitute(j, x, y, 1.0, rows)
        right_x, right_y = back_substitute(i, right_x, right_y, -1.0, rows)
        rows[RX, j], rows[RY, j] = x, y
        rows[RX, i], rows[RY, i] = right_x, right_y
    return left[5] and right[5] and not determinant <= ROUNDING * (sxx * syy)


@compiled
def refine(n: int, bars: Matrix, rows: Matrix) -> bool:
    """Iterative refinement, as in :meth:`reference_impl.model.joints.JointSystem.solve`.

    Rows B keep the relative accelerations of the joined ends without reactions; rows LEFT become the residuals.
    """
    for j in range(n - 1):
        rows[BX, j], rows[BY, j] = rows[LEFT, j + 1] - rows[RIGHT, j], rows[LEFT_Y, j + 1] - rows[RIGHT_Y, j]
    well, correction, total = True, 0.0, 0.0
    for _ in range(REFINEMENTS):
        residual_openings(n, bars, rows)
        well = reactions(n, bars, rows) and well
        correction = total = 0.0
        for j in range(n - 1):
            correction = max(correction, abs(rows[RX, j]), abs(rows[RY, j]))
            rows[RX, j] += rows[DX, j]
            rows[RY, j] += rows[DY, j]
            total = max(total, abs(rows[RX, j]), abs(rows[RY, j]))
        if not correction > CONVERGED * total:
            break
    return well and not correction > DIVERGED * total


@compiled
def residual_openings(n: int, bars: Matrix, rows: Matrix) -> None:
    """Rows LEFT of the bars right of each joint: residual relative accelerations under the reactions, copied to rows D.

    Neighbouring reactions are subtracted before any multiplication: the difference of nearly equal reactions is exact.
    """
    before_x = before_y = pulled_x = pulled_y = swung_x = swung_y = 0.0
    for i in range(n):
        x, y = (rows[RX, i], rows[RY, i]) if i < n - 1 else (0.0, 0.0)
        rows[DX, i], rows[DY, i] = x, y
        turned = bars[COMPLIANCE, i] * (rows[UX, i] * (y + before_y) - rows[UY, i] * (x + before_x))
        pull_x, pull_y = bars[INVERSE_MASS, i] * (x - before_x), bars[INVERSE_MASS, i] * (y - before_y)
        swing_x, swing_y = -turned * rows[UY, i], turned * rows[UX, i]
        rows[RIGHT, i] = rows[RIGHT_Y, i] = rows[LEFT, i] = rows[LEFT_Y, i] = 0.0
        if i > 0:
            rows[LEFT, i] = rows[BX, i - 1] + ((pull_x - pulled_x) - (swing_x + swung_x))
            rows[LEFT_Y, i] = rows[BY, i - 1] + ((pull_y - pulled_y) - (swing_y + swung_y))
        before_x, before_y, pulled_x, pulled_y, swung_x, swung_y = x, y, pull_x, pull_y, swing_x, swing_y
