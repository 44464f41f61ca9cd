/* C functions that CVODE calls: a chain's rates and its height above the surface, with no Python in between.
 *
 * CVODE passes vectors as N_Vector, and cvode_data as user_data. A SUNDIALS function gives the address of a vector's
 * numbers, which are read and written in place.
 */
#include <math.h>

#include "chain/layout.h"
#include "kernel.h"

bool levers_evaluate_state(double t_s, const number *y, number *rates, const chain *chain, workspace *work);

enum counts { EVALUATIONS, EVENT_CALLS, LOST }; /* of cvode_data.counts; LOST: 1 after a joint was lost in round-off */
enum { GOOD = 0, FATAL = -1 };                  /* CVODE's codes; after the second no smaller step is tried */

/* CVODE's right-hand side. */
int cvode_rates(double t_s, void *state, void *slopes, void *user_data)
{
    cvode_data *own = user_data;
    own->counts.value[EVALUATIONS] += 1.0;
    bool unequal = own->chain->bars.value[UNEQUAL * own->chain->bars.columns] != 0.0;
    double *y = own->numbers_of(state), *rates = own->numbers_of(slopes);
    if ((unequal ? levers_evaluate_state : evaluate_state)(t_s, y, rates, own->chain, own->work))
        return GOOD;
    own->counts.value[LOST] = 1.0;
    return FATAL;
}

/* CVODE's event function. */
int cvode_height(double t_s, void *state, double *height, void *user_data)
{
    (void)t_s;
    cvode_data *own = user_data;
    own->counts.value[EVENT_CALLS] += 1.0;
    height[0] = height_above_surface(own->numbers_of(state), own);
    return GOOD;
}

/* Least distance of any point of a chain from the surface, m. */
double height_above_surface(const double *y, const cvode_data *own)
{
    int64_t n = own->left_m.length;
    const double *left = own->left_m.value, *right = own->right_m.value, *weight = own->weight.value;
    double x = 0.0, z = 0.0, mean_x = 0.0, mean_z = 0.0, least = INFINITY;
    for (int64_t i = 1; i < n; i++) {
        x += right[i - 1] * cos(y[i - 1]) + left[i] * cos(y[i]);
        z += right[i - 1] * sin(y[i - 1]) + left[i] * sin(y[i]);
        mean_x += weight[i] * x;
        mean_z += weight[i] * z;
    }
    x = y[n] - mean_x;
    z = y[n + 1] - mean_z;
    for (int64_t i = 0; i < n; i++) {
        double ux = cos(y[i]), uz = sin(y[i]);
        if (i > 0) {
            x += left[i] * ux + right[i - 1] * cos(y[i - 1]);
            z += left[i] * uz + right[i - 1] * sin(y[i - 1]);
        }
        double foot = fmin(fmax(-(ux * x + uz * z), -left[i]), right[i]); /* nearest point of the bar, from its centre */
        least = fmin(least, hypot(x + foot * ux, z + foot * uz));
    }
    return least - own->body_radius_m;
}
