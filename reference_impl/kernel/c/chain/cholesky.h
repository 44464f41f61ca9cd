/* Joint reactions of ill-conditioned chains: block Cholesky from one end to the other, and iterative refinement.
 *
 * The sweeps of joints.h are faster, but propagate inverses. System entries may differ by 1e8 and more: nearly massless
 * or nearly point-like bars, straight or folded. Inverses then lose the small entries, and refinement does not converge.
 * Cholesky's pivots keep the small entries. Reactions of ill-conditioned chains are refined, as are all reactions at
 * samples. The system, and the limits of refinement, are those of reference_impl/model/joints.py.
 */
#ifndef CHOLESKY_H
#define CHOLESKY_H

#include "joints.h"

static const int REFINEMENTS = 5;        /* at most; one is enough up to condition numbers of 1e8 */
static const double CONVERGED = 1e-10;   /* last correction over the reactions, after which refinement ends */
static const double DIVERGED = 1e-6;     /* last correction over the reactions, above which refinement has failed */

/* Rows R from rows LEFT, RIGHT and K; false if a pivot is lost in round-off.
 *
 * Rows L hold each joint's factor, rows H the coupling to the next joint's block.
 */
static bool solve_by_cholesky(int64_t n, const real *bars, real *rows)
{
    const real *kxx = rows + KXX * n, *kxy = rows + KXY * n, *kyy = rows + KYY * n;
    real *lxx = rows + LXX * n, *lxy = rows + LXY * n, *lyy = rows + LYY * n;
    real *hxx = rows + HXX * n, *hxy = rows + HXY * n, *hyx = rows + HYX * n, *hyy = rows + HYY * n;
    real *rx = rows + RX * n, *ry = rows + RY * n;
    real x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
    for (int64_t j = 0; j < n - 1; j++) {
        real w = bars[INVERSE_MASS * n + j], other = bars[INVERSE_MASS * n + j + 1];
        real beta = SHARE(BETA, j), alpha = SHARE(ALPHA, j + 1), mixed = alpha * SHARE(BETA, j + 1);
        beta *= beta;
        alpha *= alpha;
        real dxx = (w + other) + (beta * kxx[j] + alpha * kxx[j + 1]), dxy = beta * kxy[j] + alpha * kxy[j + 1];
        real dyy = (w + other) + (beta * kyy[j] + alpha * kyy[j + 1]);
        real pivot = dxx - xx;
        if (pivot <= ROUNDING * dxx) /* the stepper detects NaN */
            return false;
        lxx[j] = root(pivot);
        lxy[j] = (dxy - xy) / lxx[j];
        pivot = (dyy - yy) - lxy[j] * lxy[j];
        if (pivot <= ROUNDING * dyy)
            return false;
        lyy[j] = root(pivot);
        real zx = ((rows[LEFT * n + j + 1] - rows[RIGHT * n + j]) - x) / lxx[j];
        real zy = ((rows[LEFT_Y * n + j + 1] - rows[RIGHT_Y * n + j]) - y - lxy[j] * zx) / lyy[j];
        real uxx = mixed * kxx[j + 1] - other, uxy = mixed * kxy[j + 1], uyy = mixed * kyy[j + 1] - other;
        hxx[j] = uxx / lxx[j];
        hyx[j] = uxy / lxx[j];
        hxy[j] = (uxy - lxy[j] * hxx[j]) / lyy[j];
        hyy[j] = (uyy - lxy[j] * hyx[j]) / lyy[j];
        rx[j] = zx;
        ry[j] = zy;
        x = hxx[j] * zx + hxy[j] * zy;
        y = hyx[j] * zx + hyy[j] * zy;
        xx = hxx[j] * hxx[j] + hxy[j] * hxy[j];
        xy = hxx[j] * hyx[j] + hxy[j] * hyy[j];
        yy = hyx[j] * hyx[j] + hyy[j] * hyy[j];
    }
    x = y = 0.0;
    for (int64_t j = n - 2; j >= 0; j--) {
        real zx = rx[j] - (hxx[j] * x + hyx[j] * y), zy = ry[j] - (hxy[j] * x + hyy[j] * y);
        y = zy / lyy[j];
        x = (zx - lxy[j] * y) / lxx[j];
        rx[j] = x;
        ry[j] = y;
    }
    return true;
}

