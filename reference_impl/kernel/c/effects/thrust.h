/* Force on a bar's end, as reference_impl/effects/thrust.py; the mode is the segment of its table. */
#ifndef THRUST_H
#define THRUST_H

#include "effect.h"

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
    int64_t piece = (int64_t)own->mode.value[0], i = own->bar;
    if (piece < 0 || piece > own->table.columns - 2)
        return;
    const real *time = own->table.value + piece, *force = own->table.value + own->table.columns + piece;
    real share = (t_s - time[0]) / (time[1] - time[0]);
    real size = force[0] + (force[1] - force[0]) * share;
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
