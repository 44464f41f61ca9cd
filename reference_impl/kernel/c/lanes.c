/* Ensembles: W chains in step, one in each lane of the processor's vector registers; see docs/studies/ensemble.md.
 *
 * `real` is a vector here, and the equations and steps are those of one chain, compiled from the same sources. No
 * operation combines lanes: the numbers of a chain depend neither on its lane nor on its neighbours. Each lane has its
 * own step size and error control. A lane whose chain has arrived takes the next chain of the queue; chains begin W at a
 * time in a second group, from which lanes are refilled. Samples of a step come from its interpolant, W samples of a
 * chain at a time; the reactions at the samples are evaluated when the chain has arrived, again W at a time.
 *
 * Lanes serve free chains of equal levers with gravity alone. Prescribed rotations, effects, unequal levers and
 * ill-conditioned chains stay with integrate_batch, and so do chains that lanes give back: those that may touch the
 * surface, lose a joint, or turn beyond the range of the sine.
 */
#define LANES
#include <stdlib.h>

#include "chain/free_chain.h"
#include "kernel.h"

/* W chains in step: their clocks and constants, and arrays of W numbers in each element. */
typedef struct {
    real now, step, reached, taken; /* s; `reached` and `taken` are the end and the size of the last step */
    flag rejected;                  /* after a rejected step */
    real mu, radius, perigee, pull; /* m^3/s^2, and the bounds of surface_bounds */
    int64_t member[WIDTH], sampled[WIDTH], steps[WIDTH], evaluations[WIDTH];
    real *bars;                            /* (CONSTANT_ROWS, N) */
    real *rows;                            /* (SCRATCH_ROWS, N) */
    real *y, *atol, *allowed, *end;        /* (2N+4,) each */
    real *slopes;                          /* (16, 2N+4) */
    real *powers;                          /* (7, 2N+4) */
} group;

typedef struct {
    int64_t n, gravity;
    group *g;
} motion;

/* Rates of the states y, in all lanes; gravity alone. */
static flag evaluate(real t_s, const real *y, real *rates, motion m)
{
    (void)t_s;
    return evaluate_free_chain(m.n, m.gravity, m.g->mu, m.g->bars, y, rates, m.g->rows);
}

#include "steps/step_bounds.h"

enum { ARRIVED = 0, GIVEN_BACK = -1 };
static const double MOST_TURNED_RAD = 0.5e5; /* no stage of a step then leaves the range of the sine */
static const double LEAST_STEP = 10.0 * 0x1p-52; /* of the time */

/* Numbers of W in the arrays of a group. */
static int64_t group_size(int64_t n) { return (CONSTANT_ROWS + SCRATCH_ROWS) * n + (4 + SLOPES + POWERS) * (2 * n + 4); }

/* A group in memory for group_size elements. */
static group group_in(real *memory, int64_t n)
{
    int64_t size = 2 * n + 4;
    group g = {0};
    g.bars = memory;
    g.rows = g.bars + CONSTANT_ROWS * n;
    g.y = g.rows + SCRATCH_ROWS * n;
    g.atol = g.y + size;
    g.allowed = g.atol + size;
    g.end = g.allowed + size;
    g.slopes = g.end + size;
    g.powers = g.slopes + SLOPES * size;
    return g;
}

/* Put one chain at its start into a lane. */
static void load_member(group *g, int lane, int64_t r, const batch_members *members)
{
    int64_t n = members->bars.columns, size = 2 * n + 4;
    const double *bars = members->bars.value + r * CONSTANT_ROWS * n, *bounds = members->bounds.value + 3 * r;
    g->member[lane] = r;
    g->sampled[lane] = 1;
    g->steps[lane] = 0;
    g->evaluations[lane] = 2;
    g->mu[lane] = members->mu_m3_s2.value[r];
    g->radius[lane] = bounds[0];
    g->perigee[lane] = bounds[1];
    g->pull[lane] = bounds[2];
    for (int64_t i = 0; i < CONSTANT_ROWS * n; i++)
        g->bars[i][lane] = bars[i];
    for (int64_t i = 0; i < size; i++) {
        g->y[i][lane] = members->y0.value[r * members->y0.columns + i];
        g->atol[i][lane] = members->atol.value[r * members->atol.columns + i];
    }
}

