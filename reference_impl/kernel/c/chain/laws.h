/* Prescribed rotations: torques by which bars follow their laws, eqs. (25)-(28), as in the NumPy form. */
#ifndef LAWS_H
#define LAWS_H

#include "../effects/all.h"
#include "cholesky.h"

/* Columns of chain.laws; from FIRST_TURN on those of turn_columns, of as many turns as the longest law has. */
enum law_columns {
    BAR,
    REACTS_ON, /* bar under the opposite torque; -1: none */
    FRAME,     /* what the angle is counted from: law_frames */
    UNIT,      /* root(J), which makes the small system nondimensional */
    FIRST_TURN
};

enum turn_columns {
    AMPLITUDE, /* rad; 0 where a law has no further turn */
    DURATION,  /* s */
    START,     /* s */
    COURSE,    /* law_courses */
    CONSTANT,  /* rad/s^2: acceleration of a piece of a spline by the powers 0 to 3 of s */
    LINEAR,
    SQUARE,
    CUBE,
    TURN_COLUMNS
};

enum law_courses { EQUATION_28, QUINTIC, SPLINE };

enum law_frames { INERTIAL, LOCAL_HORIZONTAL, PREVIOUS_BAR };

static inline const real *law_of(const chain *chain, int64_t k) { return chain->laws.value + k * chain->laws.columns; }

/* Second derivative of a turn, rad/s^2. */
static real turn_acceleration(const real *turn, real t_s)
{
    real progress = (t_s - turn[START]) / turn[DURATION];
    if (turn[COURSE] == SPLINE) /* the later one of two pieces moves at their common instant */
        return progress < 0.0 || progress >= 1.0
                   ? 0.0
                   : turn[CONSTANT] + progress * (turn[LINEAR] + progress * (turn[SQUARE] + progress * turn[CUBE]));
    progress = smaller(1.0, larger(0.0, progress));
    if (turn[COURSE] == QUINTIC) {
        real rest = 1.0 - progress;
        return turn[AMPLITUDE] / (turn[DURATION] * turn[DURATION]) * 60.0 * progress * rest * (rest - progress);
    }
    real x = PI * progress, w = PI / turn[DURATION];
    return turn[AMPLITUDE] / 16.0 * w * w * 9.0 * (cos_of(x) - cos_of(3.0 * x));
}

/* Second derivative of a law, rad/s^2: the sum of its turns'. */
static real law_acceleration(const chain *chain, int64_t k, real t_s)
{
    const real *law = law_of(chain, k);
    real total = turn_acceleration(law + FIRST_TURN, t_s);
    for (int64_t c = FIRST_TURN + TURN_COLUMNS; c < chain->laws.columns; c += TURN_COLUMNS)
        total += turn_acceleration(law + c, t_s);
    return total;
}

/* Angular acceleration of `bar` per unit torque of `law`, without reactions, 1/(kg m^2). */
static real rotation_per_unit_torque(const real *law, int64_t bar, int64_t n, const real *bars)
{
    if (bar == (int64_t)law[BAR])
        return bars[INVERSE_INERTIA * n + bar];
    if (bar == (int64_t)law[REACTS_ON])
        return -bars[INVERSE_INERTIA * n + bar];
    return 0.0;
}

/* workspace.responses: reactions to a unit of each prescribed torque, by the same sweeps. */
static bool unit_torque_reactions(int64_t n, const chain *chain, workspace *work)
{
    const real *bars = chain->bars.value;
    real *rows = work->bars.value;
    bool well = true;
    for (int64_t k = 0; k < chain->laws.rows; k++) {
        for (int64_t i = 0; i < n; i++) {
            real turned = bars[HALF * n + i] * rotation_per_unit_torque(law_of(chain, k), i, n, bars);
            real left = SHARE(ALPHA, i) * turned, right = SHARE(BETA, i) * turned;
            rows[RIGHT * n + i] = -right * rows[UY * n + i];
            rows[RIGHT_Y * n + i] = right * rows[UX * n + i];
            rows[LEFT * n + i] = left * rows[UY * n + i];
            rows[LEFT_Y * n + i] = -left * rows[UX * n + i];
        }
        well = reactions(n, bars, rows) && well;
        if (bars[REFINED * n] != 0.0)
            well = refine(n, bars, rows) && well;
        real *response = work->responses.value + 2 * k * n;
        for (int64_t j = 0; j < n - 1; j++) {
            response[j] = rows[RX * n + j];
            response[n + j] = rows[RY * n + j];
        }
    }
    return well;
}