/* Rows R: force on bar j from bar j+1, by rows LEFT, RIGHT and K; false if a pivot is lost in round-off. */
static inline bool reactions(int64_t n, const real *bars, real *rows)
{
    if (n == 1)
        return true;
    if (bars[ILL_CONDITIONED * n] != 0.0 && solve_by_cholesky(n, bars, rows))
        return true;
    return !solve_by_sweeps(n, bars, rows);
}

/* Rows LEFT of the bars right of each joint: residual relative accelerations under the reactions, copied to rows D.
 *
 * Neighbouring reactions are subtracted before any multiplication: the difference of nearly equal reactions is exact.
 */
static void residual_openings(int64_t n, const real *bars, real *rows)
{
    const real *ux = rows + UX * n, *uy = rows + UY * n;
    real before_x = 0.0, before_y = 0.0, pulled_x = 0.0, pulled_y = 0.0, swung_x = 0.0, swung_y = 0.0;
    for (int64_t i = 0; i < n; i++) {
        real x = i < n - 1 ? rows[RX * n + i] : 0.0, y = i < n - 1 ? rows[RY * n + i] : 0.0;
        rows[DX * n + i] = x;
        rows[DY * n + i] = y;
        real sum_x = SHARE(BETA, i) * x + SHARE(ALPHA, i) * before_x;
        real sum_y = SHARE(BETA, i) * y + SHARE(ALPHA, i) * before_y;
        real turned = bars[COMPLIANCE * n + i] * (ux[i] * sum_y - uy[i] * sum_x);
        real pull_x = bars[INVERSE_MASS * n + i] * (x - before_x);
        real pull_y = bars[INVERSE_MASS * n + i] * (y - before_y);
        real swing_x = -turned * uy[i], swing_y = turned * ux[i];
        rows[RIGHT * n + i] = rows[RIGHT_Y * n + i] = rows[LEFT * n + i] = rows[LEFT_Y * n + i] = 0.0;
        if (i > 0) {
            rows[LEFT * n + i] = rows[BX * n + i - 1] + ((pull_x - pulled_x) - (SHARE(ALPHA, i) * swing_x + swung_x));
            rows[LEFT_Y * n + i] = rows[BY * n + i - 1] + ((pull_y - pulled_y) - (SHARE(ALPHA, i) * swing_y + swung_y));
        }
        before_x = x;
        before_y = y;
        pulled_x = pull_x;
        pulled_y = pull_y;
        swung_x = SHARE(BETA, i) * swing_x;
        swung_y = SHARE(BETA, i) * swing_y;
    }
}

/* Iterative refinement, as JointSystem.solve of reference_impl/model/joints.py.
 *
 * Rows B keep the relative accelerations of the joined ends without reactions; rows LEFT become the residuals.
 */
static bool refine(int64_t n, const real *bars, real *rows)
{
    real *rx = rows + RX * n, *ry = rows + RY * n;
    for (int64_t j = 0; j < n - 1; j++) {
        rows[BX * n + j] = rows[LEFT * n + j + 1] - rows[RIGHT * n + j];
        rows[BY * n + j] = rows[LEFT_Y * n + j + 1] - rows[RIGHT_Y * n + j];
    }
    bool well = true;
    real correction = 0.0, total = 0.0;
    for (int k = 0; k < REFINEMENTS; k++) {
        residual_openings(n, bars, rows);
        well = reactions(n, bars, rows) && well;
        correction = total = 0.0;
        for (int64_t j = 0; j < n - 1; j++) {
            correction = larger(magnitude(rx[j]), correction);
            correction = larger(magnitude(ry[j]), correction);
            rx[j] += rows[DX * n + j];
            ry[j] += rows[DY * n + j];
            total = larger(magnitude(rx[j]), total);
            total = larger(magnitude(ry[j]), total);
        }
        if (!(correction > CONVERGED * total))
            break;
    }
    return well && !(correction > DIVERGED * total);
}

#endif
