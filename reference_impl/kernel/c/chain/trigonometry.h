/* Sine and cosine of many angles: branch-free, so that one vector instruction serves several bars.
 *
 * The angle is reduced by a multiple of pi/2 in three parts (Cody and Waite), then enters the polynomials of fdlibm's
 * kernels. The error is at most two units in the last place. The mathematical library serves angles beyond that
 * reduction; lanes give back chains with such angles. It serves all angles of the wide type.
 */
#ifndef TRIGONOMETRY_H
#define TRIGONOMETRY_H

#include "arithmetic.h"
#include "layout.h"

#ifdef WIDE

static inline void unit_vectors(int64_t n, const real *restrict angle, real *restrict rows)
{
    for (int64_t i = 0; i < n; i++) {
        rows[UX * n + i] = cos_of(angle[i]);
        rows[UY * n + i] = sin_of(angle[i]);
    }
}

#else

static const double LARGEST_RAD = 1e5; /* up to here, multiples of PART_1 are exact */
static const double PER_QUARTER = 0.6366197723675814;
static const double PART_1 = 1.5707963267341256, PART_2 = 6.077100506303966e-11, PART_3 = 2.0222662487959506e-21;
static const double S1 = -1.66666666666666324348e-01, S2 = 8.33333333332248946124e-03, S3 = -1.98412698298579493134e-04,
                    S4 = 2.75573137070700676789e-06, S5 = -2.50507602534068634195e-08, S6 = 1.58969099521155010221e-10;
static const double C1 = 4.16666666666666019037e-02, C2 = -1.38888888888741095749e-03, C3 = 2.48015872894767294178e-05,
                    C4 = -2.75573143513906633035e-07, C5 = 2.08757232129817482790e-09, C6 = -1.13596475577881948265e-11;

/* Rows U: unit vectors along the first n angles. */
static inline void unit_vectors(int64_t n, const real *restrict angle, real *restrict rows)
{
    real *restrict ux = rows + UX * n, *restrict uy = rows + UY * n;
#ifndef LANES
    int64_t beyond = 0;
#endif
#pragma GCC ivdep
    for (int64_t i = 0; i < n; i++) {
        real x = angle[i];
#ifndef LANES
        beyond += magnitude(x) < LARGEST_RAD ? 0 : 1;
#endif
        real quarters = (x * PER_QUARTER + ROUNDER) - ROUNDER;
        real r = ((x - quarters * PART_1) - quarters * PART_2) - quarters * PART_3;
        real z = r * r;
        real sine = r + r * z * (S1 + z * (S2 + z * (S3 + z * (S4 + z * (S5 + z * S6)))));
        real cosine = 1.0 - 0.5 * z + z * z * (C1 + z * (C2 + z * (C3 + z * (C4 + z * (C5 + z * C6)))));
        word quarter = as_word(quarters + ROUNDER); /* in its last bits */
        word odd = -(quarter & 1);
        real up = blend(odd, cosine, sine), along = blend(odd, sine, cosine);
        uy[i] = as_real(as_word(up) ^ ((quarter & 2) << 62)); /* the sign bit */
        ux[i] = as_real(as_word(along) ^ (((quarter + 1) & 2) << 62));
    }
#ifndef LANES
    if (beyond > 0)
        for (int64_t i = 0; i < n; i++) {
            ux[i] = cos_of(angle[i]);
            uy[i] = sin_of(angle[i]);
        }
#endif
}

#endif

#endif
