/* Classification: what becomes of each triangle of a cluster, told from its vertices' clip codes and from the
 * pixel centres next to them, before any edge is set up. Most triangles of a small picture lie between pixel
 * centres; most of the rest cover one or two. The tiny ones among these get their coverage at once, sixteen
 * triangles together. */

#include "base/lanes.h"
#include "raster/tile.h"
#include "raster/triangles.h"

/* The lower half, below 2^15. A mask of 16 bits would say the same, but sets compilers to work with short
 * lanes. */
static inline int32_t cell_x(int32_t cell) { return (int32_t)((uint32_t)cell << 16) >> 16; }

/* Sixteen triangles by kind, a bit each. What is on none of the lists lies elsewhere on the target. */
typedef struct {
    uint32_t culled, tiny, other, clipped, dropped;
} group_bits;

/* A vertex's cell is (i, j) = (ceil(u / 256), ceil(v / 256)): pixel centres lie at multiples of 256, the
 * least u is inclusive and the largest exclusive by the fill rule, so a triangle's box holds a centre only if
 * its corners' cells differ in i and in j: its pixels are [least i, most i) x [least j, most j). Cells of
 * vertices on the screen fit 16 bits, so one gathered word says it for each corner. A whole group at a time:
 * what lies beyond the cluster's last triangle is not looked at. */
static group_bits classify_inside(const uint16_t *restrict c0, const uint16_t *restrict c1,
                                  const uint16_t *restrict c2, const int32_t *restrict cell,
                                  const sl_tile *tile) {
    const int32_t x0 = tile->x0, y0 = tile->y0, x1 = tile->x1, y1 = tile->y1;
    int32_t culled[SL_LANES], elsewhere[SL_LANES], large[SL_LANES]; /* negative where it is so */
    int32_t cells[3][SL_LANES];
    for (int t = 0; t < SL_LANES; t++) {
        cells[0][t] = cell[c0[t]];
        cells[1][t] = cell[c1[t]];
        cells[2][t] = cell[c2[t]];
    }
#pragma omp simd
    for (int t = 0; t < SL_LANES; t++) {
        int32_t p = cells[0][t], q = cells[1][t], r = cells[2][t];
        int32_t px = cell_x(p), qx = cell_x(q), rx = cell_x(r), py = p >> 16, qy = q >> 16, ry = r >> 16;
        int32_t low_x = sl_min3(px, qx, rx), high_x = sl_max3(px, qx, rx), low_y = sl_min3(py, qy, ry),
                high_y = sl_max3(py, qy, ry);
        culled[t] = (high_x - low_x - 1) | (high_y - low_y - 1);
        elsewhere[t] = (high_x - 1 - x0) | (high_y - 1 - y0) | (x1 - 1 - low_x) | (y1 - 1 - low_y);
        large[t] = (SL_BLOCK - (high_x - low_x)) | (SL_BLOCK - (high_y - low_y));
    }
    group_bits g = {.culled = sl_bits16_negative(culled)};
    uint32_t here = ~(g.culled | sl_bits16_negative(elsewhere)) & 0xffffu, wide = sl_bits16_negative(large);
    g.tiny = here & ~wide;
    g.other = here & wide;
    return g;
}

/* Where some vertex of the cluster is outside a plane or not valid, that decides. */
static void classify_crossing(const uint16_t *restrict c0, const uint16_t *restrict c1,
                              const uint16_t *restrict c2, const int32_t *restrict code, group_bits *g) {
    uint32_t crossing = 0;
    for (uint32_t t = 0; t < SL_LANES; t++) {
        int32_t p = code[c0[t]], q = code[c1[t]], r = code[c2[t]];
        int32_t any = p | q | r, all = p & q & r;
        if (!any) continue;
        crossing |= 1u << t;
        if (any & SL_CLIP_INVALID) g->dropped |= 1u << t;
        else if (!all) g->clipped |= 1u << t;
    }
    g->tiny &= ~crossing;
    g->other &= ~crossing;
    g->culled = (g->culled & ~crossing) | (crossing & ~(g->dropped | g->clipped));
}

