/* J2 of the central body, as reference_impl/effects/oblateness.py.
 *
 * With s = 1 + q, Encke's change of the fifth power s^(-5/2) - 1 is -(s^5 - 1)/(s^(5/2) (1 + s^(5/2))), where s^5 - 1 is
 * a polynomial in q without a constant.
 */
#ifndef OBLATENESS_H
#define OBLATENESS_H

#include "effect.h"

typedef struct {
    double strength_m5_s2; /* B */
    int64_t turns;         /* 1 with torque on second moments */
    int64_t second_moment; /* 1 with force on second moments */
} oblateness;

/* Add 15 B (u.Z)(n.Z)/r^7, and (15 B J/2m r^7) (Z + 2 (u.Z) u - 7 c^2 Z) if `second_moment` is 1 instead of 0. */
static inline void add_oblateness_on_second_moments(const oblateness *own, const real *y, const scene *s)
{
    real com_x = y[s->n], com_y = y[s->n + 1], force = (real)own->second_moment;
    for (int64_t i = 0; i < s->n; i++) {
        real x = com_x + (s->dx[i] - s->mean_x), z = com_y + (s->dy[i] - s->mean_y);
        real ux = s->ux[i], uy = s->uy[i];
        real inverse2 = 1.0 / (x * x + z * z);
        real up = ux * x + uy * z, level = ux * z - uy * x;
        real seventh = own->strength_m5_s2 * inverse2 * inverse2 * inverse2 * root(inverse2);
        s->angular[i] += 15.0 * seventh * up * level;
        real share = force * 7.5 * seventh * s->inverse_mass[i] / s->inverse_inertia[i];
        real flat = 1.0 - 7.0 * up * up * inverse2;
        s->ax[i] += share * (2.0 * up * ux + flat * x);
        s->ay[i] += share * (2.0 * up * uy + flat * z);
    }
}

/* Add -3B Z/r^5, central; torque, and the noncentral force on second moments. */
static void add_oblateness(const void *constants, real t_s, const real *y, const scene *s)
{
    (void)t_s;
    const oblateness *own = constants;
    real com_x = y[s->n], com_y = y[s->n + 1];
    real inverse2 = 1.0 / (com_x * com_x + com_y * com_y);
    real pull = 3.0 * own->strength_m5_s2 * inverse2 * inverse2 * root(inverse2);
    s->common[COMMON_X] -= pull * com_x;
    s->common[COMMON_Y] -= pull * com_y;
    for (int64_t i = 0; i < s->n; i++) {
        real dx = s->dx[i] - s->mean_x, dy = s->dy[i] - s->mean_y;
        real q = ((2.0 * com_x + dx) * dx + (2.0 * com_y + dy) * dy) * inverse2;
        real stretched = 1.0 + q;
        real fifth = stretched * stretched * root(stretched); /* (r_j/r)^5 */
        real inverse = 1.0 / (fifth * (1.0 + fifth));
        real nearer = q * (5.0 + q * (10.0 + q * (10.0 + q * (5.0 + q)))) * inverse; /* 1 - (r/r_j)^5 */
        real faded = inverse * (1.0 + fifth);                                        /* (r/r_j)^5 */
        s->gx[i] += pull * (com_x * nearer - dx * faded);
        s->gy[i] += pull * (com_y * nearer - dy * faded);
    }
    if (own->turns)
        add_oblateness_on_second_moments(own, y, s);
}

#endif