/* Move the chain of a lane at its start to a lane of another group. */
static void move_member(int64_t n, const group *from, int slot, group *to, int lane)
{
    int64_t size = 2 * n + 4;
    to->member[lane] = from->member[slot];
    to->sampled[lane] = from->sampled[slot];
    to->steps[lane] = from->steps[slot];
    to->evaluations[lane] = from->evaluations[slot];
    to->now[lane] = from->now[slot];
    to->step[lane] = from->step[slot];
    to->rejected[lane] = 0;
    to->mu[lane] = from->mu[slot];
    to->radius[lane] = from->radius[slot];
    to->perigee[lane] = from->perigee[slot];
    to->pull[lane] = from->pull[slot];
    for (int64_t i = 0; i < CONSTANT_ROWS * n; i++)
        to->bars[i][lane] = from->bars[i][slot];
    for (int64_t i = 0; i < size; i++) {
        to->y[i][lane] = from->y[i][slot];
        to->atol[i][lane] = from->atol[i][slot];
        to->allowed[i][lane] = from->allowed[i][slot];
        to->slopes[i][lane] = from->slopes[i][slot];
    }
}

/* Flags of finite states, with angles that the sine of all lanes supports. */
static flag sound(int64_t n, const real *y)
{
    real total = every(0.0), turned = total;
    for (int64_t i = 0; i < 2 * n + 4; i++)
        total += magnitude(y[i]);
    for (int64_t i = 0; i < n; i++)
        turned = larger(turned, magnitude(y[i]));
    return (total < INFINITY) & (turned < MOST_TURNED_RAD);
}

/* Current rates, allowed error and first step of all lanes; two evaluations. Returns the lanes to be given back. */
static flag begin(motion m, double start_s, double end_s)
{
    group *g = m.g;
    int64_t size = 2 * m.n + 4;
    flag lost = evaluate(every(start_s), g->y, g->slopes, m) | ~sound(m.n, g->y);
    set_allowed_error(m.n, ~never(), g->bars, g->rows, g->y, g->atol, g->allowed);
    g->step = first_step(size, size, every(start_s), end_s - start_s, g->y, g->slopes, g->end, g->atol, m);
    g->now = every(start_s);
    g->rejected = never();
    return lost;
}

/* Try a step towards end_s in every lane; set the next step's size. Returns the lanes whose step is accepted, and in
 * `lost` those to be given back. */
static flag try_step(motion m, double end_s, flag *lost)
{
    group *g = m.g;
    int64_t n = m.n, size = 2 * n + 4;
    real least = LEAST_STEP * magnitude(g->now);
    g->reached = smaller(g->now + larger(g->step, least), every(end_s));
    real h = g->taken = g->reached - g->now;
    *lost = advance(size, g->now, h, g->y, g->slopes, g->end, m);
    real error = error_norm(size, size, h, g->y, g->end, g->slopes, g->allowed, RTOL_FLOOR);
    flag accepted = error < 1.0;
    g->step = h * step_factor(error, g->rejected);
    g->rejected = ~accepted;
    set_allowed_error(n, accepted, g->bars, g->rows, g->end, g->atol, g->allowed);
    flag clear = clears_surface(n, m.gravity, g->mu, h, g->y, g->end, g->radius, g->perigee, g->pull);
    clear = sound(n, g->end) & (clear | (g->radius <= 0.0));
    *lost |= (accepted & ~clear) | ~(accepted | (g->step >= least));
    return accepted & ~*lost;
}

/* Begin the next step of the lanes whose step is accepted: the step's end becomes the current state. */
static void go_on(motion m, flag accepted)
{
    group *g = m.g;
    int64_t size = 2 * m.n + 4;
    const real *last = g->slopes + STAGES * size;
    g->now = choose(accepted, g->reached, g->now);
    for (int64_t i = 0; i < size; i++) {
        g->y[i] = choose(accepted, g->end[i], g->y[i]);
        g->slopes[i] = choose(accepted, last[i], g->slopes[i]);
    }
}

/* A queue of chains, the groups that run them, and the states at the samples of each lane's chain. */
typedef struct {
    motion running, ready, single; /* chains in step; chains at their start; one chain in all lanes, at W samples */
    const batch_members *members;
    batch_results *results;
    int64_t samples;   /* n */
    const double *t_s; /* (n + W,) sample instants, then infinity */
    double *states;    /* (W, 2N+4, n + W), component by component */
    int64_t following; /* next chain that has not begun */
    int64_t waiting;   /* bits of the chains in `ready` that wait for a lane */
} queue;

/* W numbers of a row of `states`. */
static inline real load(const double *from)
{
    real found;
    memcpy(&found, from, sizeof found);
    return found;
}

static inline void store(double *to, real x) { memcpy(to, &x, sizeof x); }

