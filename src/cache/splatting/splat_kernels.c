/* The splat's fragment program: Algorithm 1 of Gautron et al. 2005, steps 2 to 6, on a tile of the screen. Coverage on the CPU and
 * splats on the hardware share weight_at(), so that their sums of weights have the same bits.
 *
 * Sixteen pixels of a row are looked at together. A splat's rectangle is mostly air: two thirds of its pixels lie too far from the
 * record, on another wall or turned away. So distance comes first, then the weight, and only where that is positive the rest. The
 * groups of a column follow each other, as a column enters and leaves a disc once: branches that the processor can foretell. */
#include "cache/splatting/record.h"

#include <math.h>

#include "base/bits16.h"

enum { GROUP = 16 };

static const float weight_epsilon = 1e-3f; /* w is singular at the record itself */

/* What a record's pixels have in common. */
typedef struct {
    sl_vec3 position, normal;
    float inverse_radius, accuracy, offset;
    float reach_squared;    /* (a R)^2 */
    float front, behind;    /* bounds of 2 s, see weight_at() */
    float e[3], most[3];    /* E and E (1 + a) */
    sl_vec3 rotational[3];  /* grad_r E x n_k */
    sl_vec3 translational[3];
    float rotational_length[3];
} splat;

static inline splat prepare(const sl_record *k, const sl_weight_rules *rules) {
    float reach = rules->accuracy * k->radius;
    splat s = {.position = k->position, .normal = k->normal, .inverse_radius = 1.0f / k->radius, .accuracy = rules->accuracy,
               .offset = rules->offset, .reach_squared = reach * reach,
               .front = -2.0f * (0.01f * reach + rules->front_tolerance), .behind = reach + 2.0f * rules->front_tolerance};
    const float e[3] = {k->irradiance.r, k->irradiance.g, k->irradiance.b};
    for (int c = 0; c < 3; c++) {
        s.e[c] = e[c];
        s.most[c] = e[c] * (1.0f + rules->accuracy);
        s.rotational[c] = sl_cross(k->rotational[c], k->normal);
        s.translational[c] = k->translational[c];
        s.rotational_length[c] = k->rotational_length[c];
    }
    return s;
}

/* Between a pixel and a record. */
typedef struct {
    float x, y, z;    /* p - p_k */
    float mx, my, mz; /* n - n_k */
} offsets;

static inline float squared_distance(const splat *s, float px, float py, float pz) {
    float x = px - s->position.x, y = py - s->position.y, z = pz - s->position.z;
    return x * x + y * y + z * z;
}

static inline offsets offsets_at(const splat *s, float px, float py, float pz, float nx, float ny, float nz) {
    return (offsets){px - s->position.x, py - s->position.y, pz - s->position.z,
                     nx - s->normal.x,   ny - s->normal.y,   nz - s->normal.z};
}

/* |n - n_k| */
static inline float turn_of(const offsets *o) { return sqrtf(o->mx * o->mx + o->my * o->my + o->mz * o->mz); }

/* The caller compares the squared distance with (a R)^2. */
static inline float weight_at(const splat *k, float distance_squared, float px, float py, float pz, float nx, float ny, float nz) {
    const offsets o = offsets_at(k, px, py, pz, nx, ny, nz);
    /* (2): D = |p - p_k| / R + sqrt(1 - n.n_k), the root written as |n - n_k| / sqrt 2, which rounding cannot make
     * negative and which keeps its digits for small angles. */
    float d = sqrtf(distance_squared) * k->inverse_radius + turn_of(&o) * 0.70710678f;
    /* s = (p - p_k) . (n + n_k) / 2. A record in front of p sees what p does not (s < -a R / 100); one far behind p belongs to
     * another step of the stairs (s > a R / 2). s vanishes on spheres, convex and concave, so curvature is not punished. */
    float s2 = o.x * (nx + k->normal.x) + o.y * (ny + k->normal.y) + o.z * (nz + k->normal.z);
    int accepted = (d <= k->accuracy) & (s2 >= k->front) & (s2 <= k->behind);
    float w = 1.0f / (d > weight_epsilon ? d : weight_epsilon) - k->offset;
    return accepted ? (w > 0.0f ? w : 0.0f) : 0.0f;
}

/* (8), with absolute gradients: E' = E + (n_k x n) . grad_r E + (p - p_k) . grad_t E, kept within what the record can vouch
 * for: not negative, not above E (1 + a) + |grad_r E| |n - n_k|. The triple product is n . (grad_r E x n_k), the same with
 * n - n_k for n, which keeps its digits for small angles and is there already. */
static inline float extrapolate(const splat *k, int c, const offsets *o, float turn) {
    const sl_vec3 q = k->rotational[c], t = k->translational[c];
    float value = k->e[c] + (o->mx * q.x + o->my * q.y + o->mz * q.z) + (o->x * t.x + o->y * t.y + o->z * t.z);
    float most = k->most[c] + k->rotational_length[c] * turn;
    value = value < most ? value : most;
    return value > 0.0f ? value : 0.0f;
}

/* ---- groups ---- */

