/* One step of DOP853, for one chain and for lanes.
 *
 * Coefficients, error norm, step control and interpolant are SciPy's: the kernel takes the steps of the NumPy form. The
 * including file defines `motion` and
 *
 *     flag evaluate(real t_s, const real *y, real *rates, motion m);
 *
 * which returns whether a joint was lost in round-off. A vector has `size` components, which differ by `size` from one
 * row of slopes to the next.
 */
#ifndef DOP853_H
#define DOP853_H

#include "../chain/arithmetic.h"
#include "coefficients.h"

static const double SAFETY = 0.9, LEAST_FACTOR = 0.2, LARGEST_FACTOR = 10.0;
static const double RTOL_FLOOR = 100.0 * 0x1p-52;    /* SciPy's smallest relative tolerance */

/* Sum of the slopes of one component with a row of coefficients.
 *
 * The row is a constant of each caller and the loop is unrolled: only products with coefficients other than zero remain,
 * in three sums that do not wait for each other.
 */
static inline __attribute__((always_inline)) real weighted(const double *weights, int terms, const real *slopes,
                                                           int64_t size)
{
    real first = every(0.0), second = first, third = first;
    int used = 0;
#pragma GCC unroll 16
    for (int j = 0; j < terms; j++) {
        if (weights[j] == 0.0)
            continue;
        if (used < 4)
            first += weights[j] * slopes[j * size];
        else if (used < 8)
            second += weights[j] * slopes[j * size];
        else
            third += weights[j] * slopes[j * size];
        used++;
    }
    return (first + second) + third;
}

/* State of a stage: y + h times the weighted slopes. */
static inline __attribute__((always_inline)) void stage_state(const double *weights, int terms, int64_t size, real h,
                                                              const real *restrict y, const real *restrict slopes,
                                                              real *restrict state)
{
    for (int64_t i = 0; i < size; i++)
        state[i] = y[i] + h * weighted(weights, terms, slopes + i, size);
}

static inline __attribute__((always_inline)) flag take_stage(const int stage, int64_t size, real t, real h,
                                                             const real *y, real *slopes, real *state, motion m)
{
    stage_state(A[stage], stage, size, h, y, slopes, state);
    return evaluate(t + C[stage] * h, state, slopes + stage * size, m);
}

/* Take one step from y, whose rates are slopes[0]: the state at t + h into `end`, its rates into slopes[12]. */
static flag advance(int64_t size, real t, real h, const real *y, real *slopes, real *end, motion m)
{
    flag lost = take_stage(1, size, t, h, y, slopes, end, m);
    lost |= take_stage(2, size, t, h, y, slopes, end, m);
    lost |= take_stage(3, size, t, h, y, slopes, end, m);
    lost |= take_stage(4, size, t, h, y, slopes, end, m);
    lost |= take_stage(5, size, t, h, y, slopes, end, m);
    lost |= take_stage(6, size, t, h, y, slopes, end, m);
    lost |= take_stage(7, size, t, h, y, slopes, end, m);
    lost |= take_stage(8, size, t, h, y, slopes, end, m);
    lost |= take_stage(9, size, t, h, y, slopes, end, m);
    lost |= take_stage(10, size, t, h, y, slopes, end, m);
    lost |= take_stage(11, size, t, h, y, slopes, end, m);
    return lost | take_stage(12, size, t, h, y, slopes, end, m);
}

/* Error of a step relative to the allowed error, from the estimates of orders 5 and 3; `count` components are not idle. */
static real error_norm(int64_t size, int64_t count, real h, const real *restrict y, const real *restrict end,
                       const real *restrict slopes, const real *restrict allowed, double rtol)
{
    real fifth = every(0.0), third = fifth;
    for (int64_t i = 0; i < size; i++) {
        real e3 = weighted(E[0], STAGES, slopes + i, size), e5 = weighted(E[1], STAGES, slopes + i, size);
        real inverse = 1.0 / (allowed[i] + larger(magnitude(end[i]), magnitude(y[i])) * rtol);
        fifth += (e5 * inverse) * (e5 * inverse);
        third += (e3 * inverse) * (e3 * inverse);
    }
    real found = magnitude(h) * fifth / root((fifth + 0.01 * third) * (double)count);
    return choose((fifth == 0.0) & (third == 0.0), every(0.0), found);
}

