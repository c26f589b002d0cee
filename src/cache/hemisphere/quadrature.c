#include "cache/hemisphere/quadrature.h"

#include "base/math.h"

/* P_n(x) and its derivative; |x| < 1. */
static double legendre(int n, double x, double *derivative) {
    double before = 1.0, here = x;
    for (int k = 2; k <= n; k++) {
        double next = ((2.0 * k - 1.0) * x * here - (k - 1.0) * before) / k;
        before = here;
        here = next;
    }
    *derivative = n * (before - x * here) / (1.0 - x * x);
    return here;
}

void sl_gauss_legendre(int count, double *nodes, double *weights) {
    for (int i = 0; i < count; i++) {
        /* Newton's start is within O(1/n^4) of the root */
        double x = sl_cos(SL_PI * (i + 0.75) / (count + 0.5)), slope = 1.0;
        for (int step = 0; step < 6; step++) x -= legendre(count, x, &slope) / slope;
        (void)legendre(count, x, &slope);
        nodes[count - 1 - i] = 0.5 + 0.5 * x;
        weights[count - 1 - i] = 1.0 / ((1.0 - x * x) * slope * slope);
    }
}

void sl_gauss_both_ends(int count, double *nodes, double *weights) {
    sl_gauss_legendre(count, nodes, weights);
    for (int i = 0; i < count; i++) {
        double v = nodes[i];
        nodes[i] = v * v * (3.0 - 2.0 * v);
        weights[i] *= 6.0 * v * (1.0 - v);
    }
}

void sl_gauss_upper_end(int count, double *nodes, double *weights) {
    sl_gauss_legendre(count, nodes, weights);
    for (int i = 0; i < count; i++) {
        double rest = 1.0 - nodes[i];
        nodes[i] = 1.0 - rest * rest;
        weights[i] *= 2.0 * rest;
    }
}
