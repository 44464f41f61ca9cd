/* Effects of a chain: each adds its accelerations, by one function of its own file.
 *
 * An effect's file defines its constants, as effects.py packs them, and
 *
 *     add(own, t_s, y, s)      adds accelerations to rows A (central ones to rows G) and to the common part, and
 *                              angular accelerations to row ANGULAR;
 *     ended(own, t_s, y, s)    for effects with state events: whether an event function of the present mode is negative.
 *
 * Modes (the face in the wind, light or shadow, a segment of a table) are set by the caller.
 */
#ifndef EFFECT_H
#define EFFECT_H

#include "../chain/positions.h"
#include "../kernel.h"

/* Rows of workspace.effect_bars: A, noncentral accelerations minus the common part; V, velocities of the centres from
 * the first bar's, computed by the effects that use them. */
enum effect_rows { AX, AY, VX, VY };

/* Items of workspace.effect_common: acceleration common to all bars, its noncentral part, and the centre of mass from
 * the first bar's centre, computed with rows D. */
enum effect_sums { COMMON_X, COMMON_Y, NONCENTRAL_X, NONCENTRAL_Y, MEAN_X, MEAN_Y };

/* What an effect reads and writes; row pointers are (n,) each. */
typedef struct {
    int64_t n;
    real mu_m3_s2;
    const real *half, *weight, *inverse_mass, *lever, *inverse_inertia; /* of the bars */
    const real *bars, *rows;                                            /* whole, for positions.h */
    const real *ux, *uy, *dx, *dy;                                      /* d from the first bar's centre */
    real *gx, *gy, *angular;
    real *ax, *ay, *vx, *vy;
    real *common;
    real mean_x, mean_y;
} scene;

static inline scene scene_of(const chain *chain, const workspace *work, real mean_x, real mean_y)
{
    int64_t n = chain->bars.columns;
    const real *bars = chain->bars.value;
    real *rows = work->bars.value, *moved = work->effect_bars.value;
    return (scene){
        .n = n, .mu_m3_s2 = chain->mu_m3_s2,
        .half = bars + HALF * n, .weight = bars + WEIGHT * n, .inverse_mass = bars + INVERSE_MASS * n,
        .lever = bars + LEVER * n, .inverse_inertia = bars + INVERSE_INERTIA * n, .bars = bars, .rows = rows,
        .ux = rows + UX * n, .uy = rows + UY * n, .dx = rows + DX * n, .dy = rows + DY * n,
        .gx = rows + GX * n, .gy = rows + GY * n, .angular = rows + ANGULAR * n,
        .ax = moved + AX * n, .ay = moved + AY * n, .vx = moved + VX * n, .vy = moved + VY * n,
        .common = work->effect_common.value, .mean_x = mean_x, .mean_y = mean_y,
    };
}

#endif
