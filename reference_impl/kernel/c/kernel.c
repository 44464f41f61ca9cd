/* One chain at a time: the functions that Python calls, and the batch of chains in sequence. */
#include "kernel.h"
#include "steps/stepper.h"
#include <stddef.h>

#ifndef SOURCE_DIGEST
#define SOURCE_DIGEST ""
#endif

/* Digest of the sources that the library was compiled from. */
const char *source_digest(void) { return SOURCE_DIGEST; }

/* What Python describes too: 64-bit words of each structure, extents, rows, columns and codes. */
#define WORDS(type) {#type, sizeof(type) / 8}
#define NUMBER(name) {#name, name}
static const struct {
    const char *name;
    int64_t value;
} LAYOUT[] = {
    WORDS(effect), WORDS(chain), WORDS(workspace), WORDS(stepper), WORDS(surface_bounds), WORDS(batch_members),
    WORDS(batch_results), WORDS(cvode_data), WORDS(drag), WORDS(joint_spring_damper), WORDS(oblateness),
    WORDS(joint_torque), WORDS(solar_pressure), WORDS(third_body), WORDS(thrust),
    NUMBER(NO_GRAVITY), NUMBER(POINT), NUMBER(GRADIENT),
    NUMBER(HALF), NUMBER(WEIGHT), NUMBER(INVERSE_MASS), NUMBER(COMPLIANCE), NUMBER(LEVER), NUMBER(INVERSE_INERTIA),
    NUMBER(PASSED), NUMBER(FREED), NUMBER(ILL_CONDITIONED), NUMBER(REFINED), NUMBER(UNEQUAL), NUMBER(ALPHA),
    NUMBER(BETA), NUMBER(PASSED_RIGHT), NUMBER(FREED_RIGHT), NUMBER(CONSTANT_ROWS),
    NUMBER(SCRATCH_ROWS), NUMBER(GX), NUMBER(GY), NUMBER(RX), NUMBER(RY),
    NUMBER(BAR), NUMBER(REACTS_ON), NUMBER(FRAME), NUMBER(UNIT), NUMBER(FIRST_TURN), NUMBER(AMPLITUDE),
    NUMBER(DURATION), NUMBER(START), NUMBER(COURSE), NUMBER(CONSTANT), NUMBER(LINEAR), NUMBER(SQUARE), NUMBER(CUBE),
    NUMBER(TURN_COLUMNS), NUMBER(EQUATION_28), NUMBER(QUINTIC), NUMBER(SPLINE),
    NUMBER(INERTIAL), NUMBER(LOCAL_HORIZONTAL), NUMBER(PREVIOUS_BAR),
    NUMBER(NOW), NUMBER(STEP), NUMBER(TAKEN), NUMBER(STEPS), NUMBER(SAMPLED), NUMBER(EVALUATIONS), NUMBER(EXACT),
    NUMBER(ARRIVED), NUMBER(CHECK_SURFACE), NUMBER(COLLAPSED), NUMBER(NOT_FINITE), NUMBER(LOST_JOINT),
    NUMBER(MODE_ENDED), NUMBER(SLOPES), NUMBER(POWERS),
};

/* Name of an entry of the layout, NULL after the last. */
const char *layout_name(int64_t k) { return k < (int64_t)(sizeof LAYOUT / sizeof *LAYOUT) ? LAYOUT[k].name : NULL; }

int64_t layout_value(int64_t k) { return LAYOUT[k].value; }

/* Name of a kind of effects, NULL after the last. */
const char *effect_name(int64_t kind)
{
    return kind < (int64_t)(sizeof EFFECTS / sizeof *EFFECTS) ? EFFECTS[kind].name : NULL;
}

/* Rates of a state, (size,) both; false if the joint system is not positive definite in double precision. */
bool evaluate_state(double t_s, const number *y, number *rates, const chain *chain, workspace *work)
{
    return !evaluate(t_s, y, rates, (motion){chain, work});
}

/* Evaluate `times` times, each evaluation after the one before, to measure their time.
 *
 * A barely changed angle keeps the compiler from evaluating only once.
 */
void evaluate_repeatedly(int64_t times, number *y, number *rates, const chain *chain, workspace *work)
{
    int64_t n = chain->bars.columns;
    for (int64_t k = 0; k < times; k++) {
        evaluate(0.0, y, rates, (motion){chain, work});
        y[0] += 1e-30 * rates[n + 2];
    }
}

