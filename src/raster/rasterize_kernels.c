/* Rasterization: coverage, depth test and write, a block of 4 x 4 pixels at a time.
 *
 * A pixel is covered where all three edge functions are >= 0 (their fill rule is in the constants already). They are
 * exact integers, so shared edges are drawn exactly once. A pixel's depth is evaluated by itself, from the plane's
 * origin, so it does not depend on blocks, lanes or tiles. Nearer wins; equal depths go to the lower triangle
 * index. Indices are compared with their signs: the background's, -1, is the lowest, so nothing is drawn at the
 * cleared depth itself, as with GL_LESS.
 *
 * Three kinds of triangles: tiny ones, whose coverage is known, pixel by pixel; those of at most SL_SPAN pixels each way,
 * block by block; larger ones span by span:
 *
 *      +--------+--------+        each span of 64 x 64 pixels is
 *      |  ___/\ |        |          missed      (an edge function negative all over it)
 *      | /     \|__      |          hidden      (all that is drawn there already is nearer)
 *      |/       |  \__   |          or drawn block by block */
#include "raster/internal.h"

static inline bool nearer_than(sl_depth_rule rule, float z, float old) {
    return rule == SL_NEARER_IS_LARGER ? z > old : z < old;
}

/* ---- a block ---- */

/* e: the edge functions at the block's first pixel. step: their change to each of the block's pixels. */
static inline void draw_block(const sl_batch *batch, uint32_t t, sl_depth_rule rule, int32_t e0, int32_t e1, int32_t e2,
                              const int32_t *restrict step0, const int32_t *restrict step1, const int32_t *restrict step2,
                              int32_t x, int32_t y, uint32_t *restrict id, float *restrict depth) {
    const int32_t me = (int32_t)batch->id[t];
#pragma omp simd
    for (int l = 0; l < SL_LANES; l++) {
        int32_t outside = (e0 + step0[l]) | (e1 + step1[l]) | (e2 + step2[l]);
        float z = sl_depth_at(rule, batch, t, x + (l & 3), y + (l >> 2));
        float old = depth[l];
        int32_t old_id = (int32_t)id[l];
        bool wins = (outside >= 0) & (nearer_than(rule, z, old) | ((z == old) & (me < old_id)));
        depth[l] = wins ? z : old;
        id[l] = (uint32_t)(wins ? me : old_id);
    }
}

/* The changes of edge function k over a block. */
static inline void find_steps(int32_t a, int32_t b, int32_t *restrict step) {
#pragma omp simd
    for (int l = 0; l < SL_LANES; l++) step[l] = a * (l & 3) + b * (l >> 2);
}

/* The largest of these changes, at one of the corners. */
static inline int32_t reach_of(int32_t a, int32_t b) { return (a > 0 ? 3 * a : 0) + (b > 0 ? 3 * b : 0); }

/* Blocks [x0, x1] x [y0, y1], numbered from the tile's first; e at the first pixel of the first of them. */
static inline void draw_blocks(const sl_tile *tile, const sl_batch *batch, uint32_t t, sl_depth_rule rule, const int32_t a[3],
                               const int32_t b[3], const int32_t e[3], int x0, int y0, int x1, int y1) {
    int32_t step0[SL_LANES], step1[SL_LANES], step2[SL_LANES];
    find_steps(a[0], b[0], step0);
    find_steps(a[1], b[1], step1);
    find_steps(a[2], b[2], step2);
    const int32_t reach0 = reach_of(a[0], b[0]), reach1 = reach_of(a[1], b[1]), reach2 = reach_of(a[2], b[2]);
    int32_t row0 = e[0], row1 = e[1], row2 = e[2];
    for (int y = y0; y <= y1; y++, row0 += 4 * b[0], row1 += 4 * b[1], row2 += 4 * b[2]) {
        int32_t e0 = row0, e1 = row1, e2 = row2;
        size_t at = (size_t)(y * tile->blocks_x + x0) * SL_LANES;
        for (int x = x0; x <= x1; x++, e0 += 4 * a[0], e1 += 4 * a[1], e2 += 4 * a[2], at += SL_LANES) {
            if (((e0 + reach0) | (e1 + reach1) | (e2 + reach2)) < 0) continue;
            draw_block(batch, t, rule, e0, e1, e2, step0, step1, step2, tile->left + x * SL_BLOCK, tile->low + y * SL_BLOCK,
                       tile->id + at, tile->depth + at);
        }
    }
}

