/* Positions and velocities of the bars' centres, summed from the first bar. */
#ifndef POSITIONS_H
#define POSITIONS_H

#include "arithmetic.h"
#include "layout.h"

typedef struct {
    real x, y;
} pair;

/* Rows D: centres of the bars from the first bar's, eq. (7'); returns the centre of mass from there. */
static inline pair centres_from_first(int64_t n, const real *restrict bars, real *restrict rows)
{
    const real *half = bars + HALF * n, *weight = bars + WEIGHT * n, *ux = rows + UX * n, *uy = rows + UY * n;
    real *dx = rows + DX * n, *dy = rows + DY * n;
    real x = every(0.0), y = x, mean_x = x, mean_y = x;
    real left_x = SHARE(BETA, 0) * (half[0] * ux[0]), left_y = SHARE(BETA, 0) * (half[0] * uy[0]);
    dx[0] = dy[0] = every(0.0);
    for (int64_t i = 1; i < n; i++) {
        real right_x = half[i] * ux[i], right_y = half[i] * uy[i];
        x += left_x + SHARE(ALPHA, i) * right_x;
        y += left_y + SHARE(ALPHA, i) * right_y;
        dx[i] = x;
        dy[i] = y;
        mean_x += weight[i] * x;
        mean_y += weight[i] * y;
        left_x = SHARE(BETA, i) * right_x;
        left_y = SHARE(BETA, i) * right_y;
    }
    return (pair){mean_x, mean_y};
}

/* Velocities of the centres from the first bar's into vx, vy; returns that of the centre of mass. */
static inline pair velocities_from_first(int64_t n, const real *rate, const real *bars, const real *rows, real *vx,
                                         real *vy)
{
    const real *half = bars + HALF * n, *weight = bars + WEIGHT * n, *ux = rows + UX * n, *uy = rows + UY * n;
    real x = every(0.0), y = x, mean_x = x, mean_y = x;
    real reach = half[0] * rate[0];
    real left_x = SHARE(BETA, 0) * (-reach * uy[0]), left_y = SHARE(BETA, 0) * (reach * ux[0]);
    vx[0] = vy[0] = every(0.0);
    for (int64_t i = 1; i < n; i++) {
        reach = half[i] * rate[i];
        real right_x = -reach * uy[i], right_y = reach * ux[i];
        x += left_x + SHARE(ALPHA, i) * right_x;
        y += left_y + SHARE(ALPHA, i) * right_y;
        vx[i] = x;
        vy[i] = y;
        mean_x += weight[i] * x;
        mean_y += weight[i] * y;
        left_x = SHARE(BETA, i) * right_x;
        left_y = SHARE(BETA, i) * right_y;
    }
    return (pair){mean_x, mean_y};
}

#endif
