/* Rasterization: coverage, depth test and write, a block of 4 x 4 pixels at a time.
 *
 * A pixel is covered where all three edge functions are >= 0 (their fill rule is in the constants already).
 * They are exact integers, so shared edges are drawn exactly once. A pixel's depth is evaluated by itself,
 * from the plane's origin, so it does not depend on blocks, lanes or tiles. Nearer wins; equal depths go to
 * the lower triangle index. Indices are compared with their signs: the background's, -1, is the lowest, so
 * nothing is drawn at the cleared depth itself, as with GL_LESS.
 *
 * Three kinds of triangles: tiny ones, whose coverage is known, pixel by pixel; those of at most SL_SPAN
 * pixels each way, block by block; larger ones span by span:
 *
 *      +--------+--------+        each span of 64 x 64 pixels is
 *      |  ___/\ |        |          missed      (an edge function negative all over it)
 *      | /     \|__      |          hidden      (all that is drawn there already is nearer)
 *      |/       |  \__   |          or drawn block by block */
#include "raster/block.h"
#include "raster/tile.h"
#include "raster/triangles.h"

static inline bool nearer_than(sl_depth_rule rule, float z, float old) {
    return rule == SL_NEARER_IS_LARGER ? z > old : z < old;
}

/* ---- blocks ---- */

/* A triangle's plane as its blocks need it, in all lanes. */
typedef struct {
    sl_lanes_floats origin, du, dv, least, most;
    sl_lanes_ints origin_u, origin_v, id;
} block_plane;

static inline block_plane block_plane_of(const sl_triangle_batch *b, uint32_t t) {
    return (block_plane){sl_lanes_float(b->depth_origin[t]), sl_lanes_float(b->depth_du[t]),
                         sl_lanes_float(b->depth_dv[t]),     sl_lanes_float(b->depth_min[t]),
                         sl_lanes_float(b->depth_max[t]),    sl_lanes_int(b->origin_u[t]),
                         sl_lanes_int(b->origin_v[t]),       sl_lanes_int((int32_t)b->id[t])};
}

/* Depth as sl_depth_at() has it, bit by bit: a row's part, and the distance of the columns from the plane's
 * origin. */
static inline sl_lanes_floats row_depth(const block_plane *p, int32_t y) {
    sl_lanes_ints v = (y + sl_part_y()) * SL_SUBPIXEL - p->origin_v;
    return p->origin + p->dv * __builtin_convertvector(v, sl_lanes_floats);
}

static inline sl_lanes_floats column_distance(const block_plane *p, int32_t x) {
    sl_lanes_ints u = (x + sl_part_x()) * SL_SUBPIXEL - p->origin_u;
    return __builtin_convertvector(u, sl_lanes_floats);
}

static inline sl_lanes_floats block_depth(const block_plane *p, sl_lanes_floats row, sl_lanes_floats column) {
    sl_lanes_floats z = row + p->du * column;
    z = sl_lanes_select_floats(z < p->least, z, p->least);
    return sl_lanes_select_floats(z > p->most, z, p->most);
}

/* Planes in OpenGL's form and steep ones: pixel by pixel. */
static inline sl_lanes_floats opengl_depth(const sl_triangle_batch *b, uint32_t t, int32_t x, int32_t y) {
    sl_lanes_floats z;
    for (int l = 0; l < SL_WIDTH; l++) z[l] = sl_depth_at(SL_OPENGL_PLANE, b, t, x + (l & 3), y + (l >> 2));
    return z;
}

static inline sl_lanes_floats steep_depth(const sl_steep_plane *steep, const block_plane *p, int32_t x,
                                         int32_t y) {
    float depth[SL_WIDTH];
    const sl_steep_plane plane = *steep;
#pragma omp simd
    for (int l = 0; l < SL_WIDTH; l++) depth[l] = sl_steep_depth_at(&plane, x + (l & 3), y + (l >> 2));
    sl_lanes_floats z = sl_lanes_load_floats(depth);
    z = sl_lanes_select_floats(z < p->least, z, p->least);
    return sl_lanes_select_floats(z > p->most, z, p->most);
}