/* Weights of the group that starts at pixel i, column x of the tile, 0 outside columns [x0, x1). Returns which are positive. */
static inline uint32_t weigh(const splat *k, const sl_tile_planes *t, int i, int x, int x0, int x1, float *restrict w) {
    float distance[GROUP];
    const float *restrict px = t->position_x + i, *restrict py = t->position_y + i, *restrict pz = t->position_z + i;
    const float *restrict nx = t->normal_x + i, *restrict ny = t->normal_y + i, *restrict nz = t->normal_z + i;
    const int from = x0 - x, to = x1 - x;
#pragma omp simd aligned(px, py, pz : 64)
    for (int l = 0; l < GROUP; l++) {
        float squared = squared_distance(k, px[l], py[l], pz[l]);
        distance[l] = ((l >= from) & (l < to)) ? squared : NAN; /* neither near nor far */
    }
    if (!sl_bits16_at_most(distance, k->reach_squared)) return 0;
#pragma omp simd aligned(px, py, pz, nx, ny, nz : 64)
    for (int l = 0; l < GROUP; l++) {
        float here = weight_at(k, distance[l], px[l], py[l], pz[l], nx[l], ny[l], nz[l]);
        w[l] = distance[l] <= k->reach_squared ? here : 0.0f;
    }
    return sl_bits16_greater(w, 0.0f);
}

/* Step 6: adds (w E', w). */
static inline void blend(const splat *k, sl_tile_planes *t, int i, const float *restrict w) {
    const float *restrict px = t->position_x + i, *restrict py = t->position_y + i, *restrict pz = t->position_z + i;
    const float *restrict nx = t->normal_x + i, *restrict ny = t->normal_y + i, *restrict nz = t->normal_z + i;
    float *restrict r = t->r + i, *restrict g = t->g + i, *restrict b = t->b + i;
    float *restrict weight = t->weight + i, *restrict count = t->count + i;
#pragma omp simd aligned(px, py, pz, nx, ny, nz, r, g, b, weight, count : 64)
    for (int l = 0; l < GROUP; l++) {
        const offsets o = offsets_at(k, px[l], py[l], pz[l], nx[l], ny[l], nz[l]);
        float turn = turn_of(&o), here = w[l];
        float er = extrapolate(k, 0, &o, turn), eg = extrapolate(k, 1, &o, turn), eb = extrapolate(k, 2, &o, turn);
        int contributes = here > 0.0f; /* elsewhere E' may be anything, a NaN too */
        r[l] += contributes ? here * er : 0.0f;
        g[l] += contributes ? here * eg : 0.0f;
        b[l] += contributes ? here * eb : 0.0f;
        weight[l] += here;
        count[l] += contributes ? 1.0f : 0.0f;
    }
}

static uint64_t SL_KERNEL(splat)(const sl_record *record, const sl_weight_rules *rules, sl_splat_rect rect, sl_tile_planes *tile) {
    const splat k = prepare(record, rules);
    uint64_t blended = 0;
    _Alignas(64) float w[GROUP];
    for (int x = rect.x0 & -GROUP; x < rect.x1; x += GROUP) {
        for (int y = rect.y0; y < rect.y1; y++) {
            const int i = y * SL_SPLAT_TILE + x;
            uint32_t positive = weigh(&k, tile, i, x, rect.x0, rect.x1, w);
            if (!positive) continue;
            blend(&k, tile, i, w);
            blended += sl_bits16_count(positive);
        }
    }
    return blended;
}

static uint64_t SL_KERNEL(cover)(const sl_record *record, const sl_weight_rules *rules, sl_splat_rect rect, sl_tile_planes *tile) {
    const splat k = prepare(record, rules);
    uint64_t blended = 0;
    _Alignas(64) float w[GROUP];
    for (int x = rect.x0 & -GROUP; x < rect.x1; x += GROUP) {
        for (int y = rect.y0; y < rect.y1; y++) {
            const int i = y * SL_SPLAT_TILE + x;
            uint32_t positive = weigh(&k, tile, i, x, rect.x0, rect.x1, w);
            if (!positive) continue;
            float *restrict weight = tile->weight + i;
#pragma omp simd aligned(weight : 64)
            for (int l = 0; l < GROUP; l++) weight[l] += w[l];
            blended += sl_bits16_count(positive);
        }
    }
    return blended;
}

/* ---- single pixels, and the way into a tile ---- */

static float SL_KERNEL(weight)(const sl_record *record, const sl_weight_rules *rules, const sl_receivers *p, size_t i) {
    const splat k = prepare(record, rules);
    const float px = p->position_x[i], py = p->position_y[i], pz = p->position_z[i];
    float squared = squared_distance(&k, px, py, pz);
    if (!p->receives[i] || !(squared <= k.reach_squared)) return 0.0f;
    return weight_at(&k, squared, px, py, pz, p->normal_x[i], p->normal_y[i], p->normal_z[i]);
}

static void SL_KERNEL(fetch)(const sl_receivers *p, int x, int y, sl_splat_rect region, sl_tile_planes *tile) {
    const int columns = region.x1 - region.x0;
    for (int row = region.y0; row < region.y1; row++) {
        const size_t from = (size_t)row * (size_t)p->width + (size_t)region.x0;
        const int to = (row - y) * SL_SPLAT_TILE + region.x0 - x;
        const uint32_t *restrict receives = p->receives + from;
        const float *restrict px = p->position_x + from, *restrict py = p->position_y + from, *restrict pz = p->position_z + from;
        const float *restrict nx = p->normal_x + from, *restrict ny = p->normal_y + from, *restrict nz = p->normal_z + from;
#pragma omp simd
        for (int l = 0; l < columns; l++) {
            tile->position_x[to + l] = receives[l] ? px[l] : NAN;
            tile->position_y[to + l] = py[l];
            tile->position_z[to + l] = pz[l];
            tile->normal_x[to + l] = nx[l];
            tile->normal_y[to + l] = ny[l];
            tile->normal_z[to + l] = nz[l];
        }
    }
}

extern const sl_splat_kernels SL_KERNEL(sl_splat_kernel_table);
const sl_splat_kernels SL_KERNEL(sl_splat_kernel_table) = {SL_KERNEL(fetch), SL_KERNEL(splat), SL_KERNEL(cover),
                                                           SL_KERNEL(weight)};
