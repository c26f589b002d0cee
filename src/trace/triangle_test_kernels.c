#include "base/lanes.h"
#include "trace/triangle_test.h"

/* The triangle's corners in the rays' sheared frames: across the ray, and the distance along axis 3. */
typedef struct sheared {
    _Alignas(64) float x[3][SL_PACKET], y[3][SL_PACKET], z[3][SL_PACKET];
} sheared;

/* Do the exact edge functions of entry i have one sign? Products of floats are exact in double (24 + 24 bits
 * fit into 53), so the sign of each difference is. Edges included, but not all 0: a triangle seen edge-on,
 * which its neighbours cover. */
static bool is_inside_exactly(const sheared *e, unsigned i) {
    double x[3], y[3];
    for (int v = 0; v < 3; v++) {
        x[v] = (double)e->x[v][i];
        y[v] = (double)e->y[v][i];
    }
    double u = x[2] * y[1] - y[2] * x[1], v = x[0] * y[2] - y[0] * x[2], w = x[1] * y[0] - y[1] * x[0];
    double low = u < v ? u : v, high = u > v ? u : v;
    low = w < low ? w : low;
    high = w > high ? w : high;
    return ((low >= 0.0) | (high <= 0.0)) & ((low < 0.0) | (high > 0.0));
}

static inline uint32_t exactly_inside(const sheared *e, uint32_t doubtful) {
    uint32_t in = 0;
    for (; doubtful; doubtful &= doubtful - 1) {
        unsigned i = (unsigned)__builtin_ctz(doubtful);
        in |= is_inside_exactly(e, i) ? 1u << i : 0;
    }
    return in;
}

/* From the edge functions' signs, a bit for each ray: the rays inside for sure, and those that only the exact
 * test can tell. */
static inline uint32_t judge(const sheared *e, const uint32_t positive[3], const uint32_t negative[3],
                             uint32_t active) {
    uint32_t outside = (positive[0] | positive[1] | positive[2]) & (negative[0] | negative[1] | negative[2]);
    uint32_t inside = (positive[0] & positive[1] & positive[2]) | (negative[0] & negative[1] & negative[2]);
    uint32_t doubtful = active & ~(outside | inside);
    return (inside & active) | (doubtful ? exactly_inside(e, doubtful) : 0);
}

/* The rays `first` to first + SL_WIDTH whose dominant axis is k: bits (of those in `active`) that meet the
 * triangle.
 *
 * An edge function is the difference of two products. Rounding is monotonic: where the products still differ
 * after rounding to float, they differ in the same sense before it. So floats decide, and doubles only where
 * the rounded products are equal. */
static inline uint32_t test_lanes(const sl_ray_state *s, const sl_triangle_corners *c, unsigned k,
                                  unsigned first, uint32_t active, sheared *e) {
    const float *p1 = c->p[k == 2 ? 0 : k + 1], *p2 = c->p[k == 0 ? 2 : k - 1], *p3 = c->p[k];
    sl_lanes_floats o1 = sl_lanes_load_floats(&s->origin_1[first]);
    sl_lanes_floats o2 = sl_lanes_load_floats(&s->origin_2[first]);
    sl_lanes_floats o3 = sl_lanes_load_floats(&s->origin_3[first]);
    sl_lanes_floats s1 = sl_lanes_load_floats(&s->shear_1[first]);
    sl_lanes_floats s2 = sl_lanes_load_floats(&s->shear_2[first]);
    sl_lanes_floats x[3], y[3], z[3];
    for (int v = 0; v < 3; v++) {
        z[v] = p3[v] - o3;
        x[v] = (p1[v] - o1) + s1 * z[v];
        y[v] = (p2[v] - o2) + s2 * z[v];
    }
    uint32_t positive[3], negative[3];
    for (int v = 0; v < 3; v++) {
        int from = v == 0 ? 2 : v - 1, to = v == 2 ? 0 : v + 1;
        sl_lanes_floats a = x[from] * y[to], b = y[from] * x[to];
        positive[v] = sl_lanes_greater(a, b);
        negative[v] = sl_lanes_greater(b, a);
    }
    uint32_t outside = (positive[0] | positive[1] | positive[2]) & (negative[0] | negative[1] | negative[2]);
    if (!(active & ~outside)) return 0;
    for (int v = 0; v < 3; v++) {
        sl_lanes_store(e->x[v], (sl_lanes_ints)x[v]);
        sl_lanes_store(e->y[v], (sl_lanes_ints)y[v]);
        sl_lanes_store(e->z[v], (sl_lanes_ints)z[v]);
    }
    return judge(e, positive, negative, active);
}