/* A gather's own triangle, and what is left out, counts as culled; a tiny one with a mask has its pixels
 * looked at one by one. */
static void classify_special(const sl_raster *r, const sl_pass_view *view, uint32_t first, group_bits *g) {
    for (uint32_t t = 0; t < SL_LANES && first + t < r->mesh.triangle_count; t++) {
        const uint32_t bit = 1u << t;
        if (r->triangle_masked[first + t] && (g->tiny & bit)) {
            g->tiny &= ~bit;
            g->other |= bit;
        }
        const uint32_t id = r->triangle[first + t];
        if (id == view->skip || (view->left_out && view->left_out[id])) {
            g->tiny &= ~bit;
            g->other &= ~bit;
            g->clipped &= ~bit;
            g->culled |= g->dropped & bit ? 0 : bit;
        }
    }
}

static uint32_t list_bits(uint32_t bits, uint32_t first, uint8_t *restrict list, uint32_t found) {
    for (; bits; bits &= bits - 1) list[found++] = (uint8_t)(first + (uint32_t)__builtin_ctz(bits));
    return found;
}

void SL_KERNEL(sl_raster_classify)(const sl_raster *r, uint32_t cluster, const sl_pass_view *view,
                                   const sl_tile *tile, const sl_vertex_buffer *b, sl_classes *classes) {
    const uint32_t first = r->first_triangle[cluster], count = r->triangles[cluster];
    const bool special =
        r->masked || view->left_out ||
        (view->skip < r->mesh.triangle_count && r->cluster_of_triangle[view->skip] == cluster);
    int32_t codes = 0;
    for (uint32_t i = 0; i < r->vertices[cluster]; i++) codes |= b->code[i];
    classes->culled = classes->tiny = classes->other = classes->clipped = classes->dropped = 0;
    for (uint32_t t = 0; t < count; t += SL_LANES) {
        const uint16_t *c0 = r->corner[0] + first + t, *c1 = r->corner[1] + first + t,
                       *c2 = r->corner[2] + first + t;
        const uint32_t group = count - t < SL_LANES ? (1u << (count - t)) - 1u : 0xffffu;
        group_bits g = classify_inside(c0, c1, c2, b->cell, tile);
        if (codes) classify_crossing(c0, c1, c2, b->code, &g);
        if (special) classify_special(r, view, first + t, &g);
        classes->culled += sl_bits16_count(g.culled & group);
        classes->tiny = list_bits(g.tiny & group, t, classes->tiny_list, classes->tiny);
        classes->other = list_bits(g.other & group, t, classes->other_list, classes->other);
        if (!codes) continue;
        classes->dropped += sl_bits16_count(g.dropped & group);
        classes->clipped = list_bits(g.clipped & group, t, classes->clipped_list, classes->clipped);
    }
}

/* ---- tiny triangles ---- */

/* Bits of four pixels of a row. */
static inline int32_t cover_row(int32_t e0, int32_t e1, int32_t e2, int32_t a0, int32_t a1, int32_t a2) {
    int32_t p0 = e0 | e1 | e2, p1 = (e0 + a0) | (e1 + a1) | (e2 + a2);
    int32_t p2 = (e0 + 2 * a0) | (e1 + 2 * a1) | (e2 + 2 * a2),
            p3 = (e0 + 3 * a0) | (e1 + 3 * a1) | (e2 + 3 * a2);
    return (~sl_if_negative(p0) & 1) | (~sl_if_negative(p1) & 2) | (~sl_if_negative(p2) & 4) |
           (~sl_if_negative(p3) & 8);
}

/* Sixteen triangles' corners; fetched one by one, since compilers, left to do it, fetch each lane by itself
 * as well and take more instructions over it. */
typedef struct {
    int32_t u[3][SL_LANES], v[3][SL_LANES];
} corner_group;

