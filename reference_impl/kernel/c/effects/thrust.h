/* Force on a bar's end, as reference_impl/effects/thrust.py; the mode is the segment of its table. */
#ifndef THRUST_H
#define THRUST_H

#include "timed.h"

typedef struct {
    int64_t bar;
    double side;      /* -1 at the first end, 1 at the other */
    int64_t inertial; /* 1 for a direction in the inertial frame, 0 in the bar's */
    vector direction; /* (2,) forwards and leftwards */
    matrix table;     /* (2, k) rows of instants, s, and forces, N */
    vector mode;      /* (1,) segment of the table; -1: none */
} thrust;

/* Add force and torque on one bar, on a segment of the table extrapolated beyond its ends. */
static void add_thrust(const void *constants, real t_s, const real *y, const scene *s)
{
    (void)y;
    const thrust *own = constants;
    int64_t i = own->bar;
    real size = size_in_time(&own->table, &own->mode, t_s);
    real ux = s->ux[i], uy = s->uy[i];
    real push_x = size * own->direction.value[0], push_y = size * own->direction.value[1];
    if (!own->inertial) {
        real along = push_x, across = push_y;
        push_x = ux * along - uy * across;
        push_y = uy * along + ux * across;
    }
    s->ax[i] += push_x * s->inverse_mass[i];
    s->ay[i] += push_y * s->inverse_mass[i];
    s->angular[i] += own->side * s->lever[i] * (ux * push_y - uy * push_x);
}

#endif