static double *states_of(const queue *q, int lane)
{
    return q->states + lane * (2 * q->running.n + 4) * (q->samples + WIDTH);
}

/* Begin the next W chains: they wait, or are given back. */
static void prepare(queue *q)
{
    int64_t last = q->members->mu_m3_s2.length - 1;
    for (int lane = 0; lane < WIDTH; lane++) { /* lanes beyond the last chain repeat it */
        int64_t r = q->following + lane < last ? q->following + lane : last;
        load_member(q->ready.g, lane, r, q->members);
    }
    int64_t lost = bits(begin(q->ready, q->t_s[0], q->t_s[q->samples - 1]));
    for (int lane = 0; lane < WIDTH && q->following <= last; lane++, q->following++) {
        if (lost >> lane & 1)
            q->results->code.value[q->following] = GIVEN_BACK;
        else
            q->waiting |= (int64_t)1 << lane;
    }
}

/* Move waiting chains to idle lanes; returns the bits of busy lanes, 0 after the last chain. */
static int64_t refill(queue *q, int64_t busy)
{
    int64_t n = q->running.n;
    for (int lane = 0; lane < WIDTH; lane++) {
        if (busy >> lane & 1)
            continue;
        while (!q->waiting && q->following < q->members->mu_m3_s2.length)
            prepare(q);
        if (!q->waiting)
            continue;
        int slot = 0;
        while (!(q->waiting >> slot & 1))
            slot++;
        q->waiting ^= (int64_t)1 << slot;
        busy |= (int64_t)1 << lane;
        move_member(n, q->ready.g, slot, q->running.g, lane);
        for (int64_t i = 0; i < 2 * n + 4; i++)
            states_of(q, lane)[i * (q->samples + WIDTH)] = q->ready.g->y[i][slot];
    }
    return busy;
}

/* Next states of one lane's chain at up to W samples within the step; later steps overwrite those beyond it. */
static void interpolate_lane(queue *q, int lane)
{
    const group *g = q->running.g;
    int64_t size = 2 * q->running.n + 4, room = q->samples + WIDTH, first = g->sampled[lane], last = first;
    double *states = states_of(q, lane), reached = g->reached[lane];
    real t = load(q->t_s + first), x = (t - g->now[lane]) / g->taken[lane];
    flag at_end = t >= reached;
    for (int64_t i = 0; i < size; i++) {
        number powers[POWERS];
        for (int k = 0; k < POWERS; k++)
            powers[k] = g->powers[k * size + i][lane];
        store(states + i * room + first, choose(at_end, every(g->end[i][lane]), g->y[i][lane] + interpolated_change(x, powers)));
    }
    while (last < room && q->t_s[last] <= reached && last < first + WIDTH)
        last++;
    q->running.g->sampled[lane] = last;
}

/* Samples of the accepted steps, from their ends or their interpolants. */
static void sample_step(queue *q, int64_t accepted)
{
    group *g = q->running.g;
    bool inside = false;
    for (int lane = 0; lane < WIDTH; lane++)
        if (accepted >> lane & 1 && q->t_s[g->sampled[lane]] < g->reached[lane]) {
            inside = true;
            g->evaluations[lane] += EXTRA;
        }
    if (inside) /* rows R of the step's end are not needed any more */
        interpolant(2 * q->running.n + 4, g->now, g->taken, g->y, g->end, g->slopes, q->single.g->end, g->powers,
                    q->running);
    for (int lane = 0; lane < WIDTH; lane++)
        while (accepted >> lane & 1 && q->t_s[g->sampled[lane]] <= g->reached[lane])
            interpolate_lane(q, lane);
}

/* Counts of a chain that has arrived, and its angles and sizes of reactions at all samples. */
static void record(queue *q, int lane)
{
    const group *g = q->running.g;
    group *one = q->single.g;
    batch_results *found = q->results;
    int64_t n = q->running.n, size = 2 * n + 4, count = q->samples, r = g->member[lane];
    found->code.value[r] = ARRIVED;
    found->steps.value[r] = (double)g->steps[lane];
    found->evaluations.value[r] = (double)g->evaluations[lane];
    one->mu = every(g->mu[lane]);
    for (int64_t i = 0; i < CONSTANT_ROWS * n; i++)
        one->bars[i] = every(g->bars[i][lane]);
    for (int64_t first = 0; first < count; first += WIDTH) {
        for (int64_t i = 0; i < size; i++)
            one->y[i] = load(states_of(q, lane) + i * (count + WIDTH) + first);
        evaluate(every(0.0), one->y, one->end, q->single);
        for (int64_t i = 0; i < n - 1; i++)
            one->rows[RX * n + i] = distance(one->rows[RX * n + i], one->rows[RY * n + i]);
        for (int k = 0; k < WIDTH && first + k < count; k++) {
            double *angle = found->angle_rad.value + (r * count + first + k) * n;
            double *reaction = found->reaction_N.value + (r * count + first + k) * (n - 1);
            for (int64_t i = 0; i < n; i++)
                angle[i] = one->y[i][k];
            for (int64_t i = 0; i < n - 1; i++)
                reaction[i] = one->rows[RX * n + i][k];
        }
    }
}

