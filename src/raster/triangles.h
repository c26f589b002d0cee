/* Triangles on their way from a cluster to the pixels: transformed vertices, classes, what is left after
 * clipping, edge functions and depth planes. */
#pragma once

#include "raster/clusters.h"
#include "raster/view.h"

enum {
    SL_CLIP_TRIANGLES = 7, /* a triangle cut by six planes has at most nine corners, so a fan of seven */
    /* set up together: a cluster and room for clipping; no power of two, for the cache's sets */
    SL_BATCH = 240
};

/* One cluster's vertices after the transform. */
typedef struct sl_vertex_buffer {
    float x[SL_CLUSTER_VERTICES]; /* clip space */
    float y[SL_CLUSTER_VERTICES], z[SL_CLUSTER_VERTICES], w[SL_CLUSTER_VERTICES];
    float window_x[SL_CLUSTER_VERTICES], window_y[SL_CLUSTER_VERTICES], depth[SL_CLUSTER_VERTICES];
    float oow[SL_CLUSTER_VERTICES];
    /* 1/256 pixel from the first pixel's centre */
    int32_t snapped_u[SL_CLUSTER_VERTICES], snapped_v[SL_CLUSTER_VERTICES];
    int32_t cell[SL_CLUSTER_VERTICES]; /* the first pixel centre at or beyond it: j << 16 | i */
    int32_t code[SL_CLUSTER_VERTICES];
} sl_vertex_buffer;

/* A cluster's triangles by their fate. Lists hold cluster-local numbers. */
typedef struct sl_classes {
    uint32_t tiny, other, clipped, culled, dropped;
    /* their pixels lie in a square of SL_BLOCK, anywhere; no mask */
    uint8_t tiny_list[SL_CLUSTER_TRIANGLES + SL_LANES];
    uint8_t other_list[SL_CLUSTER_TRIANGLES + SL_LANES];
    uint8_t clipped_list[SL_CLUSTER_TRIANGLES + SL_LANES];
} sl_classes;

/* The tiny triangles of a cluster that do cover pixels. */
typedef struct sl_tiny {
    uint32_t count;
    uint8_t triangle[SL_CLUSTER_TRIANGLES];
    int32_t x[SL_CLUSTER_TRIANGLES], y[SL_CLUSTER_TRIANGLES]; /* first pixel of the square */
    uint16_t covered[SL_CLUSTER_TRIANGLES];                   /* bit 4 j + i: pixel (x + i, y + j) */
} sl_tiny;

/* Triangles in window coordinates; pixel centres lie at multiples of 256 in (u, v). */
typedef struct sl_triangle_batch {
    uint32_t count;
    uint32_t id[SL_BATCH];
    uint8_t masked[SL_BATCH];
    /* in */
    int32_t snapped_u[3][SL_BATCH], snapped_v[3][SL_BATCH];
    float x[3][SL_BATCH], y[3][SL_BATCH], depth[3][SL_BATCH]; /* window, not snapped */
    /* out: pixels that may be covered, inclusive; empty: x0 > x1 */
    int32_t x0[SL_BATCH], y0[SL_BATCH], x1[SL_BATCH], y1[SL_BATCH];
    /* out, where at most SL_SPAN pixels wide and high: edge functions a i + b j + e, (i, j) from the first
     * pixel of the first block; inside where all three are >= 0 */
    int32_t a[3][SL_BATCH], b[3][SL_BATCH], e[3][SL_BATCH];
    /* out: depth = (origin + dv (256 j - origin_v)) + du (256 i - origin_u), clamped to [min, max]; by
     * SL_OPENGL_PLANE fma(dv, j, fma(du, i, origin)); where steep, in double from the corners */
    int32_t steep[SL_BATCH];
    float depth_du[SL_BATCH], depth_dv[SL_BATCH], depth_origin[SL_BATCH], depth_min[SL_BATCH],
        depth_max[SL_BATCH];
    int32_t origin_u[SL_BATCH], origin_v[SL_BATCH];
} sl_triangle_batch;

/* Thin slivers may have so steep a plane that its terms, each many times the depth itself, would leave little
 * of it in float. They are few, and cover few pixels: their plane is kept in double, told from the first
 * corner. */
typedef struct sl_steep_plane {
    double u, v, depth, du, dv;
} sl_steep_plane;

static inline sl_steep_plane sl_steep_plane_of(const sl_triangle_batch *b, uint32_t t) {
    double u0 = (double)((b->x[0][t] - 0.5f) * 256.0f), v0 = (double)((b->y[0][t] - 0.5f) * 256.0f),
           z0 = (double)b->depth[0][t];
    double du1 = (double)((b->x[1][t] - 0.5f) * 256.0f) - u0,
           dv1 = (double)((b->y[1][t] - 0.5f) * 256.0f) - v0;
    double du2 = (double)((b->x[2][t] - 0.5f) * 256.0f) - u0,
           dv2 = (double)((b->y[2][t] - 0.5f) * 256.0f) - v0;
    double dz1 = (double)b->depth[1][t] - z0, dz2 = (double)b->depth[2][t] - z0,
           over = 1.0 / (du1 * dv2 - dv1 * du2);
    return (sl_steep_plane){u0, v0, z0, (dz1 * dv2 - dz2 * dv1) * over, (dz2 * du1 - dz1 * du2) * over};
}