/* The largest change of an edge function within a block, at one of its corners. */
static inline int32_t reach_of(int32_t a, int32_t b) { return (a > 0 ? 3 * a : 0) + (b > 0 ? 3 * b : 0); }

/* In each row of blocks the columns [from, to] that the triangle can touch: where every edge function reaches
 * 0 somewhere in the block. With e its value in the row's first block, a block to the right adds 4 a, so that
 * is from -e / (4 a) on for a > 0, and up to e / (4 |a|) for a < 0. Rows are lanes; a hundredth of a block
 * covers the rounding. Most of the blocks in the box of a triangle that lies across it are left out so. */
enum { EXTENT_ROWS = SL_SPAN / SL_BLOCK };
static inline void find_extents(const int32_t a[3], const int32_t b[3], const int32_t e[3], int last,
                                int32_t *from, int32_t *to) {
    const float slack = 0.01f, end = (float)EXTENT_ROWS + 1.0f;
    for (int first = 0; first < EXTENT_ROWS; first += SL_WIDTH) {
        const sl_lanes_ints row = first + sl_lanes_numbers();
        sl_lanes_ints low = sl_lanes_int(0), high = sl_lanes_int(last);
        for (int k = 0; k < 3; k++) {
            sl_lanes_ints at = (e[k] + reach_of(a[k], b[k])) + (SL_BLOCK * b[k]) * row;
            if (a[k] == 0) {
                high = sl_lanes_select(at < 0, high, sl_lanes_int(-1));
                continue;
            }
            sl_lanes_floats zero =
                __builtin_convertvector(at, sl_lanes_floats) * (-1.0f / (float)(SL_BLOCK * a[k]));
            zero = sl_lanes_select_floats(zero < -1.0f, zero, sl_lanes_float(-1.0f));
            zero = sl_lanes_select_floats(zero > end, zero, sl_lanes_float(end));
            if (a[k] > 0) { /* rounded up; conversion cuts towards 0 */
                sl_lanes_ints up = __builtin_convertvector(zero + (2.0f - slack), sl_lanes_ints) - 1;
                low = sl_lanes_select(up > low, low, up);
            } else {
                sl_lanes_ints down = __builtin_convertvector(zero + (1.0f + slack), sl_lanes_ints) - 1;
                high = sl_lanes_select(down < high, high, down);
            }
        }
        sl_lanes_store(from + first, low);
        sl_lanes_store(to + first, high);
    }
}

/* Blocks [x0, x1] x [y0, y1], numbered from the tile's first; e: the edge functions at the first pixel of the
 * first. */
