/* Force on the bars' second moments, as reference_impl/effects/quadrupole.py; gravity adds the torque. */
#ifndef QUADRUPOLE_H
#define QUADRUPOLE_H

#include "second_moment.h"

static void add_quadrupole(const void *unused, real t_s, const real *y, const scene *s)
{
    (void)unused, (void)t_s;
    real com_x = y[s->n], com_y = y[s->n + 1];
    for (int64_t i = 0; i < s->n; i++) {
        real x = com_x + (s->dx[i] - s->mean_x), z = com_y + (s->dy[i] - s->mean_y);
        real gyration2 = s->inverse_mass[i] / s->inverse_inertia[i];
        pair pushed = second_moment_acceleration(s->mu_m3_s2, x, z, s->ux[i], s->uy[i], gyration2);
        s->ax[i] += pushed.x;
        s->ay[i] += pushed.y;
    }
}

#endif
