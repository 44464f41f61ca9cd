/* Integration of one chain over the samples, step by step, with a return code for each case that needs the caller. */
#ifndef STEPPER_H
#define STEPPER_H

#include "../chain/evaluation.h"
/* dop853.h calls evaluate() */
#include "step_bounds.h"

enum codes { ARRIVED, CHECK_SURFACE, COLLAPSED, NOT_FINITE, LOST_JOINT, MODE_ENDED };

/* Items of stepper.clock: present time, size of the next step and of the last one, s; counts of steps, of samples and
 * of evaluations; 1 for steps by advance_exactly, else 0. */
enum clock_items { NOW, STEP, TAKEN, STEPS, SAMPLED, EVALUATIONS, EXACT };

/* Parts of a step at which events are sought, as reference_impl/integrate/discrete_modes.py. */
static const double EVENT_SHARES[] = {0.0, 0.25, 0.5, 0.75, 1.0};

/* Take one step as `advance`, with coefficients of thirty digits and compensated summation of the state. The wide type
 * takes all its steps so.
 *
 * The coefficients' rounding errors, up to 2e-15 as some coefficients exceed 40, are equal in every step. An orbit's
 * energy therefore drifts by some 6e-16 per revolution in one direction; rounding alone would cause a random walk.
 * `residue` is the rounding residue of the state at the start, `left` that at the end (Kahan's compensated summation).
 */
static bool advance_exactly(int64_t size, real t, real h, const real *y, const real *residue, real *slopes,
                            real *end, real *left, motion m)
{
    bool lost = false;
    for (int stage = 1; stage <= STAGES; stage++) {
        for (int64_t i = 0; i < size; i++) {
            real head = 0.0, tail = 0.0;
            for (int j = 0; j < stage; j++) {
                head += A[stage][j] * slopes[j * size + i];
                tail += RESIDUES[stage][j] * slopes[j * size + i];
            }
            real change = h * (head + tail) + residue[i];
            end[i] = y[i] + change;
            left[i] = change - (end[i] - y[i]);
        }
        lost |= evaluate(t + (C[stage] * h + C_RESIDUES[stage] * h), end, slopes + stage * size, m);
    }
    return lost;
}

/* State at the fraction x of a step. */
static void interpolate(int64_t size, real x, const real *restrict y, const real *restrict powers,
                        real *restrict found)
{
    for (int64_t i = 0; i < size; i++) {
        number own[POWERS];
        for (int k = 0; k < POWERS; k++)
            own[k] = powers[k * size + i];
        found[i] = y[i] + interpolated_change(x, own);
    }
}

/* Whether a state and its rates are finite. */
static bool finite_numbers(int64_t size, const real *y, const real *rates)
{
    real total = 0.0;
    for (int64_t i = 0; i < size; i++)
        total += magnitude(y[i]) + magnitude(rates[i]);
    return total < INFINITY;
}

static void allow_error(const vector *atol, stepper *s, motion m)
{
    int64_t n = m.chain->bars.columns;
    for (int64_t i = 2 * n + 4; i < atol->length; i++)
        s->allowed.value[i] = atol->value[i];
    set_allowed_error(n, true, m.chain->bars.value, m.work->bars.value, s->y.value, atol->value, s->allowed.value);
}

/* Begin a smooth segment: the current rate and the first step's size; ARRIVED, or the code of a failure. */
static int64_t begin_segment(real t_s, real end_s, const vector *atol, stepper *s, motion m)
{
    int64_t size = s->y.length, count = 2 * m.chain->bars.columns + 4;
    real *clock = s->clock.value, *y = s->y.value, *slopes = s->slopes.value;
    clock[NOW] = t_s;
    clock[TAKEN] = 0.0;
    for (int64_t i = 0; i < size; i++)
        s->residue.value[i] = 0.0;
    bool lost = evaluate(t_s, y, slopes, m);
    clock[EVALUATIONS] += 1.0;
    if (lost)
        return LOST_JOINT;
    if (!finite_numbers(size, y, slopes))
        return NOT_FINITE;
    clock[EVALUATIONS] += 1.0;
    clock[STEP] = first_step(size, count, t_s, end_s - t_s, y, slopes, s->end.value, atol->value, m);
    allow_error(atol, s, m);
    return ARRIVED;
}

