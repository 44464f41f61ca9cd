/* Central gravity on the bars, as reference_impl/model/gravity.py, in closed form, and the bars' free ends.
 *
 * With s = 1 + q, Encke's change s^(-3/2) - 1 is -q (3 + 3q + q^2)/(s^(3/2) (1 + s^(3/2))). No digits are lost for any
 * small q. One root and one division serve field and gradient torque of a bar.
 */
#ifndef GRAVITY_H
#define GRAVITY_H

#include "arithmetic.h"
#include "layout.h"

/* Rows G: g(Z0 + d_j) - g(Z0), m/s^2; row ANGULAR: K_j/J_j, rad/s^2, eq. (17); returns mu/r^3 of the centre of mass. */
static inline real gravity(int64_t n, int64_t model, real mu, real com_x, real com_y, real mean_x, real mean_y,
                           real *restrict rows)
{
    const real *restrict ux = rows + UX * n, *restrict uy = rows + UY * n;
    const real *restrict dx = rows + DX * n, *restrict dy = rows + DY * n;
    real *restrict gx = rows + GX * n, *restrict gy = rows + GY * n, *restrict angular = rows + ANGULAR * n;
    real inverse2 = 1.0 / (com_x * com_x + com_y * com_y);
    real pull = mu * inverse2 * root(inverse2);
    real torque = model == GRADIENT ? 3.0 * pull * inverse2 : every(0.0);
#pragma GCC ivdep
    for (int64_t i = 0; i < n; i++) {
        real x = dx[i] - mean_x, y = dy[i] - mean_y;
        real q = ((2.0 * com_x + x) * x + (2.0 * com_y + y) * y) * inverse2;
        real s = 1.0 + q;
        real cube = s * root(s); /* (r_j/r)^3 */
        real inverse = 1.0 / (s * cube * (1.0 + cube));
        real nearer = q * (3.0 + q * (3.0 + q)) * inverse * s; /* 1 - (r/r_j)^3 */
        real faded = inverse * s * (1.0 + cube);               /* (r/r_j)^3 */
        gx[i] = pull * (com_x * nearer - x * faded);
        gy[i] = pull * (com_y * nearer - y * faded);
        real up = ux[i] * (com_x + x) + uy[i] * (com_y + y);    /* r_j sin(phi) */
        real level = ux[i] * (com_y + y) - uy[i] * (com_x + x); /* r_j cos(phi) */
        angular[i] = torque * up * level * (inverse * (1.0 + cube));
    }
    return pull;
}

/* Rows G and ANGULAR of free motion. */
static inline void no_gravity(int64_t n, real *rows)
{
    for (int64_t i = 0; i < n; i++)
        rows[GX * n + i] = rows[GY * n + i] = rows[ANGULAR * n + i] = every(0.0);
}

/* Z0'' = g(Z0) + the mean of the differences from g(Z0), eqs. (9), (11); `pull` is mu/r^3, 0 without gravity. */
static inline void com_acceleration(int64_t n, real pull, const real *restrict bars, const real *restrict com,
                                    const real *restrict rows, real *restrict found)
{
    const real *weight = bars + WEIGHT * n, *gx = rows + GX * n, *gy = rows + GY * n;
    real mean_x = every(0.0), mean_y = mean_x;
    for (int64_t i = 0; i < n; i++) {
        mean_x += weight[i] * gx[i];
        mean_y += weight[i] * gy[i];
    }
    found[0] = mean_x - pull * com[0];
    found[1] = mean_y - pull * com[1];
}

/* Rows LEFT and RIGHT: accelerations of the bars' ends without reactions; rows K: c n n^T. */
static inline void end_accelerations(int64_t n, const real *restrict bars, const real *restrict rate,
                                     real *restrict rows)
{
    const real *restrict half = bars + HALF * n, *restrict compliance = bars + COMPLIANCE * n;
    const real *restrict ux = rows + UX * n, *restrict uy = rows + UY * n, *restrict angular = rows + ANGULAR * n;
    const real *restrict gx = rows + GX * n, *restrict gy = rows + GY * n;
    real *restrict left_x = rows + LEFT * n, *restrict left_y = rows + LEFT_Y * n;
    real *restrict right_x = rows + RIGHT * n, *restrict right_y = rows + RIGHT_Y * n;
    real *restrict kxx = rows + KXX * n, *restrict kxy = rows + KXY * n, *restrict kyy = rows + KYY * n;
#pragma GCC ivdep
    for (int64_t i = 0; i < n; i++) {
        real centripetal = rate[i] * rate[i];
        real ex = -half[i] * (uy[i] * angular[i] + ux[i] * centripetal);
        real ey = half[i] * (ux[i] * angular[i] - uy[i] * centripetal);
        left_x[i] = gx[i] - SHARE(ALPHA, i) * ex;
        left_y[i] = gy[i] - SHARE(ALPHA, i) * ey;
        right_x[i] = gx[i] + SHARE(BETA, i) * ex;
        right_y[i] = gy[i] + SHARE(BETA, i) * ey;
        real cx = -compliance[i] * uy[i], cy = compliance[i] * ux[i];
        kxx[i] = -cx * uy[i];
        kxy[i] = cx * ux[i];
        kyy[i] = cy * ux[i];
    }
}

#endif
