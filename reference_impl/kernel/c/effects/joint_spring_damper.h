/* Springs and dampers in the joints, as reference_impl/effects/joint_spring_damper.py. */
#ifndef JOINT_SPRING_DAMPER_H
#define JOINT_SPRING_DAMPER_H

#include "effect.h"

enum joint_rows { STIFFNESS, DAMPING, REST };

typedef struct {
    matrix table; /* (3, N-1) rows STIFFNESS, DAMPING, REST */
} joint_spring_damper;

/* Add equal and opposite torques on both bars of each joint. */
static void add_joint_spring_damper(const void *constants, real t_s, const real *y, const scene *s)
{
    (void)t_s;
    const joint_spring_damper *own = constants;
    int64_t n = s->n, joints = own->table.columns;
    const real *table = own->table.value;
    real before = 0.0;
    for (int64_t i = 0; i < n - 1; i++) {
        real bent = y[i + 1] - y[i] - table[REST * joints + i], bending = y[n + 3 + i] - y[n + 2 + i];
        real torque = table[STIFFNESS * joints + i] * bent + table[DAMPING * joints + i] * bending;
        s->angular[i] += (torque - before) * s->inverse_inertia[i];
        before = torque;
    }
    s->angular[n - 1] -= before * s->inverse_inertia[n - 1];
}

#endif
