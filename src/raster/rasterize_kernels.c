/* The one hot loop: coverage, depth test and write, sixteen pixels of a row at a time.
 *
 * A pixel is covered where all three edge functions are >= 0 (their fill rule is in the constants already). They are
 * exact integers, so shared edges are drawn exactly once. A pixel's depth is evaluated by itself, from the plane's
 * origin, so it does not depend on blocks, lanes or regions. Nearer wins; equal depths go to the lower triangle
 * index. Indices are compared with their signs: the background's, -1, is the lowest, so nothing is drawn at the
 * cleared depth itself, as with GL_LESS. */
#include "raster/internal.h"

typedef struct {
    int32_t e[3], a[3]; /* at the group's first pixel, and per pixel */
    float row_depth, du, first_u, least, most;
    uint32_t id;
} group;

/* lanes is SL_LANES, a constant, but at the end of rows whose width is no multiple of it. */
static inline void draw_lanes(const group *g, int lanes, bool larger_is_nearer, uint32_t *restrict id,
                              float *restrict depth) {
    const int32_t e0 = g->e[0], e1 = g->e[1], e2 = g->e[2], a0 = g->a[0], a1 = g->a[1], a2 = g->a[2];
    const float row_depth = g->row_depth, du = g->du, first_u = g->first_u, least = g->least, most = g->most;
    const int32_t me = (int32_t)g->id;
#pragma omp simd
    for (int l = 0; l < lanes; l++) {
        int32_t outside = (e0 + a0 * l) | (e1 + a1 * l) | (e2 + a2 * l);
        float z = row_depth + du * (first_u + (float)(l * SL_SUBPIXEL));
        z = z < least ? least : z;
        z = z > most ? most : z;
        float old = depth[l];
        int32_t old_id = (int32_t)id[l];
        bool nearer = larger_is_nearer ? z > old : z < old;
        bool wins = (outside >= 0) & (nearer | ((z == old) & (me < old_id)));
        depth[l] = wins ? z : old;
        id[l] = (uint32_t)(wins ? me : old_id);
    }
}

static inline int32_t clamp_edge(int64_t e) {
    const int64_t limit = (int64_t)1 << 30; /* within a block an edge function changes by less than 2^30 */
    return (int32_t)(e < -limit ? -limit : e > limit ? limit : e);
}

/* Pixels [x0, x1] x [y0, y1] of one block. */
static inline void draw_block(const sl_pass_view *view, const sl_batch *b, uint32_t t, int x0, int y0, int x1, int y1,
                              bool larger_is_nearer, uint32_t *restrict id, float *restrict depth) {
    const int32_t a0 = b->a[0][t], a1 = b->a[1][t], a2 = b->a[2][t], b0 = b->b[0][t], b1 = b->b[1][t], b2 = b->b[2][t];
    const int first = x0 & ~(SL_LANES - 1); /* groups start at multiples of the lanes */
    int32_t row0 = clamp_edge(b->c[0][t] + (int64_t)a0 * first + (int64_t)b0 * y0);
    int32_t row1 = clamp_edge(b->c[1][t] + (int64_t)a1 * first + (int64_t)b1 * y0);
    int32_t row2 = clamp_edge(b->c[2][t] + (int64_t)a2 * first + (int64_t)b2 * y0);
    /* An edge function's largest value in a group is at its first or last pixel. */
    const int32_t reach0 = a0 > 0 ? a0 * (SL_LANES - 1) : 0, reach1 = a1 > 0 ? a1 * (SL_LANES - 1) : 0,
                  reach2 = a2 > 0 ? a2 * (SL_LANES - 1) : 0;
    group g = {.a = {a0, a1, a2}, .du = b->depth_du[t], .least = b->depth_min[t], .most = b->depth_max[t], .id = b->id[t]};
    const float dv = b->depth_dv[t], depth_origin = b->depth_origin[t];
    for (int y = y0; y <= y1; y++, row0 += b0, row1 += b1, row2 += b2) {
        g.row_depth = depth_origin + dv * (float)(y * SL_SUBPIXEL - b->origin_v[t]);
        uint32_t *restrict row_id = id + (size_t)y * (size_t)view->width;
        float *restrict row_z = depth + (size_t)y * (size_t)view->width;
        for (int x = first; x <= x1; x += SL_LANES) {
            g.e[0] = row0 + a0 * (x - first);
            g.e[1] = row1 + a1 * (x - first);
            g.e[2] = row2 + a2 * (x - first);
            if (((g.e[0] + reach0) | (g.e[1] + reach1) | (g.e[2] + reach2)) < 0) continue;
            g.first_u = (float)(x * SL_SUBPIXEL - b->origin_u[t]);
            if (x + SL_LANES <= view->width) {
                draw_lanes(&g, SL_LANES, larger_is_nearer, row_id + x, row_z + x);
            } else {
                draw_lanes(&g, view->width - x, larger_is_nearer, row_id + x, row_z + x);
            }
        }
    }
}

