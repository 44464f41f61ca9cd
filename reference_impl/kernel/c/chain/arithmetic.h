/* The numbers of the equations: `real`.
 *
 * kernel.c compiles the equations with `real` as the `number` of kernel.h: double, or with WIDE long double. lanes.c
 * compiles the same sources with LANES defined: `real` is then a vector of doubles, one chain in each lane, and `flag` a
 * mask, all bits of a lane set or none.
 */
#ifndef ARITHMETIC_H
#define ARITHMETIC_H

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "../kernel.h"

static const number PI = 3.14159265358979323846264338327950288L;
#ifdef WIDE
#define EPSILON LDBL_EPSILON
#else
#define EPSILON DBL_EPSILON
#endif

#ifndef LANES

typedef number real;
typedef bool flag;

static inline real every(number x) { return x; }
static inline real choose(flag which, real a, real b) { return which ? a : b; }
static inline bool in_all_lanes(flag which) { return which; }
static inline flag never(void) { return false; }

#ifdef WIDE

static inline real root(real x) { return sqrtl(x); }
static inline real magnitude(real x) { return fabsl(x); }
static inline real distance(real x, real y) { return hypotl(x, y); }
static inline real eighth_root(real x) { return powl(x, 0.125L); }
static inline real cos_of(real x) { return cosl(x); }
static inline real sin_of(real x) { return sinl(x); }
static inline real exp_of(real x) { return expl(x); }
static inline real spacing(real x) { return nextafterl(x, INFINITY) - x; }

#else

static inline real root(real x) { return sqrt(x); }
static inline real magnitude(real x) { return fabs(x); }
static inline real distance(real x, real y) { return hypot(x, y); }
static inline real eighth_root(real x) { return pow(x, 0.125); }
static inline real cos_of(real x) { return cos(x); }
static inline real sin_of(real x) { return sin(x); }
static inline real exp_of(real x) { return exp(x); }
static inline real spacing(real x) { return nextafter(x, INFINITY) - x; }

/* The same 64 bits as an integer, and back. */
typedef uint64_t word;

static inline word as_word(real x)
{
    word bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static inline real as_real(word bits)
{
    real x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

#endif

#else

#if defined __AVX512F__
#include <immintrin.h>
#define WIDTH 8
#else
#define WIDTH 4 /* one register of AVX2, or two of SSE2 or NEON */
#if defined __x86_64__
#include <immintrin.h>
#elif defined __aarch64__
#include <arm_neon.h>
#endif
#endif

typedef double real __attribute__((vector_size(WIDTH * sizeof(double))));
typedef int64_t flag __attribute__((vector_size(WIDTH * sizeof(int64_t))));

static inline real every(double x) { return x - (real){0.0}; }
static inline flag never(void) { return (flag){0}; }

static inline real root(real x)
{
#if defined __AVX512F__
    return (real)_mm512_sqrt_pd((__m512d)x);
#elif defined __AVX__
    return (real)_mm256_sqrt_pd((__m256d)x);
#else
    real found = x;
    for (int lane = 0; lane < WIDTH; lane++)
        found[lane] = sqrt(x[lane]);
    return found;
#endif
}

/* Registers of vectors have square roots, but neither an eighth root nor a hypotenuse. */
static inline real distance(real x, real y) { return root(x * x + y * y); }
static inline real eighth_root(real x) { return root(root(root(x))); }

static inline real choose(flag which, real a, real b) { return (real)((which & (flag)a) | (~which & (flag)b)); }

/* Flags as the bits of an integer, bit 0 that of lane 0. */
static inline int64_t bits(flag which)
{
#if defined __AVX512F__
    return _mm512_cmplt_epi64_mask((__m512i)which, _mm512_setzero_si512());
#elif defined __AVX__
    return _mm256_movemask_pd((__m256d)which);
#else
    int64_t found = 0;
    for (int lane = 0; lane < WIDTH; lane++)
        found |= (int64_t)(which[lane] != 0) << lane;
    return found;
#endif
}

static inline bool in_all_lanes(flag which) { return bits(which) == (1 << WIDTH) - 1; }
static inline real magnitude(real x) { return (real)((flag)x & INT64_MAX); }

typedef uint64_t word __attribute__((vector_size(WIDTH * sizeof(uint64_t))));

static inline word as_word(real x) { return (word)x; }
static inline real as_real(word bits) { return (real)bits; }

#endif

#ifndef WIDE
/* 1.5 * 2^52: its addition rounds to an integer, and leaves the integer in the last bits of the sum. */
static const double ROUNDER = 6755399441055744.0;

/* `a` where all bits of `mask` are set, `b` where none is; compilers vectorize it where they do not vectorize flags. */
static inline real blend(word mask, real a, real b) { return as_real((mask & as_word(a)) | (~mask & as_word(b))); }
#endif

/* The second number beside NaN. */
static inline real smaller(real a, real b) { return choose(a < b, a, b); }
static inline real larger(real a, real b) { return choose(a > b, a, b); }

#endif