static inline __attribute__((always_inline)) void draw_blocks(
    const sl_tile *tile, const sl_triangle_batch *batch, uint32_t t, sl_depth_rule rule, bool steep,
    const int32_t a[3], const int32_t b[3], const int32_t e[3], int x0, int y0, int x1, int y1) {
    const int left = tile->left + x0 * SL_BLOCK, low = tile->low + y0 * SL_BLOCK, columns = x1 - x0 + 1,
              rows = y1 - y0 + 1;
    const size_t stride = (size_t)tile->blocks_x * SL_LANES,
                 first = (size_t)(y0 * tile->blocks_x + x0) * SL_LANES;
    const block_plane plane = block_plane_of(batch, t);
    const bool other = rule == SL_OPENGL_PLANE || steep;
    const sl_steep_plane steep_plane = steep ? sl_steep_plane_of(batch, t) : (sl_steep_plane){0, 0, 0, 0, 0};
    const sl_lanes_ints right0 = sl_lanes_int(SL_BLOCK * a[0]), right1 = sl_lanes_int(SL_BLOCK * a[1]),
                        right2 = sl_lanes_int(SL_BLOCK * a[2]);
    const sl_lanes_floats first_column = column_distance(&plane, left),
                          right = sl_lanes_float((float)(SL_BLOCK * SL_SUBPIXEL));
    sl_lanes_ints row0 = e[0] + a[0] * sl_part_x() + b[0] * sl_part_y(),
                  row1 = e[1] + a[1] * sl_part_x() + b[1] * sl_part_y();
    sl_lanes_ints row2 = e[2] + a[2] * sl_part_x() + b[2] * sl_part_y();
    int32_t from[EXTENT_ROWS], to[EXTENT_ROWS];
    const bool narrow = columns * rows < 16; /* then the extents cost more than they save */
    if (!narrow) find_extents(a, b, e, columns - 1, from, to);
    for (int y = 0; y < rows; y++) {
        const bool whole = narrow || y >= EXTENT_ROWS; /* unaligned, a span's height touches one row more */
        const int begin = whole ? 0 : from[y], end = whole ? columns - 1 : to[y];
        for (int part = 0; part < SL_PARTS; part++) {
            sl_lanes_ints e0 = row0 + begin * right0, e1 = row1 + begin * right1, e2 = row2 + begin * right2;
            const sl_lanes_floats row = row_depth(&plane, low + y * SL_BLOCK + part * SL_PART_ROWS);
            sl_lanes_floats column = first_column + (float)begin * right; /* whole numbers: exact */
            size_t at = first + (size_t)y * stride + (size_t)begin * SL_LANES + (size_t)part * SL_WIDTH;
            uint32_t *id = tile->id + at;
            float *depth = tile->depth + at;
            for (int x = begin; x <= end; x++, id += SL_LANES, depth += SL_LANES) {
                const sl_lanes_ints outside = e0 | e1 | e2;
                /* Most of these blocks are covered somewhere: to ask costs more than to work for nothing. */
                if (!other || sl_lanes_negative(outside) != SL_LANES_ALL) {
                    const int i = left + x * SL_BLOCK, j = low + y * SL_BLOCK + part * SL_PART_ROWS;
                    sl_lanes_floats z = rule == SL_OPENGL_PLANE ? opengl_depth(batch, t, i, j)
                                        : steep                 ? steep_depth(&steep_plane, &plane, i, j)
                                                                : block_depth(&plane, row, column);
                    sl_part_write(outside, z, plane.id, rule == SL_NEARER_IS_LARGER, id, depth);
                }
                e0 += right0;
                e1 += right1;
                e2 += right2;
                column += right;
            }
            row0 += SL_PART_ROWS * b[0];
            row1 += SL_PART_ROWS * b[1];
            row2 += SL_PART_ROWS * b[2];
        }
    }
}

/* ---- triangles of at most a span ---- */

static inline void draw_small(const sl_tile *tile, const sl_triangle_batch *batch, uint32_t t,
                              sl_depth_rule rule, bool steep) {
    const int32_t a[3] = {batch->a[0][t], batch->a[1][t], batch->a[2][t]};
    const int32_t b[3] = {batch->b[0][t], batch->b[1][t], batch->b[2][t]};
    const int32_t e[3] = {batch->e[0][t], batch->e[1][t], batch->e[2][t]};
    draw_blocks(tile, batch, t, rule, steep, a, b, e, (batch->x0[t] - tile->left) / SL_BLOCK,
                (batch->y0[t] - tile->low) / SL_BLOCK, (batch->x1[t] - tile->left) / SL_BLOCK,
                (batch->y1[t] - tile->low) / SL_BLOCK);
}

/* ---- larger triangles ---- */

bool SL_KERNEL(sl_raster_occluded)(const sl_pass_view *view, const sl_tile *tile, sl_rectangle pixels,
                                   float nearest);

