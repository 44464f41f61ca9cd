/* Exact gravity on uniform slender bars minus that on point masses, as reference_impl/effects/slender.py. */
#ifndef SLENDER_H
#define SLENDER_H

#include "effect.h"

/* Add force and torque, as sums of small terms: docs/effects/gravity.md. */
static void add_slender(const void *unused, real t_s, const real *y, const scene *s)
{
    (void)unused, (void)t_s;
    real com_x = y[s->n], com_y = y[s->n + 1];
    for (int64_t i = 0; i < s->n; i++) {
        real x = com_x + (s->dx[i] - s->mean_x), z = com_y + (s->dy[i] - s->mean_y);
        real ux = s->ux[i], uy = s->uy[i];
        real inverse2 = 1.0 / (x * x + z * z);
        real up = ux * x + uy * z, level = ux * z - uy * x;
        real e = s->half[i] * s->half[i] * inverse2, c2 = up * up * inverse2;
        real change = 2.0 * e * (1.0 - 2.0 * c2) + e * e;
        real delta = change / (1.0 + root(1.0 + change));
        real sigma = 0.5 * (e + delta), tau = 0.5 * (delta - e);
        real stretch = sigma / (1.0 + root(1.0 + sigma));
        real whole = delta + (1.0 + delta) * stretch, outer = (1.0 + tau) * (1.0 + delta);
        real strength = s->mu_m3_s2 * inverse2 * root(inverse2);
        real along = strength * up * whole / (1.0 + whole);
        real across = strength * level * (tau + delta + tau * delta - stretch) / outer;
        s->ax[i] += along * ux - across * uy;
        s->ay[i] += along * uy + across * ux;
        s->angular[i] += 3.0 * strength * inverse2 * up * level / (outer * (1.0 + stretch));
    }
}

#endif
