/* Third body, as reference_impl/effects/third_body.py, with Encke's change in closed form. */
#ifndef THIRD_BODY_H
#define THIRD_BODY_H

#include "second_moment.h"

typedef struct {
    double mu_m3_s2;
    double distance_m;
    double longitude_rad;
    double rate_rad_s;
    int64_t turns;         /* 1 with torque on second moments */
    int64_t second_moment; /* 1 with force on second moments */
} third_body;

/* 1 - (1 + q)^(-3/2), as in chain/gravity.h. */
static inline real encke_change(real q)
{
    real s = 1.0 + q, cube = s * root(s);
    return q * (3.0 + q * (3.0 + q)) / (cube * (1.0 + cube));
}

/* Add the acceleration at (x, y) minus that of the central body: (mu/D^3)(X ((1+q)^(-3/2) - 1) - Z (1+q)^(-3/2)). */
static inline void add_common_tide(real strength, real d2, real body_x, real body_y, real x, real y,
                                   real *common)
{
    real change = encke_change((x * x + y * y - 2.0 * (body_x * x + body_y * y)) / d2);
    real tide_x = -strength * (body_x * change + x * (1.0 - change));
    real tide_y = -strength * (body_y * change + y * (1.0 - change));
    common[COMMON_X] += tide_x;
    common[COMMON_Y] += tide_y;
    common[NONCENTRAL_X] += tide_x;
    common[NONCENTRAL_Y] += tide_y;
}

/* Add the tide at the centre of mass, the differences of the attraction, and the terms of second moments. */
static void add_third_body(const void *constants, real t_s, const real *y, const scene *s)
{
    const third_body *own = constants;
    real longitude = own->longitude_rad + own->rate_rad_s * t_s, d2 = own->distance_m * own->distance_m;
    real body_x = own->distance_m * cos_of(longitude), body_y = own->distance_m * sin_of(longitude);
    add_common_tide(own->mu_m3_s2 / (d2 * own->distance_m), d2, body_x, body_y, y[s->n], y[s->n + 1], s->common);
    real com_x = y[s->n] - body_x, com_y = y[s->n + 1] - body_y;
    real inverse2 = 1.0 / (com_x * com_x + com_y * com_y);
    real strength = own->mu_m3_s2 * inverse2 * root(inverse2);
    for (int64_t i = 0; i < s->n; i++) {
        real dx = s->dx[i] - s->mean_x, dy = s->dy[i] - s->mean_y;
        real change = encke_change(((2.0 * com_x + dx) * dx + (2.0 * com_y + dy) * dy) * inverse2);
        s->ax[i] += strength * (com_x * change - dx * (1.0 - change));
        s->ay[i] += strength * (com_y * change - dy * (1.0 - change));
    }
    for (int64_t i = 0; i < s->n && (own->turns || own->second_moment); i++) {
        real x = y[s->n] + (s->dx[i] - s->mean_x) - body_x, z = y[s->n + 1] + (s->dy[i] - s->mean_y) - body_y;
        if (own->turns)
            s->angular[i] += second_moment_spin(own->mu_m3_s2, x, z, s->ux[i], s->uy[i]);
        if (own->second_moment) {
            real gyration2 = s->inverse_mass[i] / s->inverse_inertia[i];
            pair pushed = second_moment_acceleration(own->mu_m3_s2, x, z, s->ux[i], s->uy[i], gyration2);
            s->ax[i] += pushed.x;
            s->ay[i] += pushed.y;
        }
    }
}

#endif
