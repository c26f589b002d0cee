#include "trace/triangle_test.h"

/* One triangle against `count` consecutive rays. Everything is element by element, so a ray's bits do not depend on its
 * company; `count` is a constant at each call below, so that the loops become whole vectors. */
static inline __attribute__((always_inline)) uint32_t test(const sl_ray_state *restrict s,
                                                           const sl_triangle_corners *restrict c, unsigned first,
                                                           unsigned count, sl_candidates *restrict out) {
    float along[3][SL_PACKET];
    double edge[3][SL_PACKET];
    int32_t inside[SL_PACKET];
    int32_t any = 0;
#pragma omp simd reduction(| : any)
    for (unsigned i = 0; i < count; i++) {
        unsigned k = first + i;
        float px[3], py[3];
        for (int v = 0; v < 3; v++) {
            float x = c->x[v] - s->origin_x[k], y = c->y[v] - s->origin_y[k], z = c->z[v] - s->origin_z[k];
            px[v] = (s->row_xx[k] * x + s->row_xy[k] * y) + s->row_xz[k] * z;
            py[v] = (s->row_yx[k] * x + s->row_yy[k] * y) + s->row_yz[k] * z;
            along[v][i] = (s->along_x[k] * x + s->along_y[k] * y) + s->along_z[k] * z;
        }
        /* Exact products: 24 + 24 bits fit into 53. So the sign of each difference is exact. */
        double u = (double)px[2] * (double)py[1] - (double)py[2] * (double)px[1];
        double v = (double)px[0] * (double)py[2] - (double)py[0] * (double)px[2];
        double w = (double)px[1] * (double)py[0] - (double)py[1] * (double)px[0];
        edge[0][i] = u;
        edge[1][i] = v;
        edge[2][i] = w;
        double low = u < v ? u : v, high = u > v ? u : v;
        low = w < low ? w : low;
        high = w > high ? w : high;
        /* All of one sign, edges included, but not all 0 (a triangle seen edge-on, which its neighbours cover). */
        int32_t in = (int32_t)(((low >= 0.0) | (high <= 0.0)) & ((low < 0.0) | (high > 0.0)));
        inside[i] = in;
        any |= in;
    }
    if (!any) return 0;
#pragma omp simd
    for (unsigned i = 0; i < count; i++) {
        unsigned k = first + i;
        double u = edge[0][i], v = edge[1][i], w = edge[2][i];
        double scale = 1.0 / ((u + v) + w);
        double depth = ((u * (double)along[0][i] + v * (double)along[1][i]) + w * (double)along[2][i]) * scale;
        out->t[i] = (float)(depth * s->per_distance[k] + s->start[k]);
        out->w1[i] = (float)(v * scale);
        out->w2[i] = (float)(w * scale);
    }
    uint32_t mask = 0;
    for (unsigned i = 0; i < count; i++) mask |= (uint32_t)inside[i] << i;
    return mask;
}

uint32_t SL_KERNEL(sl_triangle_test)(const sl_ray_state *state, const sl_triangle_corners *corners, unsigned first,
                                     unsigned count, sl_candidates *candidates) {
    switch (count) {
    case 16: return test(state, corners, 0, 16, candidates);
    case 8: return test(state, corners, first, 8, candidates);
    case 4: return test(state, corners, first, 4, candidates);
    case 1: return test(state, corners, first, 1, candidates);
    default: return test(state, corners, first, count, candidates);
    }
}
