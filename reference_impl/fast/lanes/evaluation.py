"""One evaluation of the relative formulation for W chains of equal length.

The equations are those of :mod:`reference_impl.fast.accelerations` and :mod:`reference_impl.fast.field`. Reactions
follow from the mobilities of :mod:`reference_impl.fast.joints`, in one sweep from the first bar to the last instead of
two simultaneous sweeps.
"""

from __future__ import annotations

from reference_impl.fast.lanes.layout import (
    ANGULAR,
    BAR_ROWS,
    BLOCKS,
    DX,
    DY,
    HXX,
    HXY,
    HYX,
    HYY,
    MU,
    PX,
    PY,
    RX,
    RY,
    STATE,
    UX,
    UY,
)
from reference_impl.fast.layout import (
    COMPLIANCE,
    FREED,
    GRADIENT,
    HALF,
    INVERSE_MASS,
    LEVER,
    NO_GRAVITY,
    PASSED,
    WEIGHT,
)
from reference_impl.fast.trigonometry import (
    C1,
    C2,
    C3,
    C4,
    C5,
    C6,
    PART_1,
    PART_2,
    PART_3,
    PER_QUARTER,
    S1,
    S2,
    S3,
    S4,
    S5,
    S6,
)
from reference_impl.machine_code.functions import compiled, inlined
from reference_impl.machine_code.lanes import ROUNDER, Lanes, bits, digit, equal, get, put, root, select
from reference_impl.machine_code.structs import Matrix
from reference_impl.model.joints import ROUNDING


@compiled
def evaluate(n: int, gravity: int, at: int, to: int, g: Matrix) -> int:
    """Rates of the states in rows from `at` into rows from `to`; reactions into rows R.

    Parameters
    ----------
    n : int
        Number of bars.
    gravity : int
        One of `layout.GRAVITY_CODES`, equal for all chains.
    at, to : int
    g : ndarray, shape (rows, W)
        The group, see :mod:`reference_impl.fast.lanes.layout`.

    Returns
    -------
    int
        Bits of the lanes whose joint system is not positive definite in double precision.
    """
    bars = STATE + BLOCKS * (2 * n + 4)
    mean_x, mean_y = place_bars(n, at, bars, g)
    mean_x, mean_y = apply_gravity(n, gravity, at, mean_x, mean_y, bars, g)
    lost = join_bars(n, at, bars, g)
    turn_bars(n, to + n + 2, bars, g)
    for i in range(n + 2):
        put(g, to + i, get(g, at + n + 2 + i))
    put(g, to + 2 * n + 2, mean_x)
    put(g, to + 2 * n + 3, mean_y)
    return lost


@inlined
def place_bars(n: int, at: int, bars: int, g: Matrix) -> tuple[Lanes, Lanes]:
    """Rows U and D: unit vectors, and centres from the first bar's, eq. (7'); returns the centre of mass from there."""
    zero = equal(0.0)
    x, z, mean_x, mean_y, left_x, left_y = zero, zero, zero, zero, zero, zero
    for i in range(n):
        bar, angle = bars + BAR_ROWS * i, get(g, at + i)
        quarters = (angle * PER_QUARTER + ROUNDER) - ROUNDER
        r = ((angle - quarters * PART_1) - quarters * PART_2) - quarters * PART_3
        r2 = r * r
        sine = r + r * r2 * (S1 + r2 * (S2 + r2 * (S3 + r2 * (S4 + r2 * (S5 + r2 * S6)))))
        cosine = 1.0 - 0.5 * r2 + r2 * r2 * (C1 + r2 * (C2 + r2 * (C3 + r2 * (C4 + r2 * (C5 + r2 * C6)))))
        swap = digit(quarters, 0)
        up, along = select(swap, cosine, sine), select(swap, sine, cosine)
        uy, ux = select(digit(quarters, 1), -up, up), select(digit(quarters + 1.0, 1), -along, along)
        half, weight = get(g, bar + HALF), get(g, bar + WEIGHT)
        right_x, right_y = half * ux, half * uy
        if i > 0:
            x, z = x + (left_x + right_x), z + (left_y + right_y)
        put(g, bar + UX, ux)
        put(g, bar + UY, uy)
        put(g, bar + DX, x)
        put(g, bar + DY, z)
        mean_x, mean_y = mean_x + weight * x, mean_y + weight * z
        left_x, left_y = right_x, right_y
    return mean_x, mean_y


