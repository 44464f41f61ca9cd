/* Joint reactions in O(N): two simultaneous sweeps from both ends of the chain to its middle.
 *
 * The part of a chain up to the right end of one of its bars responds to a force F there with the acceleration a + Y F;
 * Y (2x2) is its mobility. The next bar has, at its own ends,
 *
 *     A = w I + alpha^2 c n n^T (its near end and a force on it),  X = w I - alpha beta c n n^T (an end and a force on
 *     the other),  w I + beta^2 c n n^T (its far end).
 *
 * Joining the bar gives the reaction in between as R = S^-1 (g_left - a) + S^-1 X R_next with S = Y + A, and a mobility
 * of the longer part
 *
 *     Y' = 4wc/(w + alpha^2 c) n n^T + B Y S^-1 X,  B = X A^-1 = I - 2 alpha c/(w + alpha^2 c) n n^T.
 *
 * The second form contains no difference of large terms. Mass ratios along the chain cost no more digits than the
 * system's condition number, and the division runs beside the products. Two sweeps halve the chain of dependent
 * operations. Notation: w = 1/m, c = l^2/(4J), n the unit vector across the bar; alpha and beta = 2 - alpha are the
 * distances of its near and its far end from its centre of mass over l/2, both 1 where it is midway. The system,
 * eq. (23), is that of reference_impl/model/joints.py.
 */
#ifndef JOINTS_H
#define JOINTS_H

#include "arithmetic.h"
#include "layout.h"

static const number ROUNDING = 2.0 * EPSILON; /* pivot over its terms; one not above this may have either sign */

/* Part of a chain, as its open end moves: mobility, acceleration without force, and whether a pivot was lost. */
typedef struct {
    real xx, xy, yy, free_x, free_y;
    flag lost;
} part;

static inline part single_bar(int64_t n, int64_t i, int64_t far, const real *bars, const real *rows)
{
    real w = bars[INVERSE_MASS * n + i], beta = SHARE(far == RIGHT ? BETA : ALPHA, i), square = beta * beta;
    return (part){
        w + square * rows[KXX * n + i], square * rows[KXY * n + i], w + square * rows[KYY * n + i],
        rows[far * n + i], rows[(far + 1) * n + i], never(),
    };
}

/* Join bar i by its end `near` to a part; the result is at its end `far`. Stores P and H of the joint. */
static inline part join_bar(part sub, int64_t n, int64_t i, int64_t joint, int64_t near, int64_t far,
                            const real *restrict bars, real *restrict rows)
{
    real w = bars[INVERSE_MASS * n + i];
    real alpha = SHARE(near == LEFT ? ALPHA : BETA, i), beta = SHARE(near == LEFT ? BETA : ALPHA, i);
    real square = alpha * alpha, mixed = alpha * beta;
    real kxx = rows[KXX * n + i], kxy = rows[KXY * n + i], kyy = rows[KYY * n + i];
    real sxx = sub.xx + (w + square * kxx), sxy = sub.xy + square * kxy, syy = sub.yy + (w + square * kyy);
    real determinant = sxx * syy - sxy * sxy;
    real inverse = 1.0 / determinant;
    real txy = mixed * kxy;
    real xxx = w - mixed * kxx, xyy = w - mixed * kyy; /* X, whose xy is -txy */
    real hxx = (syy * xxx + sxy * txy) * inverse, hxy = -(syy * txy + sxy * xyy) * inverse;
    real hyx = -(sxx * txy + sxy * xxx) * inverse, hyy = (sxx * xyy + sxy * txy) * inverse;
    real apart_x = rows[near * n + i] - sub.free_x, apart_y = rows[(near + 1) * n + i] - sub.free_y;
    real px = (syy * apart_x - sxy * apart_y) * inverse, py = (sxx * apart_y - sxy * apart_x) * inverse;
    rows[PX * n + joint] = px;
    rows[PY * n + joint] = py;
    rows[HXX * n + joint] = hxx;
    rows[HXY * n + joint] = hxy;
    rows[HYX * n + joint] = hyx;
    rows[HYY * n + joint] = hyy;
#ifdef LEVERS
    int64_t passing = near == LEFT ? PASSED : PASSED_RIGHT, freeing = near == LEFT ? FREED : FREED_RIGHT;
#else
    int64_t passing = PASSED, freeing = FREED;
#endif
    real passed = bars[passing * n + i], freed = bars[freeing * n + i];
    real bxx = sub.xx - passed * (kxx * sub.xx + kxy * sub.xy), bxy = sub.xy - passed * (kxx * sub.xy + kxy * sub.yy);
    real byx = sub.xy - passed * (kxy * sub.xx + kyy * sub.xy), byy = sub.yy - passed * (kxy * sub.xy + kyy * sub.yy);
    return (part){
        freed * kxx + (bxx * hxx + bxy * hyx),
        freed * kxy + (bxx * hxy + bxy * hyy),
        freed * kyy + (byx * hxy + byy * hyy),
        rows[far * n + i] - (xxx * px - txy * py),
        rows[(far + 1) * n + i] - (xyy * py - txy * px),
        sub.lost | (determinant <= ROUNDING * (sxx * syy)), /* NaN fails the error test of the step */
    };
}

