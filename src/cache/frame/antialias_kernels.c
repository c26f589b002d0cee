#include "cache/frame/antialias_kernels.h"

typedef struct nearest {
    double inverse[SL_EDGE_SAMPLES]; /* distance */
    double cone[SL_EDGE_SAMPLES];    /* its number: lanes are of one width */
} nearest;

static void meet(const sl_edge_cone *c, double number, const double *restrict right,
                 const double *restrict up, nearest *n) {
    const sl_vec3d a = c->side[0], b = c->side[1], d = c->side[2];
#pragma omp simd
    for (int k = 0; k < SL_EDGE_SAMPLES; k++) {
        const double u = right[k], v = up[k], p = a.x * u + a.y * v + a.z, q = b.x * u + b.y * v + b.z,
                     r = d.x * u + d.y * v + d.z, inverse = (p + q + r) * c->inverse_volume;
        const bool above = (p >= 0.0) & (q >= 0.0) & (r >= 0.0), below = (p <= 0.0) & (q <= 0.0) & (r <= 0.0),
                   nearer = (above | below) & (inverse > 0.0) & (inverse > n->inverse[k]);
        n->inverse[k] = nearer ? inverse : n->inverse[k];
        n->cone[k] = nearer ? number : n->cone[k];
    }
}

static void be_behind(double number, nearest *n) {
    for (int k = 0; k < SL_EDGE_SAMPLES; k++) {
        if (!(0.0 > n->inverse[k])) continue;
        n->inverse[k] = 0.0;
        n->cone[k] = number;
    }
}

void SL_KERNEL(sl_edge_see)(size_t count, const sl_edge_cone *const *cones, const double u[SL_EDGE_SAMPLES],
                            const double v[SL_EDGE_SAMPLES], uint8_t seen[SL_EDGE_SAMPLES]) {
    nearest n;
    for (int k = 0; k < SL_EDGE_SAMPLES; k++) n.inverse[k] = -1.0, n.cone[k] = 0.0;
    for (size_t i = 0; i < count; i++) {
        const sl_edge_cone *c = cones[i];
        if (c->flat || (c->masked && i > 0)) continue;
        if (c->everywhere) be_behind((double)i, &n);
        else meet(c, (double)i, u, v, &n);
    }
    for (int k = 0; k < SL_EDGE_SAMPLES; k++) seen[k] = (uint8_t)n.cone[k];
}
