/* The kernel's interface: structures and functions that Python calls through ctypes.
 *
 * Every structure is a row of 64-bit words and is described once in Python, in reference_impl/kernel/layout.py and
 * effects.py; layout_name() and layout_value() let the loader compare both descriptions. Arrays are contiguous, in row-major order. The
 * kernel allocates nothing that outlives a call, holds no state of its own and takes no lock: calls with different
 * steppers and workspaces may run in different threads. It checks no sizes; Python does, before each call.
 *
 * N bars, P prescribed rotations, SI units. The state of a chain is y = [theta (N), Z0 (2), theta' (N), Z0' (2)], padded
 * with zeros to `size`, a multiple of 8.
 */
#ifndef KERNEL_H
#define KERNEL_H

#include <stdbool.h>
#include <stdint.h>

/* Number of all arrays: see wide.c for the wide type. */
#ifdef WIDE
typedef long double number;
#else
typedef double number;
#endif

typedef struct {
    number *value;
    int64_t length;
} vector;

typedef struct {
    number *value;
    int64_t rows, columns;
} matrix;

/* One effect: which of the files in effects/ it is, and a structure with its constants and its mode. */
typedef struct {
    int64_t kind;
    void *own;
} effect;

typedef struct {
    double mu_m3_s2;
    int64_t gravity; /* NO_GRAVITY, POINT or GRADIENT of chain/layout.h */
    matrix bars;     /* (15, N) rows of constants, see chain/layout.h */
    matrix laws;     /* (P, 4+8T) columns, see chain/laws.h */
    const effect *const *effects;
    int64_t effect_count;
} chain;

/* Scratch memory of one evaluation, and its results besides the rates. */
typedef struct {
    matrix bars;          /* (25, N) rows, see chain/layout.h */
    matrix responses;     /* (2P, N) reactions to a unit of each prescribed torque, x and y */
    matrix torque_system; /* (P, P+1) */
    vector torque_N_m;    /* (P,) */
    matrix effect_bars;   /* (4, N), see effects/effect.h; (0, 0) without effects */
    vector effect_common; /* (6,); (0,) without effects */
} workspace;

/* State of an integration between steps. */
typedef struct {
    vector clock;   /* (7,) see steps/stepper.h */
    vector y;       /* (size,) current state */
    vector before;  /* (size,) state before the last step */
    vector end;     /* (size,) scratch */
    matrix slopes;  /* (16, size) rates at the stages; row 0 is the current rate */
    matrix powers;  /* (7, size) interpolant of the last step */
    vector allowed; /* (size,) error allowed in the next step */
    matrix residue; /* (2, size) rounding residues of the current state and of the trial step */
} stepper;

/* Bounds that exclude contact with the surface, see steps/stepper.h. */
typedef struct {
    double contact_free_radius_m; /* 0: no surface */
    double contact_free_perigee_m;
    double largest_pull_m_s2;
} surface_bounds;

/* Chains of a batch, of equal length, gravity, effects and number of laws, one row or block of rows each. */
typedef struct {
    vector mu_m3_s2; /* (runs,) */
    int64_t gravity;
    matrix bars;     /* (15 runs, N) as in chain */
    matrix laws;     /* (P runs, 4+8T) as in chain */
    const effect *const *effects;
    int64_t effect_count;
    matrix bounds; /* (runs, 3) as in surface_bounds */
    matrix y0;     /* (runs, size) */
    matrix atol;   /* (runs, size) */
} batch_members;

typedef struct {
    matrix angle_rad;  /* (runs n, N) */
    matrix reaction_N; /* (runs n, N-1) magnitudes */
    vector code;       /* (runs,) return codes of steps/stepper.h, or GIVEN_BACK of lanes.c */
    vector steps;      /* (runs,) */
    vector evaluations; /* (runs,) */
} batch_results;

/* CVODE's user_data, see cvode.c. */
typedef struct {
    number *(*numbers_of)(void *vector);
    const chain *chain;
    workspace *work;
    vector left_m, right_m; /* (N,) distances of the ends from the centres of mass */
    vector weight; /* (N,) */
    double body_radius_m;
    vector counts; /* (3,) */
} cvode_data;

/* kernel.c; in wide.c the same functions of the wide type, their names with the prefix wide_ */
const char *source_digest(void);
const char *layout_name(int64_t k);
int64_t layout_value(int64_t k);
const char *effect_name(int64_t kind);

bool evaluate_state(double t_s, const number *y, number *rates, const chain *chain, workspace *work);
void evaluate_repeatedly(int64_t times, number *y, number *rates, const chain *chain, workspace *work);
bool observe(int64_t samples, const number *t_s, const number *y, int64_t size, number *scratch, const chain *chain,
             workspace *work, number *reaction_N, number *torque_N_m);

int64_t advance_to(double start_s, double end_s, const surface_bounds *ground, const vector *t_s, matrix *samples,
                   const vector *atol, stepper *s, const chain *chain, workspace *work);
bool take_partial_step(double t_s, double h_s, stepper *s, const chain *chain, workspace *work);
void make_interpolant(stepper *s, const chain *chain, workspace *work);
void interpolate_step(double share, const stepper *s, number *found);
void take_samples(double until_s, const vector *t_s, matrix *samples, bool have_interpolant, stepper *s,
                  const chain *chain, workspace *work);
void begin_next_step(stepper *s);
void integrate_batch(const batch_members *members, const vector *t_s, const matrix *segments_s, stepper *s,
                     workspace *work, matrix *samples, batch_results *results);

/* lanes.c */
int64_t lane_count(void);
bool integrate_in_lanes(const batch_members *members, const vector *t_s, batch_results *results);
int64_t evaluate_in_lanes(const batch_members *members, number *rates, number *reaction_N);

/* cvode.c */
int cvode_rates(double t_s, void *state, void *slopes, void *user_data);
int cvode_height(double t_s, void *state, double *height, void *user_data);
double height_above_surface(const double *y, const cvode_data *own);
#endif