/* ---- triangles of at most a span ---- */

static inline void draw_small(const sl_tile *tile, const sl_batch *batch, uint32_t t, sl_depth_rule rule) {
    const int32_t a[3] = {batch->a[0][t], batch->a[1][t], batch->a[2][t]};
    const int32_t b[3] = {batch->b[0][t], batch->b[1][t], batch->b[2][t]};
    const int32_t e[3] = {batch->e[0][t], batch->e[1][t], batch->e[2][t]};
    draw_blocks(tile, batch, t, rule, a, b, e, (batch->x0[t] - tile->left) / SL_BLOCK, (batch->y0[t] - tile->low) / SL_BLOCK,
                (batch->x1[t] - tile->left) / SL_BLOCK, (batch->y1[t] - tile->low) / SL_BLOCK);
}

/* ---- larger triangles ---- */

bool SL_KERNEL(sl_raster_occluded)(const sl_pass_view *view, const sl_tile *tile, int x0, int y0, int x1, int y1,
                                   float nearest);
void SL_KERNEL(sl_raster_make_stale)(const sl_tile *tile, int x0, int y0, int x1, int y1);

/* Pixels [x0, x1] x [y0, y1] of one span. */
static inline void draw_span(const sl_tile *tile, const sl_batch *batch, uint32_t t, const sl_wide_edges *w, sl_depth_rule rule,
                             int x0, int y0, int x1, int y1) {
    int bx = (x0 - tile->left) / SL_BLOCK, by = (y0 - tile->low) / SL_BLOCK;
    int x = tile->left + bx * SL_BLOCK, y = tile->low + by * SL_BLOCK;
    int32_t a[3], b[3], e[3];
    for (int k = 0; k < 3; k++) {
        int64_t at_first = w->c[k] + w->a[k] * x + w->b[k] * y;
        int64_t least = at_first + (w->a[k] < 0 ? w->a[k] * SL_SPAN : 0) + (w->b[k] < 0 ? w->b[k] * SL_SPAN : 0);
        int64_t most = at_first + (w->a[k] > 0 ? w->a[k] * SL_SPAN : 0) + (w->b[k] > 0 ? w->b[k] * SL_SPAN : 0);
        if (most < 0) return; /* missed */
        bool crosses = least < 0;
        a[k] = crosses ? (int32_t)w->a[k] : 0;
        b[k] = crosses ? (int32_t)w->b[k] : 0;
        e[k] = crosses ? sl_clamp_edge(at_first) : 0;
    }
    draw_blocks(tile, batch, t, rule, a, b, e, bx, by, (x1 - tile->left) / SL_BLOCK, (y1 - tile->low) / SL_BLOCK);
}

static void draw_large(const sl_pass_view *view, const sl_tile *tile, const sl_batch *batch, uint32_t t, sl_depth_rule rule) {
    sl_wide_edges w;
    if (!sl_widen_edges(batch, t, &w)) return;
    const int x0 = batch->x0[t], y0 = batch->y0[t], x1 = batch->x1[t], y1 = batch->y1[t];
    const float nearest = rule == SL_NEARER_IS_LARGER ? batch->depth_max[t] : batch->depth_min[t];
    for (int y = tile->low + ((y0 - tile->low) & -SL_SPAN); y <= y1; y += SL_SPAN) {
        for (int x = tile->left + ((x0 - tile->left) & -SL_SPAN); x <= x1; x += SL_SPAN) {
            int left = x > x0 ? x : x0, right = x + SL_SPAN - 1 < x1 ? x + SL_SPAN - 1 : x1;
            int low = y > y0 ? y : y0, high = y + SL_SPAN - 1 < y1 ? y + SL_SPAN - 1 : y1;
            if (SL_KERNEL(sl_raster_occluded)(view, tile, left, low, right, high, nearest)) continue;
            draw_span(tile, batch, t, &w, rule, left, low, right, high);
            SL_KERNEL(sl_raster_make_stale)(tile, left, low, right, high);
        }
    }
}