/* Take one accepted step towards end_s, with SciPy's step control. */
static int64_t take_step(real end_s, const vector *atol, stepper *s, motion m)
{
    int64_t size = s->y.length, count = 2 * m.chain->bars.columns + 4;
    real *clock = s->clock.value, *y = s->y.value, *end = s->end.value, *slopes = s->slopes.value;
    real *residue = s->residue.value, *left = residue + size;
    bool exact = clock[EXACT] != 0.0, rejected = false;
    real t = clock[NOW], least = 10.0 * spacing(t), h = larger(clock[STEP], least);
    while (h >= least) {
        real reached = smaller(t + h, end_s);
        h = reached - t;
        bool lost = exact ? advance_exactly(size, t, h, y, residue, slopes, end, left, m)
                          : advance(size, t, h, y, slopes, end, m);
        clock[EVALUATIONS] += STAGES;
        if (lost)
            return LOST_JOINT;
        real error = error_norm(size, count, h, y, end, slopes, s->allowed.value, exact ? 0.0 : RTOL_FLOOR);
        real next = h * step_factor(error, rejected);
        if (error < 1.0) {
            clock[STEP] = next;
            clock[NOW] = reached;
            clock[TAKEN] = h;
            clock[STEPS] += 1.0;
            for (int64_t i = 0; i < size; i++) {
                s->before.value[i] = y[i];
                y[i] = end[i];
                residue[i] = left[i];
            }
            allow_error(atol, s, m);
            return ARRIVED;
        }
        h = next;
        rejected = true;
    }
    return COLLAPSED;
}

/* Compute the last step's interpolant. */
static void interpolate_last_step(stepper *s, motion m)
{
    real h = s->clock.value[TAKEN], t = s->clock.value[NOW] - h;
    interpolant(s->y.length, t, h, s->before.value, s->y.value, s->slopes.value, s->end.value, s->powers.value, m);
    s->clock.value[EVALUATIONS] += 3.0;
}

/* Copy the rate at the end of the last step to the start of the next. */
void begin_next_step(stepper *s)
{
    int64_t size = s->y.length;
    for (int64_t i = 0; i < size; i++)
        s->slopes.value[i] = s->slopes.value[STAGES * size + i];
}

/* Samples of the last step up to until_s by shorter steps from its start: the interpolant is worse than the wide type. */
static void take_samples_by_steps(double until_s, const vector *t_s, matrix *samples, stepper *s, motion m)
{
    int64_t size = s->y.length, seen = (int64_t)s->clock.value[SAMPLED];
    real now = s->clock.value[NOW], start = now - s->clock.value[TAKEN];
    real *end_slopes = s->slopes.value + STAGES * size, *kept = s->powers.value, *none = kept + size, *left = none + size;
    for (int64_t i = 0; i < size; i++) {
        kept[i] = end_slopes[i];
        none[i] = 0.0;
    }
    for (; seen < t_s->length && t_s->value[seen] <= until_s; seen++) {
        real *sample = samples->value + seen * size;
        if (t_s->value[seen] == now) {
            for (int64_t i = 0; i < size; i++)
                sample[i] = s->y.value[i];
        } else {
            advance_exactly(size, start, t_s->value[seen] - start, s->before.value, none, s->slopes.value, sample, left, m);
            s->clock.value[EVALUATIONS] += STAGES;
        }
    }
    for (int64_t i = 0; i < size; i++)
        end_slopes[i] = kept[i];
    s->clock.value[SAMPLED] = (real)seen;
}