static inline float sl_steep_depth_at(const sl_steep_plane *p, int32_t x, int32_t y) {
    return (float)(p->depth +
                   (p->du * ((double)(x * SL_SUBPIXEL) - p->u) + p->dv * ((double)(y * SL_SUBPIXEL) - p->v)));
}

/* Depth of triangle t at pixel (x, y), by itself, so that it does not depend on blocks, lanes or tiles. All
 * that is turned to float is whole and below 2^23, exact. */
static inline float sl_depth_at(sl_depth_rule rule, const sl_triangle_batch *b, uint32_t t, int32_t x,
                                int32_t y) {
    float z = b->depth_origin[t];
    if (rule == SL_OPENGL_PLANE) {
        z = fmaf(b->depth_dv[t], (float)y, fmaf(b->depth_du[t], (float)x, z));
    } else if (b->steep[t]) {
        sl_steep_plane plane = sl_steep_plane_of(b, t);
        z = sl_steep_depth_at(&plane, x, y);
    } else {
        z = (z + b->depth_dv[t] * (float)(y * SL_SUBPIXEL - b->origin_v[t])) +
            b->depth_du[t] * (float)(x * SL_SUBPIXEL - b->origin_u[t]);
    }
    z = z < b->depth_min[t] ? b->depth_min[t] : z;
    return z > b->depth_max[t] ? b->depth_max[t] : z;
}

/* Edge functions of a triangle of any size: a i + b j + c at pixel (i, j) of the target, inside where all
 * three are >= 0. */
typedef struct sl_wide_edges {
    int64_t a[3], b[3], c[3];
} sl_wide_edges;

/* Edge k runs from corner k+1 to corner k+2; E(u, v) = a (u - u_P) + b (v - v_P) is positive inside once the
 * signs are turned by the area's. At pixel centres E = 256 (a i + b j) + c, so E >= 0 is a i + b j + floor(c
 * / 256) >= 0. Edges that do not own their points (all but left edges and lowest horizontal ones) ask for E
 * >= 1. Returns false if there is no area. */
static inline bool sl_widen_edges(const sl_triangle_batch *batch, uint32_t t, sl_wide_edges *w) {
    int64_t u[3], v[3];
    for (int k = 0; k < 3; k++) {
        u[k] = batch->snapped_u[k][t];
        v[k] = batch->snapped_v[k][t];
    }
    int64_t area = (u[1] - u[0]) * (v[2] - v[0]) - (u[2] - u[0]) * (v[1] - v[0]);
    int64_t sign = area < 0 ? -1 : 1;
    for (int k = 0; k < 3; k++) {
        int p = (k + 1) % 3, q = (k + 2) % 3;
        int64_t a = (v[p] - v[q]) * sign, b = (u[q] - u[p]) * sign;
        bool owns = a > 0 || (a == 0 && b > 0);
        w->a[k] = a;
        w->b[k] = b;
        w->c[k] = (-(a * u[p] + b * v[p]) - !owns) >> 8;
    }
    return area != 0;
}

static inline int32_t sl_min3(int32_t a, int32_t b, int32_t c) { return sl_smaller(sl_smaller(a, b), c); }
static inline int32_t sl_max3(int32_t a, int32_t b, int32_t c) { return sl_larger(sl_larger(a, b), c); }

/* Choices by bits instead of by truth values, which keep compilers from vectorizing: all ones where x < 0 (or
 * x is not 0), else 0; x turned where the mask is set. */
static inline int32_t sl_if_negative(int32_t x) { return x >> 31; }
static inline int32_t sl_if_nonzero(int32_t x) { return (x | -x) >> 31; }
static inline int32_t sl_turn_if(int32_t mask, int32_t x) { return (x ^ mask) - mask; }

/* The constant of edge function a i + b j + e at a pixel from which a corner on the edge is seen at (u, v):
 * as above, but in 32 bits, for differences below 2^15. */
static inline int32_t sl_edge_constant(int32_t a, int32_t b, int32_t u, int32_t v) {
    int32_t owns = sl_if_negative(-a) | (~sl_if_nonzero(a) & sl_if_negative(-b));
    return (-(a * u + b * v) - (1 + owns)) >> 8;
}

/* To 32 bits, where only the sign matters beyond: within a span an edge function changes by less than 2^30.
 */
static inline int32_t sl_clamp_edge(int64_t e) {
    const int64_t limit = (int64_t)1 << 30;
    return (int32_t)(e < -limit ? -limit : e > limit ? limit : e);
}

/* Appends a triangle that needs no clipping. */
static inline void sl_batch_append(const sl_raster *raster, const sl_vertex_buffer *from, uint32_t triangle,
                                   sl_triangle_batch *batch) {
    uint32_t t = batch->count++;
    for (int k = 0; k < 3; k++) {
        uint16_t v = raster->corner[k][triangle];
        batch->snapped_u[k][t] = from->snapped_u[v];
        batch->snapped_v[k][t] = from->snapped_v[v];
        batch->x[k][t] = from->window_x[v];
        batch->y[k][t] = from->window_y[v];
        batch->depth[k][t] = from->depth[v];
    }
}

/* Appends what is left of a triangle inside all planes, as a fan, if its box holds a pixel centre; corners
 * are vertices of the buffer. At most SL_CLIP_TRIANGLES; returns how many. */
uint32_t sl_clip_triangle(const sl_pass_view *view, const sl_vertex_buffer *vertices,
                          const uint16_t corner[3], sl_triangle_batch *batch);