/* Sum of the reactions R_j and R_{j-1} on a bar, each times a factor. */
static inline pair reactions_on(int64_t n, int64_t bar, real after, real before, const real *x, const real *y)
{
    real after_x = bar < n - 1 ? x[bar] : 0.0, after_y = bar < n - 1 ? y[bar] : 0.0;
    real before_x = bar > 0 ? x[bar - 1] : 0.0, before_y = bar > 0 ? y[bar - 1] : 0.0;
    return (pair){after * after_x + before * before_x, after * after_y + before * before_y};
}

/* Angular acceleration of `bar` from reactions (x, y): (l/2J) n.(beta R_j + alpha R_{j-1}). */
static real rotation_from_reactions(int64_t n, int64_t bar, const real *x, const real *y, const real *bars,
                                      const real *rows)
{
    pair sum = reactions_on(n, bar, SHARE(BETA, bar), SHARE(ALPHA, bar), x, y);
    return bars[LEVER * n + bar] * (rows[UX * n + bar] * sum.y - rows[UY * n + bar] * sum.x);
}

/* Acceleration of the angle prescribed by `law`: `angular`, of the bar or of the joint, minus the longitude's for the local
 * horizontal.
 *
 * Gravity is central. Only reactions and noncentral effects accelerate the bar's longitude; for effects see
 * noncentral_longitude_acceleration.
 */
static real actual_angle_acceleration(int64_t n, const real *law, real angular, const real *x, const real *y,
                                        pair place, const real *bars)
{
    if (law[FRAME] != LOCAL_HORIZONTAL)
        return angular;
    int64_t bar = (int64_t)law[BAR];
    pair pull = reactions_on(n, bar, 1.0, -1.0, x, y);
    real turned = bars[INVERSE_MASS * n + bar] * (place.x * pull.y - place.y * pull.x);
    return angular - turned / (place.x * place.x + place.y * place.y);
}

/* The effects' acceleration of the longitude of a law's bar, rad/s^2. */
static real noncentral_longitude_acceleration(int64_t n, const real *law, pair place, const workspace *work)
{
    int64_t bar = (int64_t)law[BAR];
    const real *common = work->effect_common.value, *moved = work->effect_bars.value;
    real across_x = common[NONCENTRAL_X] + moved[AX * n + bar], across_y = common[NONCENTRAL_Y] + moved[AY * n + bar];
    return (place.x * across_y - place.y * across_x) / (place.x * place.x + place.y * place.y);
}

/* Position and velocity of a bar's centre from the centre of the body. */
static void bar_position_and_velocity(int64_t n, int64_t bar, const real *y, const real *bars, const real *rows,
                                      pair *position, pair *velocity)
{
    real place_x = 0.0, place_y = 0.0, motion_x = 0.0, motion_y = 0.0;
    real centre_x = 0.0, centre_y = 0.0, drift_x = 0.0, drift_y = 0.0;
    real x = 0.0, z = 0.0, vx = 0.0, vz = 0.0;
    for (int64_t i = 0; i < n; i++) {
        real half = bars[HALF * n + i], share = bars[WEIGHT * n + i], rate = y[n + 2 + i];
        real alpha = SHARE(ALPHA, i) * half, beta = SHARE(BETA, i) * half;
        real rx = alpha * rows[UX * n + i], rz = alpha * rows[UY * n + i];
        if (i > 0) {
            x += rx;
            z += rz;
            vx -= rate * rz;
            vz += rate * rx;
        }
        if (i == bar) {
            place_x = x;
            place_y = z;
            motion_x = vx;
            motion_y = vz;
        }
        centre_x += share * x;
        centre_y += share * z;
        drift_x += share * vx;
        drift_y += share * vz;
        rx = beta * rows[UX * n + i];
        rz = beta * rows[UY * n + i];
        x += rx;
        z += rz;
        vx -= rate * rz;
        vz += rate * rx;
    }
    *position = (pair){y[n] + (place_x - centre_x), y[n + 1] + (place_y - centre_y)};
    *velocity = (pair){y[2 * n + 2] + (motion_x - drift_x), y[2 * n + 3] + (motion_y - drift_y)};
}

/* Prescribed value of actual_angle_acceleration: the law's acceleration minus the velocity-dependent part of the
 * longitude's, 2 (Z.Z')(ZxZ')/r^4. */
