/* Sizes that are tables in time, as reference_impl/effects/timed.py; the mode is the segment of the table. */
#ifndef TIMED_H
#define TIMED_H

#include "effect.h"

/* Size on a segment of a table, (2, k) rows of instants and sizes, extrapolated beyond its ends; 0 in no segment. */
static real size_in_time(const matrix *table, const vector *mode, real t_s)
{
    int64_t piece = (int64_t)mode->value[0];
    if (piece < 0 || piece > table->columns - 2)
        return 0.0;
    const real *time = table->value + piece, *size = table->value + table->columns + piece;
    return size[0] + (size[1] - size[0]) * ((t_s - time[0]) / (time[1] - time[0]));
}

#endif