static inline void draw_span(const sl_tile *tile, const sl_triangle_batch *batch, uint32_t t,
                             const sl_wide_edges *w, sl_depth_rule rule, bool steep, sl_rectangle span) {
    int bx = (span.x0 - tile->left) / SL_BLOCK, by = (span.y0 - tile->low) / SL_BLOCK;
    int x = tile->left + bx * SL_BLOCK, y = tile->low + by * SL_BLOCK;
    int32_t a[3], b[3], e[3];
    for (int k = 0; k < 3; k++) {
        int64_t at_first = w->c[k] + w->a[k] * x + w->b[k] * y;
        int64_t least =
            at_first + (w->a[k] < 0 ? w->a[k] * SL_SPAN : 0) + (w->b[k] < 0 ? w->b[k] * SL_SPAN : 0);
        int64_t most =
            at_first + (w->a[k] > 0 ? w->a[k] * SL_SPAN : 0) + (w->b[k] > 0 ? w->b[k] * SL_SPAN : 0);
        if (most < 0) return; /* missed */
        bool crosses = least < 0;
        a[k] = crosses ? (int32_t)w->a[k] : 0;
        b[k] = crosses ? (int32_t)w->b[k] : 0;
        e[k] = crosses ? sl_clamp_edge(at_first) : 0;
    }
    draw_blocks(tile, batch, t, rule, steep, a, b, e, bx, by, (span.x1 - tile->left) / SL_BLOCK,
                (span.y1 - tile->low) / SL_BLOCK);
}

static inline void draw_large(const sl_pass_view *view, const sl_tile *tile, const sl_triangle_batch *batch,
                              uint32_t t, sl_depth_rule rule, bool steep) {
    sl_wide_edges w;
    if (!sl_widen_edges(batch, t, &w)) return;
    const int x0 = batch->x0[t], y0 = batch->y0[t], x1 = batch->x1[t], y1 = batch->y1[t];
    const float nearest = rule == SL_NEARER_IS_LARGER ? batch->depth_max[t] : batch->depth_min[t];
    for (int y = tile->low + ((y0 - tile->low) & -SL_SPAN); y <= y1; y += SL_SPAN) {
        for (int x = tile->left + ((x0 - tile->left) & -SL_SPAN); x <= x1; x += SL_SPAN) {
            sl_rectangle span = {x > x0 ? x : x0, y > y0 ? y : y0,
                                 x + SL_SPAN - 1 < x1 ? x + SL_SPAN - 1 : x1,
                                 y + SL_SPAN - 1 < y1 ? y + SL_SPAN - 1 : y1};
            if (SL_KERNEL(sl_raster_occluded)(view, tile, span, nearest)) continue;
            draw_span(tile, batch, t, &w, rule, steep, span);
        }
    }
}

