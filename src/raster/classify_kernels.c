/* Classification: what becomes of each triangle of a cluster, told from its vertices' clip codes and from the pixel
 * centres next to them, before any edge is set up. Most triangles of a small picture lie between pixel centres; most of
 * the rest cover one or two. The tiny ones among these get their coverage at once, sixteen triangles together. */
#include "raster/internal.h"

static inline int32_t min3(int32_t a, int32_t b, int32_t c) {
    int32_t m = a < b ? a : b;
    return m < c ? m : c;
}
static inline int32_t max3(int32_t a, int32_t b, int32_t c) {
    int32_t m = a > b ? a : b;
    return m > c ? m : c;
}

enum { CULLED, TINY, OTHER, ELSEWHERE, CLIPPED, DROPPED }; /* ELSEWHERE: on the target, but not in this tile */

/* A vertex's cell is (i, j) = (ceil(u / 256), ceil(v / 256)): pixel centres lie at multiples of 256, the least u is
 * inclusive and the largest exclusive by the fill rule, so a triangle's box holds a centre only if its corners'
 * cells differ in i and in j: its pixels are [least i, most i) x [least j, most j). Cells of vertices on the screen fit
 * 16 bits, so one gathered word says it for each corner. A whole group at a time: what lies beyond the cluster's last
 * triangle is not looked at. */
static void classify_inside(const uint16_t *restrict c0, const uint16_t *restrict c1, const uint16_t *restrict c2,
                            const int32_t *restrict cell, const sl_tile *tile, uint8_t *restrict class) {
    const int32_t x0 = tile->x0, y0 = tile->y0, x1 = tile->x1, y1 = tile->y1;
#pragma omp simd
    for (int t = 0; t < SL_LANES; t++) {
        int32_t p = cell[c0[t]], q = cell[c1[t]], r = cell[c2[t]];
        int32_t px = p & 0xffff, qx = q & 0xffff, rx = r & 0xffff, py = p >> 16, qy = q >> 16, ry = r >> 16;
        int32_t low_x = min3(px, qx, rx), high_x = max3(px, qx, rx), low_y = min3(py, qy, ry), high_y = max3(py, qy, ry);
        int32_t here = high_x - low_x <= SL_BLOCK ? TINY : OTHER;
        here = high_y - low_y <= SL_BLOCK ? here : OTHER;
        here = high_y > y0 ? here : ELSEWHERE;
        here = low_y < y1 ? here : ELSEWHERE;
        here = high_x > x0 ? here : ELSEWHERE;
        here = low_x < x1 ? here : ELSEWHERE;
        here = low_y < high_y ? here : CULLED;
        here = low_x < high_x ? here : CULLED;
        class[t] = (uint8_t)here;
    }
}

/* Where some vertex of the cluster is outside a plane or not valid. */
static void classify_crossing(const uint16_t *restrict c0, const uint16_t *restrict c1, const uint16_t *restrict c2,
                              uint32_t count, const int32_t *restrict code, uint8_t *restrict class) {
    for (uint32_t t = 0; t < count; t++) {
        int32_t p = code[c0[t]], q = code[c1[t]], r = code[c2[t]];
        int32_t any = p | q | r, all = p & q & r;
        uint8_t kind = any ? (all ? CULLED : CLIPPED) : class[t];
        class[t] = any & SL_CLIP_INVALID ? DROPPED : kind;
    }
}

static uint32_t count_class(const uint8_t *restrict class, uint32_t count, uint8_t which) {
    uint8_t found = 0; /* at most SL_CLUSTER_TRIANGLES */
    for (uint32_t t = 0; t < count; t++) found = (uint8_t)(found + (class[t] == which));
    return found;
}

static uint32_t list_class(const uint8_t *restrict class, uint32_t count, uint8_t which, uint8_t *restrict list) {
    uint32_t found = 0;
    for (uint32_t t = 0; t < count; t++) {
        list[found] = (uint8_t)t;
        found += class[t] == which;
    }
    return found;
}

void SL_KERNEL(sl_raster_classify)(const sl_raster *r, uint32_t cluster, const sl_pass_view *view, const sl_tile *tile,
                                   const sl_vertex_buffer *b, sl_classes *classes);
void SL_KERNEL(sl_raster_classify)(const sl_raster *r, uint32_t cluster, const sl_pass_view *view, const sl_tile *tile,
                                   const sl_vertex_buffer *b, sl_classes *classes) {
    uint32_t first = r->first_triangle[cluster], count = r->triangles[cluster];
    const uint16_t *corner[3] = {r->corner[0] + first, r->corner[1] + first, r->corner[2] + first};
    uint8_t class[SL_CLUSTER_TRIANGLES];
    for (uint32_t t = 0; t < count; t += SL_LANES) {
        classify_inside(corner[0] + t, corner[1] + t, corner[2] + t, b->cell, tile, class + t);
    }
    int32_t codes = 0;
    for (uint32_t i = 0; i < r->vertices[cluster]; i++) codes |= b->code[i];
    if (codes) classify_crossing(corner[0], corner[1], corner[2], count, b->code, class);
    if (view->skip != SL_NO_INDEX) {
        for (uint32_t t = 0; t < count; t++) class[t] = r->triangle[first + t] == view->skip ? CULLED : class[t];
    }
    if (r->masked) {
        for (uint32_t t = 0; t < count; t++) class[t] = r->triangle_masked[first + t] && class[t] == TINY ? OTHER : class[t];
    }
    classes->culled = count_class(class, count, CULLED);
    classes->tiny = classes->other = classes->clipped = classes->dropped = 0;
    if (classes->culled == count) return;
    classes->tiny = list_class(class, count, TINY, classes->tiny_list);
    classes->other = list_class(class, count, OTHER, classes->other_list);
    if (!codes) return;
    classes->dropped = count_class(class, count, DROPPED);
    classes->clipped = list_class(class, count, CLIPPED, classes->clipped_list);
}

