/* One evaluation of the relative formulation for a free chain under gravity alone: compiled for one chain and for lanes. */
#ifndef FREE_CHAIN_H
#define FREE_CHAIN_H

#include "gravity.h"
#include "joints.h"
#include "positions.h"
#include "trigonometry.h"

/* Rates of the state into `rates`, reactions into rows R; returns whether the joint system is not positive definite. */
static inline flag evaluate_free_chain(int64_t n, int64_t model, real mu, const real *restrict bars,
                                       const real *restrict y, real *restrict rates, real *restrict rows)
{
    real pull = every(0.0);
    unit_vectors(n, y, rows);
    if (model == NO_GRAVITY) {
        no_gravity(n, rows);
    } else {
        pair mean = centres_from_first(n, bars, rows);
        pull = gravity(n, model, mu, y[n], y[n + 1], mean.x, mean.y, rows);
    }
    end_accelerations(n, bars, y + n + 2, rows);
    flag lost = never();
    if (n > 1)
        lost |= solve_by_sweeps(n, bars, rows);
    for (int64_t i = 0; i < n + 2; i++)
        rates[i] = y[n + 2 + i];
    angular_accelerations(n, bars, rows, rates + n + 2);
    com_acceleration(n, pull, bars, y + n, rows, rates + 2 * n + 2);
    return lost;
}

#endif