static inline bool fits_span(const sl_triangle_batch *batch, uint32_t t) {
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
__attribute__((noinline)) static void draw_steep(const sl_pass_view *view, const sl_tile *tile,
                                                 const sl_triangle_batch *batch, uint32_t t) {
    draw_large(view, tile, batch, t, view->rule, true);
}

static inline void draw_all(const sl_pass_view *view, const sl_tile *tile, const sl_triangle_batch *batch,
                            uint32_t first, sl_depth_rule rule) {
    for (uint32_t t = first; t < batch->count; t++) {
        if (batch->x0[t] > batch->x1[t] || batch->y0[t] > batch->y1[t] || batch->masked[t]) continue;
        if (rule != SL_OPENGL_PLANE && batch->steep[t]) draw_steep(view, tile, batch, t);
        else if (fits_span(batch, t)) draw_small(tile, batch, t, rule, false);
        else draw_large(view, tile, batch, t, rule, false);
    }
}

void SL_KERNEL(sl_raster_rasterize)(const sl_pass_view *view, const sl_tile *tile,
                                    const sl_triangle_batch *batch, uint32_t first) {
    switch (view->rule) {
    case SL_NEARER_IS_SMALLER: draw_all(view, tile, batch, first, SL_NEARER_IS_SMALLER); break;
    case SL_NEARER_IS_LARGER: draw_all(view, tile, batch, first, SL_NEARER_IS_LARGER); break;
    case SL_OPENGL_PLANE: draw_all(view, tile, batch, first, SL_OPENGL_PLANE); break;
    }
}

/* ---- tiny triangles ---- */

static inline void draw_pixels(const sl_tile *tile, const sl_triangle_batch *batch, uint32_t t,
                               const sl_tiny *tiny, sl_depth_rule rule) {
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

/* The square lies across up to four blocks. Lane (i, j) of whichever of them holds the square's pixel ((i -
 * right) mod 4, (j - up) mod 4), if any: so depth and coverage, turned round by (right, up), are found once
 * for all four.
 *
 *      +---------+---------+
 *      |   2 3   | 0 1     |     the pixels of one row of the square, right = 2:
 *      |   ......|....     |     lanes 2 and 3 of the left block, lanes 0 and 1 of the right one
 *      +---------+---------+
 *      |<->| right             */
static inline void draw_square(const sl_tile *tile, const sl_triangle_batch *batch, uint32_t t,
                               const sl_tiny *tiny, sl_depth_rule rule) {
    const int32_t x = tiny->x[t], y = tiny->y[t], right = x & (SL_BLOCK - 1), up = y & (SL_BLOCK - 1);
    const uint32_t from_right = 0x1111u * (0xfu << right & 0xfu), from_up = 0xffffu << 4 * up & 0xffffu,
                   all = tiny->covered[t];
    const uint32_t in_left = all & (0x1111u * (0xfu >> right));
    const uint32_t columns = in_left << right | (all & ~in_left) >> (SL_BLOCK - right); /* within each row */
    const uint32_t turned = (columns << 4 * up | columns >> (16 - 4 * up)) & 0xffffu;
    const uint32_t covered[4] = {turned & from_right & from_up, turned & ~from_right & from_up,
                                 turned & from_right & ~from_up, turned & ~from_right & ~from_up};
    const size_t first = sl_tile_index(tile, x & -SL_BLOCK, y & -SL_BLOCK),
                 row = (size_t)tile->blocks_x * SL_LANES;
    const size_t block[4] = {first, first + SL_LANES, first + row, first + row + SL_LANES};
    const block_plane plane = block_plane_of(batch, t);
    for (int part = 0; part < SL_PARTS; part++) {
        const sl_lanes_ints i = (sl_part_x() - right) & (SL_BLOCK - 1),
                            j = (sl_part_y() + (part * SL_PART_ROWS - up)) & (SL_BLOCK - 1);
        const sl_lanes_floats u =
            __builtin_convertvector((x + i) * SL_SUBPIXEL - plane.origin_u, sl_lanes_floats);
        const sl_lanes_floats v =
            __builtin_convertvector((y + j) * SL_SUBPIXEL - plane.origin_v, sl_lanes_floats);
        const sl_lanes_floats z = block_depth(&plane, plane.origin + plane.dv * v, u);
        for (int k = 0; k < 4; k++) {
            const int32_t here = (int32_t)(covered[k] >> (part * SL_WIDTH)) & SL_LANES_ALL;
            const size_t at = block[k] + (size_t)(part * SL_WIDTH);
            if (!here) continue;
            const sl_lanes_ints outside = ((here >> sl_lanes_numbers()) & 1) - 1;
            sl_part_write(outside, z, plane.id, rule == SL_NEARER_IS_LARGER, tile->id + at, tile->depth + at);
        }
    }
}

/* Of few pixels, one by one. */
static inline void draw_tiny(const sl_tile *tile, const sl_triangle_batch *batch, const sl_tiny *tiny,
                             sl_depth_rule rule) {
    for (uint32_t t = 0; t < tiny->count; t++) {
        const uint32_t covered = tiny->covered[t];
        const bool few = sl_bits16_count(covered) < 4;
        if (few || rule == SL_OPENGL_PLANE || batch->steep[t]) draw_pixels(tile, batch, t, tiny, rule);
        else draw_square(tile, batch, t, tiny, rule);
    }
}

void SL_KERNEL(sl_raster_rasterize_tiny)(const sl_pass_view *view, const sl_tile *tile,
                                         const sl_triangle_batch *batch, const sl_tiny *tiny) {
    switch (view->rule) {
    case SL_NEARER_IS_SMALLER: draw_tiny(tile, batch, tiny, SL_NEARER_IS_SMALLER); break;
    case SL_NEARER_IS_LARGER: draw_tiny(tile, batch, tiny, SL_NEARER_IS_LARGER); break;
    case SL_OPENGL_PLANE: draw_tiny(tile, batch, tiny, SL_OPENGL_PLANE); break;
    }
}