static void cover_group(const corner_group *restrict g, int32_t *restrict x, int32_t *restrict y,
                        int32_t *restrict covered) {
#pragma omp simd
    for (int l = 0; l < SL_LANES; l++) {
        int32_t u0 = g->u[0][l], u1 = g->u[1][l], u2 = g->u[2][l], v0 = g->v[0][l], v1 = g->v[1][l],
                v2 = g->v[2][l];
        int32_t low_x = (sl_min3(u0, u1, u2) + 255) >> 8, low_y = (sl_min3(v0, v1, v2) + 255) >> 8;
        u0 -= low_x * 256, u1 -= low_x * 256, u2 -= low_x * 256;
        v0 -= low_y * 256, v1 -= low_y * 256, v2 -= low_y * 256;
        int32_t area = (u1 - u0) * (v2 - v0) - (u2 - u0) * (v1 - v0);
        int32_t turned = sl_if_negative(area);
        int32_t a0 = sl_turn_if(turned, v1 - v2), a1 = sl_turn_if(turned, v2 - v0),
                a2 = sl_turn_if(turned, v0 - v1);
        int32_t b0 = sl_turn_if(turned, u2 - u1), b1 = sl_turn_if(turned, u0 - u2),
                b2 = sl_turn_if(turned, u1 - u0);
        int32_t e0 = sl_edge_constant(a0, b0, u1, v1), e1 = sl_edge_constant(a1, b1, u2, v2),
                e2 = sl_edge_constant(a2, b2, u0, v0);
        int32_t bits = cover_row(e0, e1, e2, a0, a1, a2) |
                       cover_row(e0 + b0, e1 + b1, e2 + b2, a0, a1, a2) << 4 |
                       cover_row(e0 + 2 * b0, e1 + 2 * b1, e2 + 2 * b2, a0, a1, a2) << 8 |
                       cover_row(e0 + 3 * b0, e1 + 3 * b1, e2 + 3 * b2, a0, a1, a2) << 12;
        x[l] = low_x;
        y[l] = low_y;
        covered[l] = bits & sl_if_nonzero(area);
    }
}

/* Takes away pixels beyond the tile. */
static int32_t within_tile(const sl_tile *tile, int32_t x, int32_t y, int32_t covered) {
    if (x >= tile->x0 && x + SL_BLOCK <= tile->x1 && y >= tile->y0 && y + SL_BLOCK <= tile->y1)
        return covered;
    for (int k = 0; k < SL_LANES; k++) {
        int32_t i = x + (k & 3), j = y + (k >> 2);
        if (i < tile->x0 || i >= tile->x1 || j < tile->y0 || j >= tile->y1) covered &= ~(1 << k);
    }
    return covered;
}

void SL_KERNEL(sl_raster_cover_tiny)(const sl_raster *r, uint32_t cluster, const sl_tile *tile,
                                     const sl_vertex_buffer *b, const sl_classes *classes, sl_tiny *tiny) {
    uint32_t first = r->first_triangle[cluster], found = 0;
    corner_group group = {{{0}}, {{0}}};
    for (uint32_t n = 0; n < classes->tiny; n += SL_LANES) {
        int32_t x[SL_LANES], y[SL_LANES], covered[SL_LANES];
        uint32_t here = classes->tiny - n < SL_LANES ? classes->tiny - n : SL_LANES;
        for (uint32_t l = 0; l < here; l++) {
            for (int k = 0; k < 3; k++) {
                uint16_t vertex = r->corner[k][first + classes->tiny_list[n + l]];
                group.u[k][l] = b->snapped_u[vertex];
                group.v[k][l] = b->snapped_v[vertex];
            }
        }
        cover_group(&group, x, y, covered);
        for (uint32_t l = 0; l < here; l++) {
            int32_t left = covered[l] ? within_tile(tile, x[l], y[l], covered[l]) : 0;
            tiny->triangle[found] = classes->tiny_list[n + l];
            tiny->x[found] = x[l];
            tiny->y[found] = y[l];
            tiny->covered[found] = (uint16_t)left;
            found += left != 0;
        }
    }
    tiny->count = found;
}