/* ---- tiny triangles ---- */

/* Bits of four pixels of a row. */
static inline int32_t cover_row(int32_t e0, int32_t e1, int32_t e2, int32_t a0, int32_t a1, int32_t a2) {
    int32_t p0 = e0 | e1 | e2, p1 = (e0 + a0) | (e1 + a1) | (e2 + a2);
    int32_t p2 = (e0 + 2 * a0) | (e1 + 2 * a1) | (e2 + 2 * a2), p3 = (e0 + 3 * a0) | (e1 + 3 * a1) | (e2 + 3 * a2);
    return (p0 >= 0 ? 1 : 0) | (p1 >= 0 ? 2 : 0) | (p2 >= 0 ? 4 : 0) | (p3 >= 0 ? 8 : 0);
}

/* The constant of edge function a i + b j + e, seen from a pixel centre: P is a corner on the edge, relative to that
 * centre. See set_up_edges(). */
static inline int32_t edge_constant(int32_t a, int32_t b, int32_t u, int32_t v) {
    int32_t owns = a > 0 ? 1 : 0;
    owns = a == 0 ? (b > 0 ? 1 : 0) : owns;
    return (-(a * u + b * v) - (1 - owns)) >> 8;
}

static void cover_group(const uint16_t *restrict c0, const uint16_t *restrict c1, const uint16_t *restrict c2,
                        const uint8_t *restrict list, const int32_t *restrict snapped_u, const int32_t *restrict snapped_v,
                        const int32_t *restrict cell, int32_t *restrict x, int32_t *restrict y, int32_t *restrict covered) {
#pragma omp simd
    for (int l = 0; l < SL_LANES; l++) {
        int32_t p = c0[list[l]], q = c1[list[l]], r = c2[list[l]];
        int32_t cp = cell[p], cq = cell[q], cr = cell[r];
        int32_t low_x = min3(cp & 0xffff, cq & 0xffff, cr & 0xffff), low_y = min3(cp >> 16, cq >> 16, cr >> 16);
        int32_t u0 = snapped_u[p] - low_x * 256, u1 = snapped_u[q] - low_x * 256, u2 = snapped_u[r] - low_x * 256;
        int32_t v0 = snapped_v[p] - low_y * 256, v1 = snapped_v[q] - low_y * 256, v2 = snapped_v[r] - low_y * 256;
        int32_t area = (u1 - u0) * (v2 - v0) - (u2 - u0) * (v1 - v0);
        int32_t sign = area < 0 ? -1 : 1;
        int32_t a0 = (v1 - v2) * sign, a1 = (v2 - v0) * sign, a2 = (v0 - v1) * sign;
        int32_t b0 = (u2 - u1) * sign, b1 = (u0 - u2) * sign, b2 = (u1 - u0) * sign;
        int32_t e0 = edge_constant(a0, b0, u1, v1), e1 = edge_constant(a1, b1, u2, v2), e2 = edge_constant(a2, b2, u0, v0);
        int32_t bits = cover_row(e0, e1, e2, a0, a1, a2) | cover_row(e0 + b0, e1 + b1, e2 + b2, a0, a1, a2) << 4 |
                       cover_row(e0 + 2 * b0, e1 + 2 * b1, e2 + 2 * b2, a0, a1, a2) << 8 |
                       cover_row(e0 + 3 * b0, e1 + 3 * b1, e2 + 3 * b2, a0, a1, a2) << 12;
        x[l] = low_x;
        y[l] = low_y;
        covered[l] = area ? bits : 0;
    }
}

/* Takes away pixels beyond the tile. */
static int32_t within_tile(const sl_tile *tile, int32_t x, int32_t y, int32_t covered) {
    if (x >= tile->x0 && x + SL_BLOCK <= tile->x1 && y >= tile->y0 && y + SL_BLOCK <= tile->y1) return covered;
    for (int k = 0; k < SL_LANES; k++) {
        int32_t i = x + (k & 3), j = y + (k >> 2);
        if (i < tile->x0 || i >= tile->x1 || j < tile->y0 || j >= tile->y1) covered &= ~(1 << k);
    }
    return covered;
}

void SL_KERNEL(sl_raster_cover_tiny)(const sl_raster *r, uint32_t cluster, const sl_tile *tile, const sl_vertex_buffer *b,
                                     const sl_classes *classes, sl_tiny *tiny);
void SL_KERNEL(sl_raster_cover_tiny)(const sl_raster *r, uint32_t cluster, const sl_tile *tile, const sl_vertex_buffer *b,
                                     const sl_classes *classes, sl_tiny *tiny) {
    uint32_t first = r->first_triangle[cluster], found = 0;
    for (uint32_t n = 0; n < classes->tiny; n += SL_LANES) {
        int32_t x[SL_LANES], y[SL_LANES], covered[SL_LANES];
        uint8_t list[SL_LANES]; /* the last one again where the group is not full */
        uint32_t here = classes->tiny - n < SL_LANES ? classes->tiny - n : SL_LANES;
        for (uint32_t l = 0; l < SL_LANES; l++) list[l] = classes->tiny_list[n + (l < here ? l : here - 1)];
        cover_group(r->corner[0] + first, r->corner[1] + first, r->corner[2] + first, list, b->snapped_u, b->snapped_v, b->cell,
                    x, y, covered);
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