static void run_queue(queue *q)
{
    group *g = q->running.g;
    double end_s = q->t_s[q->samples - 1];
    int64_t busy = 0;
    while ((busy = refill(q, busy))) {
        flag lost, accepted = try_step(q->running, end_s, &lost);
        int64_t taken = bits(accepted) & busy, given_back = bits(lost);
        for (int lane = 0; lane < WIDTH; lane++)
            g->evaluations[lane] += STAGES;
        sample_step(q, taken);
        go_on(q->running, accepted);
        for (int lane = 0; lane < WIDTH; lane++) {
            if (!(busy >> lane & 1))
                continue;
            g->steps[lane] += taken >> lane & 1;
            if (given_back >> lane & 1) {
                q->results->code.value[g->member[lane]] = GIVEN_BACK;
                busy ^= (int64_t)1 << lane;
            } else if (g->now[lane] >= end_s) {
                record(q, lane);
                busy ^= (int64_t)1 << lane;
            }
        }
    }
}

/* Chains side by side. */
int64_t lane_count(void) { return WIDTH; }

static void *aligned_memory(int64_t bytes)
{
    int64_t whole = (bytes + (int64_t)sizeof(real) - 1) / (int64_t)sizeof(real) * (int64_t)sizeof(real);
    void *memory = aligned_alloc(sizeof(real), whole);
    if (memory)
        memset(memory, 0, whole);
    return memory;
}

/* Run all chains of a batch over the samples t_s (n,); one that lanes can't run gets the code GIVEN_BACK and no samples.
 *
 * False without memory. The chains have no effects and no laws, and are well-conditioned.
 */
bool integrate_in_lanes(const batch_members *members, const vector *t_s, batch_results *results)
{
    int64_t n = members->bars.columns, gravity = members->gravity, samples = t_s->length;
    int64_t each = group_size(n), room = samples + WIDTH, states = WIDTH * (2 * n + 4) * room;
    real *groups = aligned_memory(3 * each * (int64_t)sizeof(real));
    double *numbers = aligned_memory((states + room) * (int64_t)sizeof(double));
    if (groups && numbers) {
        group running = group_in(groups, n), ready = group_in(groups + each, n), single = group_in(groups + 2 * each, n);
        double *instants = numbers + states;
        for (int64_t k = 0; k < room; k++)
            instants[k] = k < samples ? t_s->value[k] : INFINITY;
        queue q = {
            .running = {n, gravity, &running}, .ready = {n, gravity, &ready}, .single = {n, gravity, &single},
            .members = members, .results = results, .samples = samples, .t_s = instants, .states = numbers,
        };
        run_queue(&q);
    }
    bool well = groups && numbers;
    free(groups);
    free(numbers);
    return well;
}

/* Rates (runs, 2N+4) and reactions (runs, 2, N-1) of the starts of at most W chains; bits of those to be given back, -1
 * without memory. For tests. */
int64_t evaluate_in_lanes(const batch_members *members, double *rates, double *reaction_N)
{
    int64_t n = members->bars.columns, size = 2 * n + 4, count = members->mu_m3_s2.length;
    real *memory = aligned_memory(group_size(n) * (int64_t)sizeof(real));
    if (!memory)
        return -1;
    group g = group_in(memory, n);
    for (int lane = 0; lane < WIDTH; lane++)
        load_member(&g, lane, lane < count ? lane : count - 1, members);
    int64_t lost = bits(evaluate(every(0.0), g.y, g.slopes, (motion){n, members->gravity, &g}));
    for (int64_t r = 0; r < count && r < WIDTH; r++) {
        for (int64_t i = 0; i < size; i++)
            rates[r * size + i] = g.slopes[i][r];
        for (int64_t j = 0; j < n - 1; j++) {
            reaction_N[(2 * r) * (n - 1) + j] = g.rows[RX * n + j][r];
            reaction_N[(2 * r + 1) * (n - 1) + j] = g.rows[RY * n + j][r];
        }
    }
    free(memory);
    return lost;
}