/* Samples of the last step up to until_s, from its end or its interpolant. */
void take_samples(double until_s, const vector *t_s, matrix *samples, bool have_interpolant, stepper *s,
                  const chain *chain, workspace *work)
{
    if (sizeof(number) > sizeof(double)) {
        take_samples_by_steps(until_s, t_s, samples, s, (motion){chain, work});
        return;
    }
    int64_t size = s->y.length, seen = (int64_t)s->clock.value[SAMPLED];
    real now = s->clock.value[NOW], h = s->clock.value[TAKEN];
    for (; seen < t_s->length && t_s->value[seen] <= until_s; seen++) {
        real *sample = samples->value + seen * size;
        if (t_s->value[seen] == now) {
            for (int64_t i = 0; i < size; i++)
                sample[i] = s->y.value[i];
            continue;
        }
        if (!have_interpolant)
            interpolate_last_step(s, (motion){chain, work});
        have_interpolant = true;
        interpolate(size, (t_s->value[seen] - (now - h)) / h, s->before.value, s->powers.value, sample);
    }
    s->clock.value[SAMPLED] = (real)seen;
}

/* Whether a mode of any effect has ended at a sample of the last step, by its interpolant.
 *
 * As DiscreteModes.find_event of reference_impl/integrate/discrete_modes.py, which then locates the instant.
 */
static bool mode_ended_in_step(stepper *s, motion m)
{
    int64_t n = m.chain->bars.columns;
    real h = s->clock.value[TAKEN], *y = s->end.value, *rows = m.work->bars.value;
    for (int k = 0; k < 5; k++) {
        real share = EVENT_SHARES[k], t = s->clock.value[NOW] - h + share * h;
        interpolate(s->y.length, share, s->before.value, s->powers.value, y);
        unit_vectors(n, y, rows);
        pair mean = centres_from_first(n, m.chain->bars.value, rows);
        bool seen = any_mode_ended(t, y, mean, m.chain, m.work);
        if (seen && share > 0.0)
            return true;
    }
    return false;
}

/* Integrate to end_s, from start_s if that is the current time, and fill `samples` as their instants are reached.
 *
 * The segment is smooth: no break of a law or an effect lies inside. Returns CHECK_SURFACE after a step with possible
 * contact, and MODE_ENDED after a step in which a mode of an effect ended, with its interpolant computed. The caller
 * examines the step and calls again.
 */
int64_t advance_to(double start_s, double end_s, const surface_bounds *ground, const vector *t_s, matrix *samples,
                   const vector *atol, stepper *s, const chain *chain, workspace *work)
{
    motion m = {chain, work};
    int64_t n = chain->bars.columns, code = ARRIVED;
    const real *clock = s->clock.value;
    bool watches_events = has_state_events(chain);
    if (clock[NOW] == start_s)
        code = begin_segment(start_s, end_s, atol, s, m);
    while (code == ARRIVED && clock[NOW] < end_s) {
        code = take_step(end_s, atol, s, m);
        if (code == ARRIVED && !finite_numbers(s->y.length, s->y.value, s->y.value))
            code = NOT_FINITE;
        if (watches_events && code == ARRIVED) {
            interpolate_last_step(s, m);
            code = mode_ended_in_step(s, m) ? MODE_ENDED : ARRIVED;
        }
        if (code != ARRIVED)
            break;
        if (ground->contact_free_radius_m > 0.0
            && !clears_surface(n, chain->gravity, chain->mu_m3_s2, clock[TAKEN], s->before.value, s->y.value,
                               ground->contact_free_radius_m, ground->contact_free_perigee_m,
                               ground->largest_pull_m_s2)) {
            code = CHECK_SURFACE;
        } else {
            take_samples(clock[NOW], t_s, samples, watches_events, s, chain, work);
            begin_next_step(s);
        }
    }
    return code;
}

#endif