static real prescribed_angle_acceleration(const chain *chain, int64_t k, real t_s, pair z, pair v)
{
    real law_s2 = law_acceleration(chain, k, t_s);
    if (law_of(chain, k)[FRAME] != LOCAL_HORIZONTAL)
        return law_s2;
    real r2 = z.x * z.x + z.y * z.y;
    return law_s2 - 2.0 * (z.x * v.x + z.y * v.y) * (z.x * v.y - z.y * v.x) / (r2 * r2);
}

/* Solve the small dense system [A | b] by Gaussian elimination with row pivots, in place. */
static void solve_dense(int64_t size, real *system, real *found)
{
    int64_t columns = size + 1;
    for (int64_t k = 0; k < size; k++) {
        int64_t pivot = k;
        for (int64_t i = k + 1; i < size; i++)
            if (magnitude(system[i * columns + k]) > magnitude(system[pivot * columns + k]))
                pivot = i;
        for (int64_t j = k; j < columns; j++) {
            real moved = system[k * columns + j];
            system[k * columns + j] = system[pivot * columns + j];
            system[pivot * columns + j] = moved;
        }
        for (int64_t i = k + 1; i < size; i++) {
            real factor = system[i * columns + k] / system[k * columns + k];
            for (int64_t j = k; j < columns; j++)
                system[i * columns + j] -= factor * system[k * columns + j];
        }
    }
    for (int64_t k = size - 1; k >= 0; k--) {
        real total = system[k * columns + size];
        for (int64_t j = k + 1; j < size; j++)
            total -= system[k * columns + j] * found[j];
        found[k] = total / system[k * columns + k];
    }
}

/* workspace.torque_N_m, from the free reactions and the responses; adds the torques' part to the reactions. */
static void apply_prescribed_torques(int64_t n, real t_s, const real *y, const chain *chain, workspace *work)
{
    const real *bars = chain->bars.value, *responses = work->responses.value;
    real *rows = work->bars.value, *system = work->torque_system.value, *torque = work->torque_N_m.value;
    real *free_x = rows + RX * n, *free_y = rows + RY * n;
    int64_t count = chain->laws.rows;
    for (int64_t k = 0; k < count; k++) {
        const real *law = law_of(chain, k);
        int64_t bar = (int64_t)law[BAR];
        pair z, v;
        bar_position_and_velocity(n, bar, y, bars, rows, &z, &v);
        real angular = rows[ANGULAR * n + bar] + rotation_from_reactions(n, bar, free_x, free_y, bars, rows);
        if (law[FRAME] == PREVIOUS_BAR)
            angular -= rows[ANGULAR * n + bar - 1] + rotation_from_reactions(n, bar - 1, free_x, free_y, bars, rows);
        real lacking = prescribed_angle_acceleration(chain, k, t_s, z, v)
                         - actual_angle_acceleration(n, law, angular, free_x, free_y, z, bars);
        real *row = system + k * (count + 1);
        row[count] = law[UNIT] * lacking;
        if (chain->effect_count > 0 && law[FRAME] == LOCAL_HORIZONTAL)
            row[count] += law[UNIT] * noncentral_longitude_acceleration(n, law, z, work);
        for (int64_t other = 0; other < count; other++) {
            const real *second = law_of(chain, other);
            const real *rx = responses + 2 * other * n, *ry = rx + n;
            real turned = rotation_from_reactions(n, bar, rx, ry, bars, rows)
                            + rotation_per_unit_torque(second, bar, n, bars);
            if (law[FRAME] == PREVIOUS_BAR)
                turned -= rotation_from_reactions(n, bar - 1, rx, ry, bars, rows)
                          + rotation_per_unit_torque(second, bar - 1, n, bars);
            /* nondimensional, as pivots chosen across bars of very different size lose the laws of light bars */
            real unit = law[UNIT] * second[UNIT];
            row[other] = unit * actual_angle_acceleration(n, law, turned, rx, ry, z, bars);
        }
    }
    solve_dense(count, system, torque);
    for (int64_t k = 0; k < count; k++) {
        torque[k] *= law_of(chain, k)[UNIT];
        for (int64_t j = 0; j < n - 1; j++) {
            free_x[j] += torque[k] * responses[2 * k * n + j];
            free_y[j] += torque[k] * responses[(2 * k + 1) * n + j];
        }
    }
}

#endif
