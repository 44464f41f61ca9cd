/* Counts of an ensemble's values in bins, see barchain/studies/ensemble/counts.py. */
#include <math.h>
#include <string.h>

#include "kernel.h"

/* Bin from the middle of a deviation over its scale: its sign, and the leading bits of its size. */
static inline int64_t bin_of(double deviation, int64_t shift, int64_t first, int64_t side)
{
    int64_t word;
    memcpy(&word, &deviation, sizeof word);
    int64_t sign = word >> 63, distance = ((word & INT64_MAX) >> shift) - first + 1;
    distance = distance < 0 ? 0 : distance > side ? side : distance;
    return (distance ^ sign) - sign;
}

/* Count values (columns, runs) in bins, NaN left out, and keep the least and the most of each column.
 *
 * centre, scale, least, most: (columns,); counts: (columns, 2 side + 1); shift, first, side: SHIFT, LEAST and SIDE of
 * barchain/studies/ensemble/bins.py. The values are overwritten by their deviations over the scale.
 */
void count_in_bins(int64_t columns, int64_t runs, double *values, const double *centre, const double *scale,
                   double *least, double *most, int64_t shift, int64_t first, int64_t side, int64_t *counts)
{
    for (int64_t column = 0; column < columns; column++) {
        double *value = values + column * runs, unit = 1.0 / scale[column], middle = centre[column];
        double low[8], high[8]; /* eight at a time, which a compiler may keep in vector registers */
        for (int k = 0; k < 8; k++) {
            low[k] = least[column];
            high[k] = most[column];
        }
        for (int64_t i = 0; i + 8 <= runs; i += 8)
            for (int k = 0; k < 8; k++) {
                double x = value[i + k];
                low[k] = x < low[k] ? x : low[k];
                high[k] = x > high[k] ? x : high[k];
            }
        for (int64_t i = runs / 8 * 8; i < runs; i++) {
            low[0] = value[i] < low[0] ? value[i] : low[0];
            high[0] = value[i] > high[0] ? value[i] : high[0];
        }
        for (int k = 0; k < 8; k++) {
            least[column] = fmin(least[column], low[k]);
            most[column] = fmax(most[column], high[k]);
        }
        for (int64_t i = 0; i < runs; i++)
            value[i] = (value[i] - middle) * unit;
        int64_t *bins = counts + column * (2 * side + 1) + side;
        for (int64_t i = 0; i < runs; i++)
            if (!isnan(value[i]))
                bins[bin_of(value[i], shift, first, side)]++;
    }
}
