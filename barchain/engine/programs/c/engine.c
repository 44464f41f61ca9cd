/* A chain of rigid bars in orbit: reads a request of barchain, writes samples and a result.
 *
 * Unknowns are the place and velocity of the centre of mass, and each bar's angle and rate, so joints stay closed. The
 * reactions solve a linear system. Runge-Kutta of order 4, equal steps. Vectors are complex numbers.
 */
#include <complex.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MOST_BARS = 64, MOST_SAMPLES = 1 << 20, MOST_TEXT = 1 << 25 };
static int bars, gravity, gradient;
static double mu, mass[MOST_BARS], length[MOST_BARS], inertia[MOST_BARS];
static double complex reaction[MOST_BARS + 1]; /* [j]: force on bar j from bar j+1, bars from 1; zero at both ends */

static double dot(double complex a, double complex b) { return creal(a * conj(b)); }

/* Read the numbers of "key" behind "table" in a JSON text, and tell how many there are. */
static int numbers(const char *text, const char *table, const char *key, double *found, int most)
{
    char quoted[64], *end;
    snprintf(quoted, sizeof quoted, "\"%s\":", table);
    const char *at = strstr(text, quoted);
    snprintf(quoted, sizeof quoted, "\"%s\":", key);
    at = strstr(at, quoted) + strlen(quoted);
    for (int count = 0; count < most; count++, at = end + 1) {
        at += strspn(at, " [\n");
        found[count] = strtod(at, &end);
        if (end == at) return count;
        if (*end != ',') return count + 1;
    }
    return most;
}

/* Solve a x = b by elimination; the system is positive definite, with entries up to three places off the diagonal. */
static void solve(int size, double a[][2 * MOST_BARS], double *b)
{
    for (int i = 0; i < size; i++)
        for (int row = i + 1; row < size && row < i + 4; row++) {
            double share = a[row][i] / a[i][i];
            for (int k = i; k < size && k < i + 4; k++) a[row][k] -= share * a[i][k];
            b[row] -= share * b[i];
        }
    for (int i = size - 1; i >= 0; i--) {
        for (int k = i + 1; k < size && k < i + 4; k++) b[i] -= a[i][k] * b[k];
        b[i] /= a[i][i];
    }
}

/* Derivative of the state (centre of mass, its velocity, angles, rates); it sets the reactions. */
static void derivative(const double *y, double *dy)
{
    static double a[2 * MOST_BARS][2 * MOST_BARS], b[2 * MOST_BARS];
    const double *angle = y + 4, *rate = y + 4 + bars;
    double complex u[MOST_BARS], d[MOST_BARS], g[MOST_BARS], com = y[0] + I * y[1], centre = 0, mean = 0;
    double half[MOST_BARS], torque[MOST_BARS], total = 0, r0 = cabs(com), pull = gravity ? mu / (r0 * r0 * r0) : 0;
    for (int j = 0; j < bars; j++) { /* places of the bars' centres, from the first bar's left end on */
        u[j] = cexp(I * angle[j]), half[j] = 0.5 * length[j];
        d[j] = (j ? d[j - 1] + half[j - 1] * u[j - 1] : 0) + half[j] * u[j];
        total += mass[j], centre += mass[j] * d[j];
    }
    for (int j = 0; j < bars; j++) { /* gravity less that at the centre of mass, without subtracting large numbers */
        d[j] -= centre / total;
        double complex z = com + d[j];
        double q = dot(com + z, d[j]) / (r0 * r0), moment = dot(u[j], z) * dot(I * u[j], z) / (r0 * r0);
        g[j] = -pull * (d[j] + expm1(-1.5 * log1p(q)) * z);
        torque[j] = gradient ? 3 * pull * pow(1 + q, -2.5) * inertia[j] * moment : 0;
        mean += mass[j] * g[j] / total;
    }
    memset(a, 0, sizeof a);
    for (int joint = 0; joint < bars - 1; joint++) { /* both bars have one acceleration at the joint */
        double complex right = g[joint + 1] - g[joint];
        for (int bar = joint; bar <= joint + 1; bar++) {
            double n[2] = {-cimag(u[bar]), creal(u[bar])}, turned = half[bar] * half[bar] / inertia[bar];
            int other = bar == joint ? joint - 1 : joint + 1; /* joint at the other end of the bar */
            right -= half[bar] * (I * torque[bar] / inertia[bar] - rate[bar] * rate[bar]) * u[bar];
            for (int row = 0; row < 2; row++)
                for (int column = 0; column < 2; column++) {
                    double moved = (row == column) / mass[bar], both = turned * n[row] * n[column];
                    a[2 * joint + row][2 * joint + column] += both + moved;
                    if (other >= 0 && other < bars - 1) a[2 * joint + row][2 * other + column] += both - moved;
                }
        }
        b[2 * joint] = creal(right), b[2 * joint + 1] = cimag(right);
    }
    solve(2 * (bars - 1), a, b);
    for (int joint = 1; joint < bars; joint++) reaction[joint] = b[2 * joint - 2] + I * b[2 * joint - 1];
    double complex acceleration = mean - pull * com;
    dy[0] = y[2], dy[1] = y[3], dy[2] = creal(acceleration), dy[3] = cimag(acceleration);
    for (int j = 0; j < bars; j++) {
        dy[4 + j] = rate[j];
        dy[4 + bars + j] = (torque[j] + half[j] * dot(I * u[j], reaction[j] + reaction[j + 1])) / inertia[j];
    }
}

