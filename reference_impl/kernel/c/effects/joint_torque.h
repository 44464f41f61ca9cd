/* Torque of a motor in a joint, as reference_impl/effects/joint_torque.py. */
#ifndef JOINT_TORQUE_H
#define JOINT_TORQUE_H

#include "timed.h"

typedef struct {
    int64_t joint; /* between bars `joint` and `joint` + 1, from 0 */
    matrix table;  /* (2, k) rows of instants, s, and torques, N m */
    vector mode;   /* (1,) segment of the table; -1: none */
} joint_torque;

/* Add the torque on the second bar of the joint, and the opposite one on its first. */
static void add_joint_torque(const void *constants, real t_s, const real *y, const scene *s)
{
    (void)y;
    const joint_torque *own = constants;
    real torque = size_in_time(&own->table, &own->mode, t_s);
    s->angular[own->joint] -= torque * s->inverse_inertia[own->joint];
    s->angular[own->joint + 1] += torque * s->inverse_inertia[own->joint + 1];
}

#endif
