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
#include "raster/block.h"
#include "raster/internal.h"

static inline bool nearer_than(sl_depth_rule rule, float z, float old) {
    return rule == SL_NEARER_IS_LARGER ? z > old : z < old;
}

/* ---- blocks ---- */

/* What of a triangle its blocks need, fetched once. */
typedef struct {
    sl_block_floats origin, du, dv, least, most;
    sl_block_ints origin_u, origin_v, id;
} block_plane;

static inline block_plane block_plane_of(const sl_batch *b, uint32_t t) {
    return (block_plane){sl_block_float(b->depth_origin[t]), sl_block_float(b->depth_du[t]), sl_block_float(b->depth_dv[t]),
                         sl_block_float(b->depth_min[t]), sl_block_float(b->depth_max[t]), sl_block_int(b->origin_u[t]),
                         sl_block_int(b->origin_v[t]), sl_block_int((int32_t)b->id[t])};
}

/* Depth as sl_depth_at() has it, bit by bit: a row's part, and the distance of the block's columns from the plane's origin. */
static inline sl_block_floats row_depth(const block_plane *p, int32_t y) {
    sl_block_ints v = (y + SL_BLOCK_Y) * SL_SUBPIXEL - p->origin_v;
    return p->origin + p->dv * __builtin_convertvector(v, sl_block_floats);
}

static inline sl_block_floats column_distance(const block_plane *p, int32_t x) {
    sl_block_ints u = (x + SL_BLOCK_X) * SL_SUBPIXEL - p->origin_u;
    return __builtin_convertvector(u, sl_block_floats);
}

static inline sl_block_floats block_depth(const block_plane *p, sl_block_floats row, sl_block_floats column) {
    sl_block_floats z = row + p->du * column;
    z = sl_block_select_floats(z < p->least, z, p->least);
    return sl_block_select_floats(z > p->most, z, p->most);
}

/* Planes in OpenGL's form and steep ones. */
static inline sl_block_floats other_depth(sl_depth_rule rule, const sl_batch *b, uint32_t t, int32_t x, int32_t y) {
    sl_block_floats z;
    for (int l = 0; l < SL_LANES; l++) z[l] = sl_depth_at(rule, b, t, x + (l & 3), y + (l >> 2));
    return z;
}

/* The largest change of an edge function within a block, at one of its corners. */
static inline int32_t reach_of(int32_t a, int32_t b) { return (a > 0 ? 3 * a : 0) + (b > 0 ? 3 * b : 0); }

/* In each row of blocks the columns [low, high] that the triangle can touch: where every edge function reaches 0 somewhere
 * in the block. With e its value in the row's first block, a block to the right adds 4 a, so that is from -e / (4 a) on for
 * a > 0, and up to e / (4 |a|) for a < 0. Sixteen rows, a lane each; a hundredth of a block covers the rounding. Most of the
 * blocks in the box of a triangle that lies across it are left out so. */
enum { EXTENT_ROWS = SL_SPAN / SL_BLOCK };
static inline void find_extents(const int32_t a[3], const int32_t b[3], const int32_t e[3], int last, int32_t *low, int32_t *high) {
    const sl_block_ints row = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    const float slack = 0.01f, end = (float)EXTENT_ROWS + 1.0f;
    sl_block_ints from = sl_block_int(0), to = sl_block_int(last);
    for (int k = 0; k < 3; k++) {
        sl_block_ints at = (e[k] + reach_of(a[k], b[k])) + (SL_BLOCK * b[k]) * row;
        sl_block_floats reach = __builtin_convertvector(at, sl_block_floats) * (1.0f / (float)(SL_BLOCK * (a[k] ? a[k] : 1)));
        if (a[k] > 0) { /* -reach, rounded up */
            reach = -reach;
            reach = sl_block_select_floats(reach < 0.0f, reach, sl_block_float(0.0f));
            reach = sl_block_select_floats(reach > end, reach, sl_block_float(end));
            sl_block_ints first = __builtin_convertvector(reach + (1.0f - slack), sl_block_ints);
            from = sl_block_select(first > from, from, first);
        } else if (a[k] < 0) { /* |reach|, rounded down; -1 and less: none */
            reach = -reach;
            reach = sl_block_select_floats(reach < -1.0f, reach, sl_block_float(-1.0f));
            reach = sl_block_select_floats(reach > end, reach, sl_block_float(end));
            sl_block_ints final = __builtin_convertvector(reach + (1.0f + slack), sl_block_ints) - 1;
            to = sl_block_select(final < to, to, final);
        } else {
            to = sl_block_select(at < 0, to, sl_block_int(-1));
        }
    }
    sl_block_store(low, from);
    sl_block_store(high, to);
}

