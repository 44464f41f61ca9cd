/* Solar radiation pressure, as reference_impl/effects/solar_pressure.py; the mode is light or shadow, and faces. */
#ifndef SOLAR_PRESSURE_H
#define SOLAR_PRESSURE_H

#include "drag.h"

typedef struct {
    double pressure_Pa;
    double longitude_rad;
    double rate_rad_s;
    double reflectivity;
    double shadow_radius_m; /* 0: no shadow */
    vector width_m;         /* (N,) */
    vector side_m;          /* (1,) previous distance from the shadow's axis */
    vector mode;            /* (1+N,) light 1 or shadow 0, and face of each bar */
} solar_pressure;

/* Unit vector to the Sun. */
static inline pair sun_direction(const solar_pressure *own, real t_s)
{
    real longitude = own->longitude_rad + own->rate_rad_s * t_s;
    return (pair){cos_of(longitude), sin_of(longitude)};
}

/* Add the force in light; uniform light exerts no torque on a bar. */
static void add_solar_pressure(const void *constants, real t_s, const real *y, const scene *s)
{
    (void)y;
    const solar_pressure *own = constants;
    if (own->mode.value[0] == 0.0)
        return;
    pair sun = sun_direction(own, t_s);
    real pressure = -2.0 * own->pressure_Pa, mirrored = 2.0 * own->reflectivity;
    real taken_x = (1.0 - own->reflectivity) * sun.x, taken_y = (1.0 - own->reflectivity) * sun.y;
    for (int64_t i = 0; i < s->n; i++) {
        real ux = s->ux[i], uy = s->uy[i];
        real seen = ux * sun.y - uy * sun.x; /* n.s; its sign is the face's */
        real area = own->width_m.value[i] * s->half[i];
        real strength = pressure * area * s->inverse_mass[i] * (own->mode.value[1 + i] * seen);
        s->ax[i] += strength * (taken_x - mirrored * seen * uy);
        s->ay[i] += strength * (taken_y + mirrored * seen * ux);
    }
}

/* Whether the chain has crossed the shadow's edge, or a bar shows its other face.
 *
 * A shadow's axis between this sample and the previous one also counts: the chain may have crossed the shadow in
 * between.
 */
static bool solar_mode_ended(void *constants, real t_s, const real *y, const scene *s)
{
    solar_pressure *own = constants;
    real radius = own->shadow_radius_m, worst = 0.0, light = own->mode.value[0];
    pair sun = sun_direction(own, t_s);
    if (radius != 0.0) {
        real towards = sun.x * y[s->n] + sun.y * y[s->n + 1], across = sun.x * y[s->n + 1] - sun.y * y[s->n];
        real away = towards < 0.0 ? magnitude(across) : distance(towards, across);
        worst = smaller((2.0 * light - 1.0) * (away - radius), 0.0);
        real side = towards < 0.0 ? across : 0.0;
        if (side * own->side_m.value[0] < 0.0 && light != 0.0)
            worst = -1.0;
        own->side_m.value[0] = side;
    }
    for (int64_t i = 0; i < s->n; i++)
        worst = smaller(own->mode.value[1 + i] * (s->ux[i] * sun.y - s->uy[i] * sun.x) + EDGE_ON, worst);
    return worst < 0.0;
}

#endif
