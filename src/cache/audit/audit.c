/* From groups of probes to an estimate and its bounds.
 *
 * Groups are drawn alike and independently, so (m - E[m]) / (s / sqrt(G)) of the mean m of G group means, s their spread, has
 * Student's t distribution with G - 1 degrees of freedom, as nearly as the means are normal. Squared errors have heavy tails: a few
 * pixels (edges, fireflies) may hold most of the error, and if no probe met any of them, nothing in the sample tells. What n probes
 * did not meet is, with 95 % confidence, less than 3/n of the picture (the rule of three: (1 - 3/n)^n = 5 %); the bound grants it the
 * largest square that was met. And an estimate below 0, which noise can make, counts as 0: a lucky draw must not lower the bound. */
#include "cache/audit/audit.h"

#include <math.h>

enum { RULE_OF_THREE = 3 };

/* The 95 % quantile of Student's t: the first terms of its expansion about the normal's (Abramowitz and Stegun 26.7.5), to 1e-3 from 6
 * degrees of freedom on. */
static double student_95(double degrees) {
    const double z = 1.6448536269514722, z3 = z * z * z, z5 = z3 * z * z, z7 = z5 * z * z;
    double n = degrees;
    return z + (z3 + z) / (4.0 * n) + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * n * n) +
           (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / (384.0 * n * n * n);
}

typedef struct moments {
    double count, mean, spread; /* spread: standard error of the mean, times the quantile */
} moments;

/* which: 0 squares, 1 differences. Groups of which nothing is left (all their pixels are NaN) do not count. */
static double group_mean(const sl_audit_group *g, int which) { return (which == 0 ? g->squares : g->differences) / (double)g->values; }

static moments group_moments(const sl_audit_group *groups, size_t count, int which) {
    moments m = {0.0, 0.0, INFINITY};
    double sum = 0.0, squares = 0.0;
    for (size_t i = 0; i < count; i++) {
        if (!groups[i].values) continue;
        sum += group_mean(&groups[i], which);
        m.count += 1.0;
    }
    if (m.count > 0.0) m.mean = sum / m.count;
    for (size_t i = 0; i < count; i++) {
        if (!groups[i].values) continue;
        double d = group_mean(&groups[i], which) - m.mean;
        squares += d * d;
    }
    if (m.count > 1.0) m.spread = student_95(m.count - 1.0) * sqrt(squares / (m.count * (m.count - 1.0)));
    return m;
}

static double larger(double a, double b) { return a > b ? a : b; }

/* As in a comparison: 0/0 is 0, no error of a black picture; anything else to 0 is infinite. What is not a number promises nothing. */
static double ratio(double a, double b) {
    if (a == 0.0) return 0.0;
    double q = b > 0.0 ? a / b : INFINITY;
    return q >= 0.0 ? q : INFINITY;
}

void sl_audit_conclude(const sl_audit_group *groups, size_t count, double mean_image, sl_error_estimate *e) {
    double largest = 0.0, noise = 0.0, values = 0.0;
    for (size_t i = 0; i < count; i++) {
        largest = larger(largest, groups[i].largest);
        noise += groups[i].noise;
        values += (double)groups[i].values;
    }
    moments square = group_moments(groups, count, 0), difference = group_moments(groups, count, 1);
    double mean_square = larger(square.mean, 0.0), pixels = larger(values / 3.0, 1.0);
    double upper = mean_square + square.spread + RULE_OF_THREE * largest / pixels;
    e->mean = mean_image - difference.mean;
    e->rmse = sqrt(mean_square);
    e->noise = values > 0.0 ? sqrt(larger(noise / values, 0.0)) : 0.0;
    e->rel_rmse = ratio(e->rmse, fabs(e->mean));
    e->bound = ratio(sqrt(upper), fabs(e->mean) - difference.spread);
    e->least = ratio(sqrt(larger(square.mean - square.spread, 0.0)), fabs(e->mean) + difference.spread);
    if (e->nonfinite || !(values > 0.0)) e->bound = INFINITY;
}

double sl_audit_mean(const float *const planes[3], size_t pixels, uint64_t *nonfinite) {
    double sum = 0.0;
    *nonfinite = 0;
    for (size_t i = 0; i < pixels; i++) {
        bool finite = isfinite(planes[0][i]) && isfinite(planes[1][i]) && isfinite(planes[2][i]);
        if (finite) sum += (double)planes[0][i] + (double)planes[1][i] + (double)planes[2][i];
        else *nonfinite += 1;
    }
    size_t finite = pixels - (size_t)*nonfinite;
    return finite ? sum / (3.0 * (double)finite) : 0.0;
}