/* Blocks [x0, x1] x [y0, y1], numbered from the tile's first; e: the edge functions at the first pixel of the first. */
static inline void draw_blocks(const sl_tile *tile, const sl_batch *batch, uint32_t t, sl_depth_rule rule, bool steep,
                               const int32_t a[3], const int32_t b[3], const int32_t e[3], int x0, int y0, int x1, int y1) {
    const sl_block_ints right0 = sl_block_int(SL_BLOCK * a[0]), right1 = sl_block_int(SL_BLOCK * a[1]),
                        right2 = sl_block_int(SL_BLOCK * a[2]);
    sl_block_ints row0 = e[0] + a[0] * SL_BLOCK_X + b[0] * SL_BLOCK_Y, row1 = e[1] + a[1] * SL_BLOCK_X + b[1] * SL_BLOCK_Y;
    sl_block_ints row2 = e[2] + a[2] * SL_BLOCK_X + b[2] * SL_BLOCK_Y;
    const int left = tile->left, low = tile->low, rows = y1 - y0 + 1;
    const size_t stride = (size_t)tile->blocks_x * SL_LANES, first = (size_t)(y0 * tile->blocks_x + x0) * SL_LANES;
    uint32_t *id_row = tile->id + first;
    float *depth_row = tile->depth + first;
    const block_plane plane = block_plane_of(batch, t);
    const bool other = rule == SL_OPENGL_PLANE || steep;
    const sl_block_floats first_column = column_distance(&plane, left + x0 * SL_BLOCK);
    const bool narrow = (x1 - x0) * rows < 20; /* then the extents cost more than they save */
    int32_t from[EXTENT_ROWS], to[EXTENT_ROWS];
    if (!narrow) find_extents(a, b, e, x1 - x0, from, to);
    for (int y = 0; y < rows; y++, id_row += stride, depth_row += stride) {
        const bool whole = narrow || y >= EXTENT_ROWS; /* unaligned, a span's height touches one row more */
        const int begin = whole ? 0 : from[y], end = whole ? x1 - x0 : to[y];
        sl_block_ints e0 = row0 + begin * right0, e1 = row1 + begin * right1, e2 = row2 + begin * right2;
        sl_block_floats row = row_depth(&plane, low + (y0 + y) * SL_BLOCK);
        sl_block_floats column = first_column + (float)(begin * SL_BLOCK * SL_SUBPIXEL); /* whole numbers: exact */
        uint32_t *id = id_row + begin * SL_LANES;
        float *depth = depth_row + begin * SL_LANES;
        for (int x = begin; x <= end; x++, id += SL_LANES, depth += SL_LANES) {
            sl_block_ints outside = e0 | e1 | e2;
            if (sl_block_any_positive(outside)) {
                sl_block_floats z = other ? other_depth(rule, batch, t, left + (x0 + x) * SL_BLOCK, low + (y0 + y) * SL_BLOCK)
                                          : block_depth(&plane, row, column);
                sl_block_write(outside, z, plane.id, rule == SL_NEARER_IS_LARGER, id, depth);
            }
            e0 += right0;
            e1 += right1;
            e2 += right2;
            column += (float)(SL_BLOCK * SL_SUBPIXEL);
        }
        row0 += SL_BLOCK * b[0];
        row1 += SL_BLOCK * b[1];
        row2 += SL_BLOCK * b[2];
    }
}