/* Distance and weights of entry i, which is that of ray `ray`, into entry `to`. */
static inline __attribute__((always_inline)) void locate(const sl_ray_state *restrict s,
                                                         const sheared *restrict e, unsigned i, unsigned ray,
                                                         unsigned to, sl_candidates *restrict out) {
    double x0 = (double)e->x[0][i], x1 = (double)e->x[1][i], x2 = (double)e->x[2][i];
    double y0 = (double)e->y[0][i], y1 = (double)e->y[1][i], y2 = (double)e->y[2][i];
    double u = x2 * y1 - y2 * x1, v = x0 * y2 - y0 * x2, w = x1 * y0 - y1 * x0, scale = 1.0 / ((u + v) + w);
    double depth = ((u * (double)e->z[0][i] + v * (double)e->z[1][i]) + w * (double)e->z[2][i]) * scale;
    out->t[to] = (float)(depth * s->per_distance[ray] + s->start[ray]);
    out->w1[to] = (float)(v * scale);
    out->w2[to] = (float)(w * scale);
}

enum { LOCATED = SL_WIDTH < 8 ? SL_WIDTH : 8, FEW = 2 };

/* Entries `hits`, of consecutive rays; by whole vectors where that pays. */
static inline void locate_all(const sl_ray_state *s, const sheared *e, uint32_t hits, unsigned ray,
                              unsigned to, sl_candidates *out) {
    for (unsigned first = 0; first < SL_WIDTH; first += LOCATED) {
        uint32_t some = hits >> first & ((1u << LOCATED) - 1);
        if (__builtin_popcount(some) > FEW) {
#pragma omp simd
            for (unsigned i = 0; i < LOCATED; i++)
                locate(s, e, first + i, ray + first + i, to + first + i, out);
            continue;
        }
        for (; some; some &= some - 1) {
            unsigned i = first + (unsigned)__builtin_ctz(some);
            locate(s, e, i, ray + i, to + i, out);
        }
    }
}

/* Rays [first, first + SL_WIDTH), once for each dominant axis among them; mostly there is one. */
static inline uint32_t test_consecutive(const sl_ray_state *s, const sl_triangle_corners *c, uint32_t active,
                                        unsigned first, unsigned to, sl_candidates *out) {
    uint32_t all = 0;
    for (unsigned k = 0; k < 3; k++) {
        sheared e;
        uint32_t with_axis = active & (s->with_axis[k] >> first);
        if (!with_axis) continue;
        uint32_t hits = test_lanes(s, c, k, first, with_axis, &e);
        if (!hits) continue;
        if (__builtin_expect(with_axis == active, 1)) {
            locate_all(s, &e, hits, first, to, out);
            return hits;
        }
        all |= hits;
        for (; hits; hits &= hits - 1) {
            unsigned i = (unsigned)__builtin_ctz(hits);
            locate(s, &e, i, first + i, to + i, out);
        }
    }
    return all;
}