/* Ratio of the next step's size to this one's, by SciPy's step control; a step whose error is not below 1 is tried again. */
static real step_factor(real error, flag rejected)
{
    real factor = SAFETY / eighth_root(error), largest = choose(rejected, every(1.0), every(LARGEST_FACTOR));
    return choose(error < 1.0, smaller(factor, largest), larger(factor, every(LEAST_FACTOR)));
}

/* Size of the first step, s (Hairer et al., II.4), from the rates in slopes[0]; one evaluation, into slopes[1]. */
static real first_step(int64_t size, int64_t count, real t, double span_s, const real *y, real *slopes, real *end,
                       const real *atol, motion m)
{
    real d0 = every(0.0), d1 = d0, d2 = d0, span = every(span_s);
    for (int64_t i = 0; i < size; i++) {
        real scale = atol[i] + magnitude(y[i]) * RTOL_FLOOR;
        real here = y[i] / scale, rate = slopes[i] / scale;
        d0 += here * here;
        d1 += rate * rate;
    }
    d0 = root(d0 / (double)count);
    d1 = root(d1 / (double)count);
    real h0 = smaller(choose((d0 < 1e-5) | (d1 < 1e-5), every(1e-6), 0.01 * d0 / d1), span);
    for (int64_t i = 0; i < size; i++)
        end[i] = y[i] + h0 * slopes[i];
    evaluate(t + h0, end, slopes + size, m);
    for (int64_t i = 0; i < size; i++) {
        real bent = (slopes[size + i] - slopes[i]) / (atol[i] + magnitude(y[i]) * RTOL_FLOOR);
        d2 += bent * bent;
    }
    d2 = root(d2 / (double)count) / h0;
    real h1 = eighth_root(0.01 / larger(d2, d1));
    h1 = choose((d1 <= 1e-15) & (d2 <= 1e-15), larger(h0 * 1e-3, every(1e-6)), h1);
    return smaller(span, smaller(h1, 100.0 * h0));
}

/* Seventh-order interpolant of a step into `powers`, (7, size); three evaluations. */
static void interpolant(int64_t size, real t, real h, const real *restrict y, const real *restrict end,
                        real *restrict slopes, real *restrict scratch, real *restrict powers, motion m)
{
    take_stage(13, size, t, h, y, slopes, scratch, m);
    take_stage(14, size, t, h, y, slopes, scratch, m);
    take_stage(15, size, t, h, y, slopes, scratch, m);
    for (int64_t i = 0; i < size; i++) {
        real change = end[i] - y[i];
        powers[i] = change;
        powers[size + i] = h * slopes[i] - change;
        powers[2 * size + i] = 2.0 * change - h * (slopes[12 * size + i] + slopes[i]);
        powers[3 * size + i] = h * weighted(D[0], SLOPES, slopes + i, size);
        powers[4 * size + i] = h * weighted(D[1], SLOPES, slopes + i, size);
        powers[5 * size + i] = h * weighted(D[2], SLOPES, slopes + i, size);
        powers[6 * size + i] = h * weighted(D[3], SLOPES, slopes + i, size);
    }
}

/* Change of one component from the start of a step to its fraction x, by the component's powers of the interpolant. */
static inline real interpolated_change(real x, const number powers[POWERS])
{
    real rest = 1.0 - x, total = powers[6] * x;
    total = (total + powers[5]) * rest;
    total = (total + powers[4]) * x;
    total = (total + powers[3]) * rest;
    total = (total + powers[2]) * x;
    total = (total + powers[1]) * rest;
    return (total + powers[0]) * x;
}

#endif
