/* One evaluation of the relative formulation: rates of the state, reactions and torques. */
#ifndef EVALUATION_H
#define EVALUATION_H

#include "free_chain.h"
#include "laws.h"

/* A chain and the memory of its evaluation, as the integrator passes them on. */
typedef struct {
    const chain *chain;
    workspace *work;
} motion;

/* As evaluate_free_chain, with effects, laws, and refined reactions. */
static bool evaluate_loaded_chain(real t_s, const real *y, real *rates, const chain *chain, workspace *work)
{
    int64_t n = chain->bars.columns;
    const real *bars = chain->bars.value;
    real *rows = work->bars.value;
    bool well = true;
    pair mean = {0.0, 0.0};
    real pull = 0.0;
    unit_vectors(n, y, rows);
    if (chain->gravity == NO_GRAVITY) {
        no_gravity(n, rows);
    } else {
        mean = centres_from_first(n, bars, rows);
        pull = gravity(n, chain->gravity, chain->mu_m3_s2, y[n], y[n + 1], mean.x, mean.y, rows);
    }
    if (chain->effect_count > 0)
        add_effects(t_s, y, mean, chain, work);
    end_accelerations(n, bars, y + n + 2, rows);
    if (chain->laws.rows > 0) {
        well = unit_torque_reactions(n, chain, work);
        end_accelerations(n, bars, y + n + 2, rows);
    }
    well = reactions(n, bars, rows) && well;
    if (bars[REFINED * n] != 0.0)
        well = refine(n, bars, rows) && well;
    if (chain->laws.rows > 0)
        apply_prescribed_torques(n, t_s, y, chain, work);
    for (int64_t i = 0; i < n + 2; i++)
        rates[i] = y[n + 2 + i];
    angular_accelerations(n, bars, rows, rates + n + 2);
    for (int64_t k = 0; k < chain->laws.rows; k++)
        for (int64_t i = 0; i < n; i++)
            rates[n + 2 + i] += work->torque_N_m.value[k] * rotation_per_unit_torque(law_of(chain, k), i, n, bars);
    com_acceleration(n, pull, bars, y + n, rows, rates + 2 * n + 2);
    if (chain->effect_count > 0) {
        rates[2 * n + 2] += work->effect_common.value[COMMON_X];
        rates[2 * n + 3] += work->effect_common.value[COMMON_Y];
    }
    return well;
}

/* Rates of a state, reactions and torques; whether the joint system is not positive definite in real precision. */
static flag evaluate(real t_s, const real *y, real *rates, motion m)
{
    const chain *chain = m.chain;
    int64_t n = chain->bars.columns;
    const real *bars = chain->bars.value;
    if (chain->effect_count > 0 || chain->laws.rows > 0 || bars[ILL_CONDITIONED * n] != 0.0 || bars[REFINED * n] != 0.0)
        return !evaluate_loaded_chain(t_s, y, rates, chain, m.work);
    return evaluate_free_chain(n, chain->gravity, chain->mu_m3_s2, bars, y, rates, m.work->bars.value);
}

#endif