/* Reaction in `joint` from that in its neighbour nearer to the middle. */
static inline void back_substitute(int64_t n, int64_t joint, double side, real *x, real *y, const real *rows)
{
    real before_x = *x, before_y = *y;
    *x = side * rows[PX * n + joint] + (rows[HXX * n + joint] * before_x + rows[HXY * n + joint] * before_y);
    *y = side * rows[PY * n + joint] + (rows[HYX * n + joint] * before_x + rows[HYY * n + joint] * before_y);
}

/* Rows R: force on bar j from bar j+1, by rows LEFT, RIGHT and K, for n > 1; returns whether a pivot was lost. */
static inline flag solve_by_sweeps(int64_t n, const real *restrict bars, real *restrict rows)
{
    real *rx = rows + RX * n, *ry = rows + RY * n;
    int64_t last = n - 1, middle = (n - 1) / 2;
    int64_t both = last - 1 - middle; /* joints that both sweeps process at once */
    part left = single_bar(n, 0, RIGHT, bars, rows), right = single_bar(n, last, LEFT, bars, rows);
    for (int64_t k = 0; k < both; k++) {
        left = join_bar(left, n, k + 1, k, LEFT, RIGHT, bars, rows);
        right = join_bar(right, n, last - 1 - k, last - 1 - k, RIGHT, LEFT, bars, rows);
    }
    if (middle > both)
        left = join_bar(left, n, middle, middle - 1, LEFT, RIGHT, bars, rows);
    real sxx = left.xx + right.xx, sxy = left.xy + right.xy, syy = left.yy + right.yy;
    real determinant = sxx * syy - sxy * sxy;
    real apart_x = right.free_x - left.free_x, apart_y = right.free_y - left.free_y;
    real inverse = 1.0 / determinant;
    real x = (syy * apart_x - sxy * apart_y) * inverse, y = (sxx * apart_y - sxy * apart_x) * inverse;
    rx[middle] = x;
    ry[middle] = y;
    real right_x = x, right_y = y;
    if (middle > both) {
        back_substitute(n, middle - 1, 1.0, &x, &y, rows);
        rx[middle - 1] = x;
        ry[middle - 1] = y;
    }
    for (int64_t k = 0; k < both; k++) {
        int64_t j = both - 1 - k, i = middle + 1 + k;
        back_substitute(n, j, 1.0, &x, &y, rows);
        back_substitute(n, i, -1.0, &right_x, &right_y, rows);
        rx[j] = x;
        ry[j] = y;
        rx[i] = right_x;
        ry[i] = right_y;
    }
    return left.lost | right.lost | (determinant <= ROUNDING * (sxx * syy));
}

/* Angular accelerations under field and reactions, eq. (15). */
static inline void angular_accelerations(int64_t n, const real *restrict bars, const real *restrict rows,
                                         real *restrict found)
{
    const real *lever = bars + LEVER * n, *ux = rows + UX * n, *uy = rows + UY * n, *angular = rows + ANGULAR * n;
    const real *rx = rows + RX * n, *ry = rows + RY * n;
    real before_x = every(0.0), before_y = before_x;
#pragma GCC ivdep
    for (int64_t i = 0; i < n - 1; i++) {
        real sum_x = SHARE(BETA, i) * rx[i] + SHARE(ALPHA, i) * before_x;
        real sum_y = SHARE(BETA, i) * ry[i] + SHARE(ALPHA, i) * before_y;
        real turned = ux[i] * sum_y - uy[i] * sum_x;
        found[i] = angular[i] + lever[i] * turned;
        before_x = rx[i];
        before_y = ry[i];
    }
    real turned = SHARE(ALPHA, n - 1) * (ux[n - 1] * before_y - uy[n - 1] * before_x);
    found[n - 1] = angular[n - 1] + lever[n - 1] * turned;
}

#endif