static inline bool fits_span(const sl_batch *batch, uint32_t t) {
    int32_t low_u = batch->snapped_u[0][t], high_u = low_u, low_v = batch->snapped_v[0][t], high_v = low_v;
    for (int k = 1; k < 3; k++) {
        int32_t u = batch->snapped_u[k][t], v = batch->snapped_v[k][t];
        low_u = u < low_u ? u : low_u;
        high_u = u > high_u ? u : high_u;
        low_v = v < low_v ? v : low_v;
        high_v = v > high_v ? v : high_v;
    }
    return high_u - low_u <= SL_SPAN * SL_SUBPIXEL && high_v - low_v <= SL_SPAN * SL_SUBPIXEL;
}

static inline void draw_all(const sl_pass_view *view, const sl_tile *tile, const sl_batch *batch, uint32_t first,
                            sl_depth_rule rule) {
    for (uint32_t t = first; t < batch->count; t++) {
        if (batch->x0[t] > batch->x1[t] || batch->y0[t] > batch->y1[t] || batch->masked[t]) continue;
        if (fits_span(batch, t)) draw_small(tile, batch, t, rule);
        else draw_large(view, tile, batch, t, rule);
    }
}

void SL_KERNEL(sl_raster_rasterize)(const sl_pass_view *view, const sl_tile *tile, const sl_batch *batch, uint32_t first);
void SL_KERNEL(sl_raster_rasterize)(const sl_pass_view *view, const sl_tile *tile, const sl_batch *batch, uint32_t first) {
    switch (view->rule) {
    case SL_NEARER_IS_SMALLER: draw_all(view, tile, batch, first, SL_NEARER_IS_SMALLER); break;
    case SL_NEARER_IS_LARGER: draw_all(view, tile, batch, first, SL_NEARER_IS_LARGER); break;
    case SL_OPENGL_PLANE: draw_all(view, tile, batch, first, SL_OPENGL_PLANE); break;
    }
}

/* ---- tiny triangles ---- */

static inline void draw_tiny(const sl_tile *tile, const sl_batch *batch, const sl_tiny *tiny, sl_depth_rule rule) {
    for (uint32_t t = 0; t < tiny->count; t++) {
        const int32_t me = (int32_t)batch->id[t];
        for (uint32_t left = tiny->covered[t]; left; left &= left - 1) {
            int k = __builtin_ctz(left), x = tiny->x[t] + (k & 3), y = tiny->y[t] + (k >> 2);
            size_t i = sl_tile_index(tile, x, y);
            float z = sl_depth_at(rule, batch, t, x, y), old = tile->depth[i];
            if (!nearer_than(rule, z, old) && !(z == old && me < (int32_t)tile->id[i])) continue;
            tile->depth[i] = z;
            tile->id[i] = (uint32_t)me;
        }
    }
}

void SL_KERNEL(sl_raster_rasterize_tiny)(const sl_pass_view *view, const sl_tile *tile, const sl_batch *batch,
                                         const sl_tiny *tiny);
void SL_KERNEL(sl_raster_rasterize_tiny)(const sl_pass_view *view, const sl_tile *tile, const sl_batch *batch,
                                         const sl_tiny *tiny) {
    switch (view->rule) {
    case SL_NEARER_IS_SMALLER: draw_tiny(tile, batch, tiny, SL_NEARER_IS_SMALLER); break;
    case SL_NEARER_IS_LARGER: draw_tiny(tile, batch, tiny, SL_NEARER_IS_LARGER); break;
    case SL_OPENGL_PLANE: draw_tiny(tile, batch, tiny, SL_OPENGL_PLANE); break;
    }
}
