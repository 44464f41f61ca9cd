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
    PASSED,          /* 2/(w + c), kg */
    FREED,           /* 4w/(w + c) */
    ILL_CONDITIONED, /* 1 in ill-conditioned chains, else 0 */
    REFINED,         /* 1 if reactions are refined, else 0 */
    CONSTANT_ROWS
};

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