/* All of one edge function negative over the pixels [x0, x1] x [y0, y1]. */
static inline bool misses(const sl_batch *b, uint32_t t, int x0, int y0, int x1, int y1) {
    for (int k = 0; k < 3; k++) {
        int64_t a = b->a[k][t], d = b->b[k][t];
        if (b->c[k][t] + a * (a > 0 ? x1 : x0) + d * (d > 0 ? y1 : y0) < 0) return true;
    }
    return false;
}

static inline void draw_triangle(const sl_pass_view *view, const sl_batch *b, uint32_t t, bool larger_is_nearer,
                                 uint32_t *restrict id, float *restrict depth) {
    const int x0 = b->x0[t], y0 = b->y0[t], x1 = b->x1[t], y1 = b->y1[t];
    const int mask = ~(SL_BLOCK - 1);
    if ((x0 & mask) == (x1 & mask) && (y0 & mask) == (y1 & mask)) {
        draw_block(view, b, t, x0, y0, x1, y1, larger_is_nearer, id, depth);
        return;
    }
    for (int by = y0 & mask; by <= y1; by += SL_BLOCK) {
        for (int bx = x0 & mask; bx <= x1; bx += SL_BLOCK) {
            int left = bx > x0 ? bx : x0, right = bx + SL_BLOCK - 1 < x1 ? bx + SL_BLOCK - 1 : x1;
            int low = by > y0 ? by : y0, high = by + SL_BLOCK - 1 < y1 ? by + SL_BLOCK - 1 : y1;
            if (misses(b, t, left, low, right, high)) continue;
            draw_block(view, b, t, left, low, right, high, larger_is_nearer, id, depth);
        }
    }
}

static void rasterize_inverse_w(const sl_pass_view *view, const sl_batch *batch, uint32_t *restrict id,
                                float *restrict depth) {
    for (uint32_t t = 0; t < batch->count; t++) {
        if (batch->x0[t] <= batch->x1[t] && !batch->masked[t]) draw_triangle(view, batch, t, true, id, depth);
    }
}

static void rasterize_window(const sl_pass_view *view, const sl_batch *batch, uint32_t *restrict id,
                             float *restrict depth) {
    for (uint32_t t = 0; t < batch->count; t++) {
        if (batch->x0[t] <= batch->x1[t] && !batch->masked[t]) draw_triangle(view, batch, t, false, id, depth);
    }
}

void SL_KERNEL(sl_raster_rasterize)(const sl_pass_view *view, const sl_batch *batch, uint32_t *id, float *depth);
void SL_KERNEL(sl_raster_rasterize)(const sl_pass_view *view, const sl_batch *batch, uint32_t *id, float *depth) {
    if (view->inverse_w) rasterize_inverse_w(view, batch, id, depth);
    else rasterize_window(view, batch, id, depth);
}