static bool test_one(const sl_ray_state *s, const sl_triangle_corners *c, unsigned ray, unsigned to,
                     sl_candidates *out) {
    unsigned k = s->with_axis[0] >> ray & 1 ? 0 : s->with_axis[1] >> ray & 1 ? 1 : 2;
    const float *p1 = c->p[k == 2 ? 0 : k + 1], *p2 = c->p[k == 0 ? 2 : k - 1], *p3 = c->p[k];
    sheared e;
    uint32_t positive[3], negative[3];
    for (int v = 0; v < 3; v++) {
        float z = p3[v] - s->origin_3[ray];
        e.x[v][0] = (p1[v] - s->origin_1[ray]) + s->shear_1[ray] * z;
        e.y[v][0] = (p2[v] - s->origin_2[ray]) + s->shear_2[ray] * z;
        e.z[v][0] = z;
    }
    for (int v = 0; v < 3; v++) {
        int from = v == 0 ? 2 : v - 1, to_corner = v == 2 ? 0 : v + 1;
        float a = e.x[from][0] * e.y[to_corner][0], b = e.y[from][0] * e.x[to_corner][0];
        positive[v] = a > b;
        negative[v] = a < b;
    }
    if (!judge(&e, positive, negative, 1u)) return false;
    locate(s, &e, 0, ray, to, out);
    return true;
}

/* The lanes whose integers differ, as bits. */
static inline uint32_t differ(const void *a, const void *b) {
    return sl_lanes_negative(sl_lanes_load_ints(a) == sl_lanes_load_ints(b)) ^ SL_LANES_ALL;
}

/* Embree hands over 1, 4, 8 or 16 rays, mostly consecutive ones; then whole registers test them. Others are
 * tested one by one: the same arithmetic, so the same bits. */
uint32_t SL_KERNEL(sl_triangle_test)(const sl_ray_state *state, const sl_triangle_corners *corners,
                                     const int *valid, const unsigned *id, unsigned n,
                                     sl_candidates *candidates) {
    static const int none[SL_WIDTH];
    static const unsigned in_order[SL_PACKET] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    uint32_t hits = 0;
    if (n % SL_WIDTH == 0) {
        for (unsigned first = 0; first < n; first += SL_WIDTH) {
            uint32_t active = differ(&valid[first], none);
            if (!active) continue;
            unsigned ray = id[first];
            if (ray + SL_WIDTH <= SL_PACKET && !differ(&id[first], &in_order[ray])) {
                hits |= test_consecutive(state, corners, active, ray, first, candidates) << first;
                continue;
            }
            for (; active; active &= active - 1) {
                unsigned i = first + (unsigned)__builtin_ctz(active);
                hits |= test_one(state, corners, id[i], i, candidates) ? 1u << i : 0;
            }
        }
        return hits;
    }
    for (unsigned i = 0; i < n; i++) {
        if (valid[i] && test_one(state, corners, id[i], i, candidates)) hits |= 1u << i;
    }
    return hits;
}

void SL_KERNEL(sl_ray_frames)(sl_ray_state *restrict s, const sl_ray16 *restrict rays) {
    _Alignas(64) uint32_t axis[SL_PACKET];
    _Alignas(64) float dominant[SL_PACKET];
#pragma omp simd
    for (unsigned i = 0; i < SL_PACKET; i++) {
        float dx = rays->direction_x[i], dy = rays->direction_y[i], dz = rays->direction_z[i];
        float ox = rays->origin_x[i], oy = rays->origin_y[i], oz = rays->origin_z[i];
        float ax = fabsf(dx), ay = fabsf(dy), az = fabsf(dz);
        bool along_z = (az >= ax) & (az >= ay), along_x = (ax > az) & (ax >= ay);
        float d3 = along_z ? dz : along_x ? dx : dy;
        s->origin_1[i] = along_z ? ox : along_x ? oy : oz;
        s->origin_2[i] = along_z ? oy : along_x ? oz : ox;
        s->origin_3[i] = along_z ? oz : along_x ? ox : oy;
        s->shear_1[i] = -((along_z ? dx : along_x ? dy : dz) / d3);
        s->shear_2[i] = -((along_z ? dy : along_x ? dz : dx) / d3);
        dominant[i] = d3;
        axis[i] = along_z ? 2 : along_x ? 0 : 1;
    }
#pragma omp simd
    for (unsigned i = 0; i < SL_PACKET; i++) s->per_distance[i] = 1.0 / (double)dominant[i];
    s->with_axis[0] = s->with_axis[1] = s->with_axis[2] = 0;
    for (unsigned i = 0; i < SL_PACKET; i++) s->with_axis[axis[i]] |= 1u << i;
}
