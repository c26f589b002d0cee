/* The splat's fragment program: Algorithm 1 of Gautron et al. 2005, steps 2 to 6, on a tile of the screen.
 * Coverage on the CPU and splats on the hardware share sl_record_weight_at(), so that their sums of weights
 * have the same bits.
 *
 * Sixteen pixels of a row are looked at together, if any of them receives. A splat's rectangle is mostly air:
 * two thirds of its pixels lie too far from the record, on another wall or turned away. So distance comes
 * first, then the weight, and only where that is positive the rest. The groups of a column follow each other,
 * as a column enters and leaves a disc once: branches that the processor can foretell. */
#include "cache/splatting/record_weight.h"

#include "base/lanes.h"

enum { GROUP = SL_SPLAT_GROUP };

/* ---- groups ---- */

/* Weights of the group that starts at pixel i, column x of the tile, 0 outside columns [x0, x1). Returns
 * which are positive. */
static inline uint32_t weigh(const sl_record_terms *k, const sl_tile_planes *t, int i, int x, int x0, int x1,
                             float *restrict w) {
    float distance[GROUP];
    const float *restrict px = t->position_x + i, *restrict py = t->position_y + i,
                          *restrict pz = t->position_z + i;
    const float *restrict nx = t->normal_x + i, *restrict ny = t->normal_y + i,
                          *restrict nz = t->normal_z + i;
    const int from = x0 - x, to = x1 - x;
#pragma omp simd aligned(px, py, pz : 64)
    for (int l = 0; l < GROUP; l++) {
        float squared = sl_record_squared_distance(k, px[l], py[l], pz[l]);
        distance[l] = ((l >= from) & (l < to)) ? squared : NAN; /* neither near nor far */
    }
    if (!sl_bits16_at_most(distance, k->reach_squared)) return 0;
#pragma omp simd aligned(px, py, pz, nx, ny, nz : 64)
    for (int l = 0; l < GROUP; l++) {
        float here = sl_record_weight_at(k, distance[l], px[l], py[l], pz[l], nx[l], ny[l], nz[l]);
        w[l] = distance[l] <= k->reach_squared ? here : 0.0f;
    }
    if (k->has_walls) {
#pragma omp simd aligned(px, py, pz : 64)
        for (int l = 0; l < GROUP; l++) {
            int before = sl_record_before_walls(k, px[l] - k->position.x, py[l] - k->position.y,
                                                pz[l] - k->position.z);
            w[l] = before ? w[l] : 0.0f;
        }
    }
    return sl_bits16_greater(w, 0.0f);
}

/* Step 6: adds (w E', w). */
static inline void blend(const sl_record_terms *k, sl_tile_planes *t, int i, const float *restrict w) {
    const float *restrict px = t->position_x + i, *restrict py = t->position_y + i,
                          *restrict pz = t->position_z + i;
    const float *restrict nx = t->normal_x + i, *restrict ny = t->normal_y + i,
                          *restrict nz = t->normal_z + i;
    float *restrict r = t->r + i, *restrict g = t->g + i, *restrict b = t->b + i;
    float *restrict weight = t->weight + i, *restrict count = t->count + i;
#pragma omp simd aligned(px, py, pz, nx, ny, nz, r, g, b, weight, count : 64)
    for (int l = 0; l < GROUP; l++) {
        const sl_record_offsets o = sl_record_offsets_at(k, px[l], py[l], pz[l], nx[l], ny[l], nz[l]);
        float turn = sl_record_turn(&o), here = w[l];
        float er = sl_record_extrapolate(k, 0, &o, turn), eg = sl_record_extrapolate(k, 1, &o, turn);
        float eb = sl_record_extrapolate(k, 2, &o, turn);
        int contributes = here > 0.0f; /* elsewhere E' may be anything, a NaN too */
        r[l] += contributes ? here * er : 0.0f;
        g[l] += contributes ? here * eg : 0.0f;
        b[l] += contributes ? here * eb : 0.0f;
        weight[l] += here;
        count[l] += contributes ? 1.0f : 0.0f;
    }
}

static inline void add(const float *restrict w, float *restrict weight) {
#pragma omp simd aligned(weight : 64)
    for (int l = 0; l < GROUP; l++) weight[l] += w[l];
}

uint64_t SL_KERNEL(sl_splat_record)(const sl_record *record, const sl_weight_rules *rules, sl_splat_rect rect,
                                 bool light, sl_tile_planes *tile, float *weights) {
    const sl_record_terms k = sl_record_terms_of(record, rules);
    uint64_t blended = 0;
    _Alignas(64) float w[GROUP];
    for (int x = rect.x0 & -GROUP; x < rect.x1; x += GROUP) {
        for (int y = rect.y0; y < rect.y1; y++) {
            const int i = y * SL_SPLAT_TILE + x;
            const uint32_t positive =
                tile->receives[i / GROUP] ? weigh(&k, tile, i, x, rect.x0, rect.x1, w) : 0;
            for (int l = 0; weights && l < GROUP; l++) weights[i + l] = positive ? w[l] : 0.0f;
            if (!positive) continue;
            blended += sl_bits16_count(positive);
            if (light) blend(&k, tile, i, w);
            else add(w, tile->weight + i);
        }
    }
    return blended;
}

/* ---- single pixels, and the way into a tile ---- */

float SL_KERNEL(sl_splat_weight)(const sl_record *record, const sl_weight_rules *rules,
                               const sl_splat_receivers *p, size_t i) {
    const sl_record_terms k = sl_record_terms_of(record, rules);
    const float px = p->position_x[i], py = p->position_y[i], pz = p->position_z[i];
    float squared = sl_record_squared_distance(&k, px, py, pz);
    if (!p->receives[i] || !(squared <= k.reach_squared)) return 0.0f;
    if (k.has_walls && !sl_record_before_walls(&k, px - k.position.x, py - k.position.y, pz - k.position.z))
        return 0.0f;
    return sl_record_weight_at(&k, squared, px, py, pz, p->normal_x[i], p->normal_y[i], p->normal_z[i]);
}

/* Tells of each group of a row's `columns` pixels, from place `to` of the tile on, whether any receives.
 * Returns whether any at all does. */
static inline bool find_groups(const uint32_t *restrict receives, int to, int columns, bool *groups) {
    bool some = false;
    for (int first = to; first < to + columns;) {
        const int next = (first / GROUP + 1) * GROUP, end = next < to + columns ? next : to + columns;
        uint32_t any = 0;
        for (int i = first; i < end; i++) any |= receives[i - to];
        groups[first / GROUP] = any != 0;
        some = some || any;
        first = end;
    }
    return some;
}

void SL_KERNEL(sl_splat_fetch)(const sl_splat_receivers *p, int x, int y, sl_splat_rect region,
                             sl_tile_planes *tile) {
    const int columns = region.x1 - region.x0;
    tile->any_receives = false;
    for (int row = region.y0; row < region.y1; row++) {
        const size_t from = (size_t)row * (size_t)p->width + (size_t)region.x0;
        const int to = (row - y) * SL_SPLAT_TILE + region.x0 - x;
        const uint32_t *restrict receives = p->receives + from;
        const float *restrict px = p->position_x + from, *restrict py = p->position_y + from,
                              *restrict pz = p->position_z + from;
        const float *restrict nx = p->normal_x + from, *restrict ny = p->normal_y + from,
                              *restrict nz = p->normal_z + from;
        tile->any_receives |= find_groups(receives, to, columns, tile->receives);
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
