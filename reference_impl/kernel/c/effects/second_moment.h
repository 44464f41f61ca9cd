/* Torque and force on a bar's second moment in the field of a distant mass; positions count from the mass. */
#ifndef SECOND_MOMENT_H
#define SECOND_MOMENT_H

#include "effect.h"

/* Torque over moment of inertia, 3 mu (u.Z)(n.Z)/|Z|^5, rad/s^2. */
static inline real second_moment_spin(real mu, real x, real y, real ux, real uy)
{
    real r2 = x * x + y * y;
    return 3.0 * mu * (ux * x + uy * y) * (ux * y - uy * x) / (r2 * r2 * root(r2));
}

/* Acceleration beyond a point mass's, (3 mu J/2m|Z|^5) (2 (u.Z) u + Z - 5 c^2 Z), m/s^2, for given J/m. */
static inline pair second_moment_acceleration(real mu, real x, real y, real ux, real uy, real gyration2)
{
    real inverse2 = 1.0 / (x * x + y * y);
    real up = ux * x + uy * y;
    real strength = 1.5 * mu * gyration2 * inverse2 * inverse2 * root(inverse2);
    real flat = 1.0 - 5.0 * up * up * inverse2;
    return (pair){strength * (2.0 * up * ux + flat * x), strength * (2.0 * up * uy + flat * y)};
}

#endif
