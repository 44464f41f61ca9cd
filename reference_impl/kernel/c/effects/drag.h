/* Drag, as reference_impl/effects/drag.py; the mode is the face of each bar in the wind. */
#ifndef DRAG_H
#define DRAG_H

#include "effect.h"

static const double EDGE_ON = 1e-12; /* an event function's margin at its zero, as reference_impl/model/effect.py */

typedef struct {
    double density_kg_m3;
    double radius_m;
    double scale_height_m;
    double rotation_rad_s;
    double normal_coefficient;
    double tangential_coefficient;
    vector width_m; /* (N,) */
    vector mode;    /* (N,) face in the wind: 1 or -1 */
} drag;

/* Add force and torque, integrated over each bar. */
static void add_drag(const void *constants, real t_s, const real *y, const scene *s)
{
    (void)t_s;
    const drag *own = constants;
    int64_t n = s->n;
    real com_x = y[n], com_y = y[n + 1], per_height = 1.0 / (real)own->scale_height_m, rotation = own->rotation_rad_s;
    real on_normal = own->normal_coefficient, on_tangent = own->tangential_coefficient;
    pair drift = velocities_from_first(n, y + n + 2, s->bars, s->rows, s->vx, s->vy);
    real r0 = root(com_x * com_x + com_y * com_y);
    real below = -0.5 * own->density_kg_m3 * exp_of((own->radius_m - r0) * per_height);
    for (int64_t i = 0; i < n; i++) {
        real dx = s->dx[i] - s->mean_x, dy = s->dy[i] - s->mean_y;
        real ux = s->ux[i], uy = s->uy[i], x = com_x + dx, z = com_y + dy;
        real wind_x = y[2 * n + 2] + (s->vx[i] - drift.x) + rotation * z;
        real wind_y = y[2 * n + 3] + (s->vy[i] - drift.y) - rotation * x;
        real t = ux * wind_x + uy * wind_y, v = ux * wind_y - uy * wind_x, w = y[n + 2 + i] - rotation;
        real r = root(x * x + z * z);
        real higher = ((2.0 * com_x + dx) * dx + (2.0 * com_y + dy) * dy) / (r + r0);
        real kappa = (ux * x + uy * z) / r * per_height, length = 2.0 * s->half[i];
        real second = length * length * length * ((real)1.0 / 12.0);
        real fourth = second * length * length * ((real)12.0 / 80.0);
        real strength = below * exp_of(-higher * per_height) * own->width_m.value[i] * own->mode.value[i];
        real across = strength * on_normal * (length * v * v + second * w * (w - 2.0 * kappa * v)) * s->inverse_mass[i];
        real along = strength * on_tangent * t * (length * v - kappa * second * w) * s->inverse_mass[i];
        s->ax[i] += along * ux - across * uy;
        s->ay[i] += along * uy + across * ux;
        real turned = strength * on_normal * (2.0 * second * v * w - kappa * (second * v * v + fourth * w * w));
        s->angular[i] += turned * s->inverse_inertia[i];
    }
}

/* Whether any bar meets the wind with its other face. */
static bool drag_mode_ended(void *constants, real t_s, const real *y, const scene *s)
{
    (void)t_s;
    const drag *own = constants;
    int64_t n = s->n;
    real rotation = own->rotation_rad_s, worst = 0.0;
    pair drift = velocities_from_first(n, y + n + 2, s->bars, s->rows, s->vx, s->vy);
    for (int64_t i = 0; i < n; i++) {
        real x = y[n] + (s->dx[i] - s->mean_x), z = y[n + 1] + (s->dy[i] - s->mean_y);
        real wind_x = y[2 * n + 2] + (s->vx[i] - drift.x) + rotation * z;
        real wind_y = y[2 * n + 3] + (s->vy[i] - drift.y) - rotation * x;
        real across = own->mode.value[i] * (s->ux[i] * wind_y - s->uy[i] * wind_x);
        worst = smaller(across + EDGE_ON * distance(wind_x, wind_y), worst);
    }
    return worst < 0.0;
}

#endif
