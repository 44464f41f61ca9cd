/* Rows of the constants of a chain and of the scratch memory of an evaluation; row r of bar i is at [r * n + i]. */
#ifndef LAYOUT_H
#define LAYOUT_H

enum gravity { NO_GRAVITY, POINT, GRADIENT };

/* Rows of chain.bars. */
enum bar_constants {
    HALF,            /* l/2, m */
    WEIGHT,          /* m/M */
    INVERSE_MASS,    /* w = 1/m, 1/kg */
    COMPLIANCE,      /* c = l^2/4J, 1/kg */
    LEVER,           /* l/2J, 1/(kg m) */
    INVERSE_INERTIA, /* 1/J, 1/(kg m^2) */
    PASSED,          /* 2 alpha/(w + alpha^2 c), kg, of the sweep from the left */
    FREED,           /* 4w/(w + alpha^2 c) */
    ILL_CONDITIONED, /* 1 in ill-conditioned chains, else 0 */
    REFINED,         /* 1 if reactions are refined, else 0 */
    UNEQUAL,         /* 1 in chains with a centre of mass that is not midway, else 0 */
    ALPHA,           /* distance of the left end from the centre of mass, over l/2 */
    BETA,            /* that of the right end */
    PASSED_RIGHT,    /* 2 beta/(w + beta^2 c), of the sweep from the right */
    FREED_RIGHT,     /* 4w/(w + beta^2 c) */
    CONSTANT_ROWS
};

/* Bar i's number in row ALPHA or BETA. With LEVERS defined the code is that of chains with unequal levers; without, all
 * these numbers are 1 and leave no trace in it. */
#ifdef LEVERS
#define SHARE(row, i) (bars[(row) * n + (i)])
#else
#define SHARE(row, i) (every(1.0))
#endif

/* Rows of workspace.bars. Rows D and B serve the refinement of reactions once the effects are added. */
enum scratch_rows {
    UX, UY,                 /* unit vectors along the bars */
    DX, DY,                 /* centres from the first bar's, m */
    GX, GY,                 /* acceleration minus that of the centre of mass, m/s^2 */
    ANGULAR,                /* angular acceleration without reactions, rad/s^2 */
    LEFT, LEFT_Y,           /* acceleration of the left end without reactions, m/s^2 */
    RIGHT, RIGHT_Y,         /* that of the right end */
    KXX, KXY, KYY,          /* K = c n n^T, 1/kg */
    RX, RY,                 /* joint reactions, N: force on bar j from bar j+1, N-1 of them */
    PX, PY,                 /* reaction of a joint with the part beyond it free, N */
    HXX, HXY, HYX, HYY,     /* reaction of a joint per unit reaction of the next */
    BX, BY,                 /* relative accelerations of joined ends without reactions, m/s^2 */
    LYY,                    /* with LXX, LXY: factors of the Cholesky path */
    SCRATCH_ROWS,
    LXX = PX, LXY = PY      /* a factor and a sweep are never needed together */
};

#endif
