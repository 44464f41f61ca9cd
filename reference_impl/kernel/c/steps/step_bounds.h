/* Bounds of a step that its error estimate does not know: round-off of the angles, and the surface. */
#ifndef STEP_BOUNDS_H
#define STEP_BOUNDS_H

#include "../chain/layout.h"
#include "dop853.h"

/* Error allowed in the next step: `atol`, but no less than the round-off of the angles, where `which` is set.
 *
 * The round-off of an angle is half a unit in its last place. As StateCoordinates.state_roundoff_floor of
 * reference_impl/integrate/coordinate_sets.py, by the reactions of the last evaluation.
 */
static void set_allowed_error(int64_t n, flag which, const real *bars, const real *rows, const real *y,
                              const real *atol, real *allowed)
{
    real before_x = every(0.0), before_y = before_x;
    for (int64_t i = 0; i < n; i++) {
        real x = i < n - 1 ? rows[RX * n + i] : every(0.0), z = i < n - 1 ? rows[RY * n + i] : every(0.0);
        real turned = magnitude(y[i]);
        real pulled = root(bars[LEVER * n + i] * distance(x + before_x, z + before_y));
        real swing = larger(turned, every(1.0)) * pulled;
        int64_t rate = n + 2 + i;
        allowed[i] = choose(which, larger(0.5 * EPSILON * turned, atol[i]), allowed[i]);
        allowed[rate] = choose(which, larger(0.5 * EPSILON * swing, atol[rate]), allowed[rate]);
        before_x = x;
        before_y = z;
    }
    for (int64_t i = 0; i < 2; i++) {
        allowed[n + i] = atol[n + i];
        allowed[2 * n + 2 + i] = atol[2 * n + 2 + i];
    }
}

/* Perigee of the Kepler orbit through a state, m from the centre. */
static real perigee_m(int64_t n, const real *y, real mu)
{
    real x = y[n], z = y[n + 1], vx = y[2 * n + 2], vz = y[2 * n + 3];
    real swept = x * vz - z * vx;
    real energy = 0.5 * (vx * vx + vz * vz) - mu / distance(x, z);
    real parameter = swept * swept / mu;
    return parameter / (1.0 + root(larger(1.0 + 2.0 * energy * parameter / mu, every(0.0))));
}

/* Lowest radius of free fall over `half`, from one end of a step; `way` is the sign of time, inwards from that end. */
static inline real lowest_radius(int64_t n, const real *y, double way, real half, real pull)
{
    real r = distance(y[n], y[n + 1]);
    real fall = way * (y[n] * y[2 * n + 2] + y[n + 1] * y[2 * n + 3]) / r;
    return r + smaller(fall, every(0.0)) * half - 0.5 * pull * half * half;
}

/* Whether contact with the surface is impossible in a step of size h.
 *
 * As Simulation.clears_surface of reference_impl/integrate/simulate.py.
 */
static flag clears_surface(int64_t n, int64_t gravity, real mu, real h, const real *before, const real *y, real radius,
                           real perigee, real pull)
{
    flag clear = gravity == NO_GRAVITY ? never() : perigee_m(n, y, mu) > perigee;
    if (in_all_lanes(clear))
        return clear;
    real half = 0.5 * h;
    real low = smaller(lowest_radius(n, y, -1.0, half, pull), lowest_radius(n, before, 1.0, half, pull));
    return clear | (low > radius);
}

#endif