/* Reactions (samples (N-1), 2) and torques (samples, P) at states (samples, size); false if a pivot is lost. */
bool observe(int64_t samples, const number *t_s, const number *y, int64_t size, number *scratch, const chain *chain,
             workspace *work, number *reaction_N, number *torque_N_m)
{
    int64_t n = chain->bars.columns, laws = chain->laws.rows;
    const number *rx = work->bars.value + RX * n, *ry = work->bars.value + RY * n;
    bool lost = false;
    for (int64_t k = 0; k < samples; k++) {
        lost |= evaluate(t_s[k], y + k * size, scratch, (motion){chain, work});
        for (int64_t j = 0; j < n - 1; j++) {
            *reaction_N++ = rx[j];
            *reaction_N++ = ry[j];
        }
        for (int64_t p = 0; p < laws; p++)
            *torque_N_m++ = work->torque_N_m.value[p];
    }
    return !lost;
}

/* State at t_s + h_s into s->end, by a shorter step from the start of the last one; false if a joint is lost. */
bool take_partial_step(double t_s, double h_s, stepper *s, const chain *chain, workspace *work)
{
    s->clock.value[EVALUATIONS] += 12.0;
    return !advance(s->y.length, t_s, h_s, s->before.value, s->slopes.value, s->end.value, (motion){chain, work});
}

void make_interpolant(stepper *s, const chain *chain, workspace *work)
{
    interpolate_last_step(s, (motion){chain, work});
}

/* State at a fraction of the last step, by its interpolant. */
void interpolate_step(double share, const stepper *s, number *found)
{
    interpolate(s->y.length, share, s->before.value, s->powers.value, found);
}

/* One chain of a batch. */
static chain member_chain(const batch_members *members, int64_t r)
{
    int64_t runs = members->mu_m3_s2.length, laws = members->laws.rows / runs;
    matrix bars = {members->bars.value + r * CONSTANT_ROWS * members->bars.columns, CONSTANT_ROWS, members->bars.columns};
    int64_t columns = members->laws.columns;
    matrix own_laws = {members->laws.value + r * laws * columns, laws, columns};
    return (chain){
        members->mu_m3_s2.value[r], members->gravity, bars, own_laws, members->effects, members->effect_count,
    };
}

/* Run all chains of a batch in sequence, with one stepper, workspace and buffer of samples (n, size).
 *
 * segments_s (k, 2) has the starts and ends of the smooth segments. A run that may have touched the surface, or failed,
 * keeps what `results` held after its last sample, and has a code other than ARRIVED.
 */
void integrate_batch(const batch_members *members, const vector *t_s, const matrix *segments_s, stepper *s,
                     workspace *work, matrix *samples, batch_results *results)
{
    int64_t size = s->y.length, bars = work->bars.columns;
    const number *rx = work->bars.value + RX * bars, *ry = work->bars.value + RY * bars;
    for (int64_t r = 0; r < members->mu_m3_s2.length; r++) {
        const chain own = member_chain(members, r);
        const number *bound = members->bounds.value + 3 * r;
        const surface_bounds ground = {bound[0], bound[1], bound[2]};
        const vector atol = {members->atol.value + r * size, size};
        for (int64_t i = 0; i < s->clock.length; i++)
            s->clock.value[i] = 0.0;
        s->clock.value[SAMPLED] = 1.0;
        for (int64_t i = 0; i < size; i++)
            s->y.value[i] = samples->value[i] = members->y0.value[r * size + i];
        int64_t code = ARRIVED;
        for (int64_t k = 0; k < segments_s->rows && code == ARRIVED; k++) {
            const number *segment = segments_s->value + 2 * k;
            code = advance_to(segment[0], segment[1], &ground, t_s, samples, &atol, s, &own, work);
        }
        results->code.value[r] = (double)code;
        results->steps.value[r] = s->clock.value[STEPS];
        results->evaluations.value[r] = s->clock.value[EVALUATIONS];
        for (int64_t k = 0; k < (int64_t)s->clock.value[SAMPLED]; k++) {
            int64_t row = r * t_s->length + k;
            const number *y = samples->value + k * size;
            evaluate(t_s->value[k], y, s->end.value, (motion){&own, work});
            for (int64_t j = 0; j < bars; j++)
                results->angle_rad.value[row * bars + j] = y[j];
            for (int64_t j = 0; j < bars - 1; j++)
                results->reaction_N.value[row * (bars - 1) + j] = distance(rx[j], ry[j]);
        }
    }
}