static void step(double *y, double h)
{
    static const double at[] = {0, 0.5, 0.5, 1}, weight[] = {1, 2, 2, 1};
    double slope[4 + 2 * MOST_BARS] = {0}, sum[4 + 2 * MOST_BARS] = {0}, z[4 + 2 * MOST_BARS];
    for (int stage = 0; stage < 4; stage++) {
        for (int i = 0; i < 4 + 2 * bars; i++) z[i] = y[i] + at[stage] * h * slope[i];
        derivative(z, slope);
        for (int i = 0; i < 4 + 2 * bars; i++) sum[i] += weight[stage] * slope[i];
    }
    for (int i = 0; i < 4 + 2 * bars; i++) y[i] += h / 6 * sum[i];
}

int main(int count, char **argument)
{
    static char text[MOST_TEXT];
    static double t[MOST_SAMPLES], y[4 + 2 * MOST_BARS], slope[4 + 2 * MOST_BARS];
    double step_s;
    FILE *request = count == 4 ? fopen(argument[1], "r") : NULL;
    if (!request || !fread(text, 1, sizeof text - 1, request)) return puts("usage: engine REQUEST SAMPLES RESULT"), 2;
    bars = numbers(text, "chain", "mass_kg", mass, MOST_BARS);
    numbers(text, "chain", "length_m", length, MOST_BARS);
    numbers(text, "chain", "inertia_kg_m2", inertia, MOST_BARS);
    numbers(text, "central_body", "mu_m3_s2", &mu, 1);
    numbers(text, "start", "com_m", y, 2);
    numbers(text, "start", "com_velocity_m_s", y + 2, 2);
    numbers(text, "start", "angle_rad", y + 4, bars);
    numbers(text, "start", "rate_rad_s", y + 4 + bars, bars);
    numbers(text, "setting", "step_s", &step_s, 1);
    int samples = numbers(text, "version", "sample_times_s", t, MOST_SAMPLES), steps = 0;
    gravity = !strstr(text, "\"gravity\": \"none\""), gradient = strstr(text, "\"gravity\": \"gradient\"") != NULL;

    FILE *table = fopen(argument[2], "w"), *result = fopen(argument[3], "w");
    fprintf(table, "t_s,com_x_m,com_y_m,com_vx_m_s,com_vy_m_s");
    for (int j = 1; j <= bars; j++) fprintf(table, ",angle_%d_rad", j);
    for (int j = 1; j <= bars; j++) fprintf(table, ",rate_%d_rad_s", j);
    for (int j = 1; j < bars; j++) fprintf(table, ",reaction_%d_x_N,reaction_%d_y_N", j, j);
    clock_t begun = clock();
    for (int k = 0; k < samples; k++) {
        for (int left = k ? lround((t[k] - t[k - 1]) / step_s) : 0; left > 0; left--, steps++) step(y, step_s);
        derivative(y, slope);
        fprintf(table, "\n%.17g", t[k]);
        for (int i = 0; i < 4 + 2 * bars; i++) fprintf(table, ",%.17g", y[i]);
        for (int j = 1; j < bars; j++) fprintf(table, ",%.17g,%.17g", creal(reaction[j]), cimag(reaction[j]));
    }
    double seconds = (double)(clock() - begun) / CLOCKS_PER_SEC;
    fprintf(result, "{\"version\": 1, \"seconds\": %.9g, \"steps\": %d}\n", seconds, steps);
    return fclose(table) | fclose(result);
}