@inlined
def apply_gravity(
    n: int, gravity: int, at: int, mean_x: Lanes, mean_y: Lanes, bars: int, g: Matrix
) -> tuple[Lanes, Lanes]:
    """Rows D become g(Z0 + d_j) - g(Z0), m/s²; row ANGULAR: K_j/J_j, rad/s², eq. (17); returns Z0'', eqs. (9), (11)."""
    com_x, com_y, zero = get(g, at + n), get(g, at + n + 1), equal(0.0)
    if gravity == NO_GRAVITY:
        for i in range(n):
            bar = bars + BAR_ROWS * i
            put(g, bar + DX, zero)
            put(g, bar + DY, zero)
            put(g, bar + ANGULAR, zero)
        return zero, zero
    inverse2 = 1.0 / (com_x * com_x + com_y * com_y)
    pull = get(g, MU) * inverse2 * root(inverse2)
    torque = 3.0 * pull * inverse2 if gravity == GRADIENT else zero
    sum_x, sum_y = zero, zero
    for i in range(n):
        bar = bars + BAR_ROWS * i
        x, y = get(g, bar + DX) - mean_x, get(g, bar + DY) - mean_y
        q = ((2.0 * com_x + x) * x + (2.0 * com_y + y) * y) * inverse2
        s = 1.0 + q
        cube = s * root(s)  # (r_j/r)³
        inverse = 1.0 / (s * cube * (1.0 + cube))
        nearer = q * (3.0 + q * (3.0 + q)) * inverse * s  # 1 - (r/r_j)³
        faded = inverse * s * (1.0 + cube)  # (r/r_j)³
        gx, gy = pull * (com_x * nearer - x * faded), pull * (com_y * nearer - y * faded)
        ux, uy, weight = get(g, bar + UX), get(g, bar + UY), get(g, bar + WEIGHT)
        up = ux * (com_x + x) + uy * (com_y + y)  # r_j sin(phi)
        level = ux * (com_y + y) - uy * (com_x + x)  # r_j cos(phi)
        put(g, bar + DX, gx)
        put(g, bar + DY, gy)
        put(g, bar + ANGULAR, torque * up * level * (inverse * (1.0 + cube)))
        sum_x, sum_y = sum_x + weight * gx, sum_y + weight * gy
    return sum_x - pull * com_x, sum_y - pull * com_y


@inlined
def join_bars(n: int, at: int, bars: int, g: Matrix) -> int:
    """Rows P and H of the joint before each bar, by one sweep; returns the bits of lanes that lose a pivot.

    Y is the mobility of the part so far at its free end, and `free` the acceleration of that end.
    """
    zero, lost = equal(0.0), 0
    free_x, free_y, yxx, yxy, yyy = zero, zero, zero, zero, zero
    for i in range(n):
        bar = bars + BAR_ROWS * i
        ux, uy, spin, half = get(g, bar + UX), get(g, bar + UY), get(g, bar + ANGULAR), get(g, bar + HALF)
        gx, gy, rate = get(g, bar + DX), get(g, bar + DY), get(g, at + n + 2 + i)
        inward = rate * rate
        ex, ey = -half * (uy * spin + ux * inward), half * (ux * spin - uy * inward)
        w, c = get(g, bar + INVERSE_MASS), get(g, bar + COMPLIANCE)
        kxx, kxy, kyy = c * uy * uy, -(c * uy) * ux, c * ux * ux
        if i == 0:
            yxx, yxy, yyy, free_x, free_y = w + kxx, kxy, w + kyy, gx + ex, gy + ey
            continue
        sxx, sxy, syy = yxx + (w + kxx), yxy + kxy, yyy + (w + kyy)
        product = sxx * syy
        determinant = product - sxy * sxy
        inverse = 1.0 / determinant
        lost |= bits(determinant <= ROUNDING * product)  # NaN fails the error test of the step
        apart_x, apart_y = (gx - ex) - free_x, (gy - ey) - free_y
        px, py = (syy * apart_x - sxy * apart_y) * inverse, (sxx * apart_y - sxy * apart_x) * inverse
        put(g, bar + PX, px)
        put(g, bar + PY, py)
        if i == n - 1:
            break
        xxx, xyy = w - kxx, w - kyy  # X, whose xy is -kxy
        hxx, hxy = (syy * xxx + sxy * kxy) * inverse, -(syy * kxy + sxy * xyy) * inverse
        hyx, hyy = -(sxx * kxy + sxy * xxx) * inverse, (sxx * xyy + sxy * kxy) * inverse
        put(g, bar + HXX, hxx)
        put(g, bar + HXY, hxy)
        put(g, bar + HYX, hyx)
        put(g, bar + HYY, hyy)
        passed, freed = get(g, bar + PASSED), get(g, bar + FREED)
        bxx, bxy = yxx - passed * (kxx * yxx + kxy * yxy), yxy - passed * (kxx * yxy + kxy * yyy)
        byx, byy = yxy - passed * (kxy * yxx + kyy * yxy), yyy - passed * (kxy * yxy + kyy * yyy)
        yxx = freed * kxx + (bxx * hxx + bxy * hyx)
        yxy = freed * kxy + (bxx * hxy + bxy * hyy)
        yyy = freed * kyy + (byx * hxy + byy * hyy)
        free_x, free_y = (gx + ex) - (xxx * px - kxy * py), (gy + ey) - (xyy * py - kxy * px)
    return lost


@inlined
def turn_bars(n: int, to: int, bars: int, g: Matrix) -> None:
    """Rows R by substitution from the last joint, and the angular accelerations, eq. (15), into rows from `to`.

    The rows P and H of a bar belong to the joint before the bar, its row R to the joint after it.
    """
    zero = equal(0.0)
    after_x, after_y = zero, zero
    for k in range(n):
        i = n - 1 - k
        bar = bars + BAR_ROWS * i
        before_x, before_y = zero, zero
        if i > 0 and i == n - 1:
            before_x, before_y = get(g, bar + PX), get(g, bar + PY)
        elif i > 0:
            before_x = get(g, bar + PX) + (get(g, bar + HXX) * after_x + get(g, bar + HXY) * after_y)
            before_y = get(g, bar + PY) + (get(g, bar + HYX) * after_x + get(g, bar + HYY) * after_y)
        put(g, bar + RX, after_x)
        put(g, bar + RY, after_y)
        turned = get(g, bar + UX) * (after_y + before_y) - get(g, bar + UY) * (after_x + before_x)
        put(g, to + i, get(g, bar + ANGULAR) + get(g, bar + LEVER) * turned)
        after_x, after_y = before_x, before_y