/* ---- triangles of at most a span ---- */

static inline void draw_small(const sl_tile *tile, const sl_batch *batch, uint32_t t, sl_depth_rule rule, bool steep) {
    const int32_t a[3] = {batch->a[0][t], batch->a[1][t], batch->a[2][t]};
    const int32_t b[3] = {batch->b[0][t], batch->b[1][t], batch->b[2][t]};
    const int32_t e[3] = {batch->e[0][t], batch->e[1][t], batch->e[2][t]};
    draw_blocks(tile, batch, t, rule, steep, a, b, e, (batch->x0[t] - tile->left) / SL_BLOCK, (batch->y0[t] - tile->low) / SL_BLOCK,
                (batch->x1[t] - tile->left) / SL_BLOCK, (batch->y1[t] - tile->low) / SL_BLOCK);
}

/* ---- larger triangles ---- */

bool SL_KERNEL(sl_raster_occluded)(const sl_pass_view *view, const sl_tile *tile, sl_rectangle pixels, float nearest);

static inline void draw_span(const sl_tile *tile, const sl_batch *batch, uint32_t t, const sl_wide_edges *w, sl_depth_rule rule,
                             bool steep, sl_rectangle span) {
    int bx = (span.x0 - tile->left) / SL_BLOCK, by = (span.y0 - tile->low) / SL_BLOCK;
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
    draw_blocks(tile, batch, t, rule, steep, a, b, e, bx, by, (span.x1 - tile->left) / SL_BLOCK,
                (span.y1 - tile->low) / SL_BLOCK);
}

static inline void draw_large(const sl_pass_view *view, const sl_tile *tile, const sl_batch *batch, uint32_t t, sl_depth_rule rule,
                              bool steep) {
    sl_wide_edges w;
    if (!sl_widen_edges(batch, t, &w)) return;
    const int x0 = batch->x0[t], y0 = batch->y0[t], x1 = batch->x1[t], y1 = batch->y1[t];
    const float nearest = rule == SL_NEARER_IS_LARGER ? batch->depth_max[t] : batch->depth_min[t];
    for (int y = tile->low + ((y0 - tile->low) & -SL_SPAN); y <= y1; y += SL_SPAN) {
        for (int x = tile->left + ((x0 - tile->left) & -SL_SPAN); x <= x1; x += SL_SPAN) {
            sl_rectangle span = {x > x0 ? x : x0, y > y0 ? y : y0, x + SL_SPAN - 1 < x1 ? x + SL_SPAN - 1 : x1,
                                 y + SL_SPAN - 1 < y1 ? y + SL_SPAN - 1 : y1};
            if (SL_KERNEL(sl_raster_occluded)(view, tile, span, nearest)) continue;
            draw_span(tile, batch, t, &w, rule, steep, span);
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

/* By themselves, so that the others' loops do not carry their burden. */
__attribute__((noinline)) static void draw_steep(const sl_pass_view *view, const sl_tile *tile, const sl_batch *batch, uint32_t t) {
    if (fits_span(batch, t)) draw_small(tile, batch, t, view->rule, true);
    else draw_large(view, tile, batch, t, view->rule, true);
}

static inline void draw_all(const sl_pass_view *view, const sl_tile *tile, const sl_batch *batch, uint32_t first,
                            sl_depth_rule rule) {
    for (uint32_t t = first; t < batch->count; t++) {
        if (batch->x0[t] > batch->x1[t] || batch->y0[t] > batch->y1[t] || batch->masked[t]) continue;
        if (rule != SL_OPENGL_PLANE && batch->steep[t]) draw_steep(view, tile, batch, t);
        else if (fits_span(batch, t)) draw_small(tile, batch, t, rule, false);
        else draw_large(view, tile, batch, t, rule, false);
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
