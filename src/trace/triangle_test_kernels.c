#include "trace/triangle_test.h"

/* What the test finds for each ray: the exact-signed edge functions and the corners' distances along axis 3. */
typedef struct edges {
    _Alignas(64) double u[SL_PACKET], v[SL_PACKET], w[SL_PACKET];
    float along[3][SL_PACKET];
} edges;

/* Rays [first, first + count), as if axis k were dominant for all: bits of those that see the origin inside. Element by
 * element; `count` is a constant where this is called, so that the loop becomes whole vectors. */
static inline __attribute__((always_inline)) uint32_t inside(const sl_ray_state *restrict s,
                                                             const sl_triangle_corners *restrict c, unsigned k,
                                                             unsigned first, unsigned count, edges *restrict e) {
    static const uint32_t bit[SL_PACKET] = {1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768};
    const float *p1 = c->p[k == 2 ? 0 : k + 1], *p2 = c->p[k == 0 ? 2 : k - 1], *p3 = c->p[k];
    uint32_t mask = 0;
#pragma omp simd reduction(| : mask)
    for (unsigned i = 0; i < count; i++) {
        unsigned r = first + i;
        float x[3], y[3];
        for (int v = 0; v < 3; v++) {
            float z = p3[v] - s->origin_3[r];
            x[v] = (p1[v] - s->origin_1[r]) + s->shear_1[r] * z;
            y[v] = (p2[v] - s->origin_2[r]) + s->shear_2[r] * z;
            e->along[v][i] = z;
        }
        /* Exact products: 24 + 24 bits fit into 53. So the sign of each difference is exact. */
        double u = (double)x[2] * (double)y[1] - (double)y[2] * (double)x[1];
        double v = (double)x[0] * (double)y[2] - (double)y[0] * (double)x[2];
        double w = (double)x[1] * (double)y[0] - (double)y[1] * (double)x[0];
        e->u[i] = u;
        e->v[i] = v;
        e->w[i] = w;
        double low = u < v ? u : v, high = u > v ? u : v;
        low = w < low ? w : low;
        high = w > high ? w : high;
        /* All of one sign, edges included, but not all 0 (a triangle seen edge-on, which its neighbours cover). */
        uint32_t in = (uint32_t)(((low >= 0.0) | (high <= 0.0)) & ((low < 0.0) | (high > 0.0)));
        mask |= in ? bit[i] : 0;
    }
    return mask;
}

static inline __attribute__((always_inline)) void locate(const sl_ray_state *s, const edges *e, unsigned i, unsigned ray,
                                                         unsigned to, sl_candidates *out) {
    double u = e->u[i], v = e->v[i], w = e->w[i], scale = 1.0 / ((u + v) + w);
    double depth = ((u * (double)e->along[0][i] + v * (double)e->along[1][i]) + w * (double)e->along[2][i]) * scale;
    out->t[to] = (float)(depth * s->per_distance[ray] + s->start[ray]);
    out->w1[to] = (float)(v * scale);
    out->w2[to] = (float)(w * scale);
}

/* Consecutive rays in one go, once for each dominant axis among them; mostly there is one. */
static uint32_t test_many(const sl_ray_state *s, const sl_triangle_corners *c, uint32_t active, unsigned first,
                          unsigned count, sl_candidates *out) {
    uint32_t hits = 0;
    for (unsigned k = 0; k < 3; k++) {
        edges e;
        uint32_t mask = active & (s->with_axis[k] >> first);
        if (!mask) continue;
        mask &= count == 16 ? inside(s, c, k, 0, 16, &e) : count == 8 ? inside(s, c, k, first, 8, &e)
              : count == 4 ? inside(s, c, k, first, 4, &e) : inside(s, c, k, first, count, &e);
        hits |= mask;
        for (; mask; mask &= mask - 1) {
            unsigned i = (unsigned)__builtin_ctz(mask);
            locate(s, &e, i, first + i, i, out);
        }
    }
    return hits;
}

static uint32_t test_singly(const sl_ray_state *s, const sl_triangle_corners *c, uint32_t active, const unsigned *id,
                            sl_candidates *out) {
    uint32_t hits = 0;
    for (; active; active &= active - 1) {
        unsigned i = (unsigned)__builtin_ctz(active), ray = id[i];
        unsigned k = s->with_axis[0] >> ray & 1 ? 0 : s->with_axis[1] >> ray & 1 ? 1 : 2;
        edges e;
        if (!inside(s, c, k, ray, 1, &e)) continue;
        locate(s, &e, 0, ray, i, out);
        hits |= 1u << i;
    }
    return hits;
}

/* Embree hands over 1, 4, 8 or 16 rays, mostly consecutive ones; then one call tests them all. Few rays, or rays that were
 * sorted, are tested one by one: the same arithmetic, so the same bits. */
uint32_t SL_KERNEL(sl_triangle_test)(const sl_ray_state *state, const sl_triangle_corners *corners, const int *valid,
                                     const unsigned *id, unsigned n, sl_candidates *candidates) {
    uint32_t active = 0, astray = 0;
    for (unsigned i = 0; i < n; i++) {
        active |= valid[i] ? 1u << i : 0;
        astray |= id[i] - id[0] - i;
    }
    bool many = (active & (active - 1) & ((active & (active - 1)) - 1)) != 0; /* more than two bits */
    if (many && !astray && id[0] + n <= SL_PACKET) return test_many(state, corners, active, id[0], n, candidates);
    return test_singly(state, corners, active, id, candidates);
}
