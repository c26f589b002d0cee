/* Inside the simulated hardware: how the geometry is held, what one triangle looks like after set-up, and the table
 * of kernels.
 *
 * One render of a tile (pass.c) runs, front to back, for every cluster that the view does not reject:
 *
 *     cull        clusters: outside | between pixel centres | their rectangle on the screen   (cull_kernels.c)
 *     occlusion   clusters behind what is drawn already                                       (occlusion_kernels.c)
 *     transform   vertices -> clip space, clip codes, viewport, snapping                      (transform_kernels.c)
 *     classify    triangles: outside | not finite | to be clipped | no centre | tiny | others (classify_kernels.c)
 *     clip        Sutherland-Hodgman for those that cross a plane                     (clip.c, clip_kernels.c)
 *     set up      edge functions and depth plane of what is left                              (setup_kernels.c)
 *     rasterize   coverage, depth test, write; pixel by pixel where there is an alpha mask     (rasterize_kernels.c, alpha.c)
 *
 * clusters.c made the clusters, once; view.c makes the view's constants; culling and sorting by distance (order.c) are done once a render;
 * tiles.c gives the tiles of large targets to threads, spare.c keeps their buffers from pass to pass; tile_kernels.c clears a tile and
 * copies it to the target. kernels.c chooses the instruction set of all files called *_kernels.c. What comes after the picture of ids is
 * told in resolve.h, blending in add.h, textures in textures.h.
 *
 * The depth test is a total order (nearer first, then lower triangle index), so the order in which clusters are
 * drawn cannot be seen in the picture: it is as if the triangles had been submitted in index order.
 *
 * A tile's planes are kept in blocks of 4 x 4 pixels, a block being sixteen lanes side by side in memory:
 *
 *      y                                    12 13 14 15 | 28 29 30 31 | ...
 *      |     +--+--+--+                      8  9 10 11 | 24 25 26 27 |
 *      |     |b3|b4|b5|       each block:    4  5  6  7 | 20 21 22 23 |
 *      |     +--+--+--+                      0  1  2  3 | 16 17 18 19 |
 *      |     |b0|b1|b2|
 *      +---- +--+--+--+ ---- x              block 0       block 1
 *
 * Small triangles touch few blocks, where they would touch many rows. */
#ifndef SL_RASTER_INTERNAL_H
#define SL_RASTER_INTERNAL_H

#include <math.h>

#include "base/counters.h"
#include "raster/raster.h"

enum {
    SL_CLUSTER_TRIANGLES = 128,
    SL_CLUSTER_VERTICES = 3 * SL_CLUSTER_TRIANGLES,
    SL_CLIP_TRIANGLES = 7, /* a triangle cut by six planes has at most nine corners, so a fan of seven */
    SL_BATCH = 240,        /* set up together: a cluster and room for clipping; no power of two, for the cache's sets */
    SL_CLIP_ROOM = 112,    /* six pieces of each of sixteen triangles, and a vector to spare */
    SL_BLOCK = 4,          /* pixels along a block's side; also the most along a tiny triangle's */
    SL_LANES = 16,         /* pixels (or vertices, triangles, clusters) done together: a block */
    SL_SPAN = 64,          /* larger triangles are drawn in pieces of 64 x 64, within which edge functions fit 32 bits */
    SL_TILE = 256,         /* pixels along a tile's side */
    SL_TILE_PIXELS = SL_TILE * SL_TILE,
    SL_RASTER_MAX_SIZE = 16384, /* so that snapped coordinates stay below 2^22 */
    SL_SUBPIXEL = 256      /* 8 bits */
};

/* Clip codes. The four sides, then near and far; the planes' order is that of clipping. */
enum {
    SL_CLIP_RIGHT = 1,  /* x > w */
    SL_CLIP_LEFT = 2,   /* x < -w */
    SL_CLIP_TOP = 4,    /* y > w */
    SL_CLIP_BOTTOM = 8, /* y < -w */
    SL_CLIP_NEAR = 16,
    SL_CLIP_FAR = 32,
    SL_CLIP_INVALID = 64, /* a coordinate is NaN, infinite or so large that differences could overflow */
    SL_CLIP_PLANES = 6
};

/* Nearer corners are at the eye: 1/w would not be finite. */
#define SL_LEAST_W 0x1p-126f

typedef struct sl_raster_kernels sl_raster_kernels;
struct sl_add_tile;

struct sl_raster {
    const sl_scene *scene; /* NULL for a mesh alone */
    sl_raster_mesh mesh;
    const sl_raster_kernels *kernels;
    bool masked; /* some triangle has an alpha mask */

    size_t cluster_count;
    /* Bounds: box and sphere share a centre. Arrays are padded to whole groups of SL_LANES. */
    float *centre_x, *centre_y, *centre_z, *half_x, *half_y, *half_z, *radius;
    uint32_t *first_triangle, *triangles, *first_vertex, *vertices; /* cluster_count each */

    /* Positions, welded within a cluster by their bits; every cluster starts at a multiple of SL_LANES. */
    float *vertex_x, *vertex_y, *vertex_z;
    uint16_t *corner[3];     /* cluster-local vertex of each corner, in cluster order; a group of padding at the end */
    uint32_t *triangle;      /* the scene's index of each */
    uint8_t *triangle_masked;
    uint32_t *cluster_of_triangle; /* by the scene's index */
    size_t memory_bytes;
    struct sl_vertex_sources *sources; /* of the vertices, once something moves (move.c); NULL before */
    struct sl_spares *spares; /* buffers between passes (spare.c); NULL where no pass over tiles runs */
};

/* How depth is found between a triangle's corners, and which depth is nearer. */
typedef enum sl_depth_rule {
    SL_NEARER_IS_SMALLER, /* window depth */
    SL_NEARER_IS_LARGER,  /* 1/w */
    SL_OPENGL_PLANE       /* window depth from the plane at the target's corner */
} sl_depth_rule;

/* Constants of one view, worked out once a render. */
typedef struct sl_pass_view {
    float clip[4][4];
    float origin[3];
    float half_width, half_height;
    float offset_x, offset_y; /* window = ndc * half + offset: half the viewport's size plus its corner */
    int width, height;        /* of the target */
    int x0, y0, x1, y1;       /* the pixels to draw, half-open, in the target: the viewport, or the scissor's part of it */
    bool inverse_w;
    sl_depth_rule rule;
    uint32_t skip;
    const uint8_t *left_out;
    int planes;            /* for culling: 5 without a far plane, 6 with one */
    float plane[6][4];     /* inside: n . (p - origin) + d >= 0 */
    float plane_length[6]; /* |n|; infinite if that is next to nothing */
} sl_pass_view;

/* The clusters that may be seen, with room for whole groups of SL_LANES beyond the raster's cluster count. */
typedef struct sl_visible {
    uint32_t count;
    uint32_t *cluster;
    int32_t *x0, *y0, *x1, *y1; /* the pixels whose centres it may cover, inclusive */
    float *nearest;             /* no pixel of it is nearer than this depth */
    float *distance;            /* for the order, front to back */
    uint32_t *order;            /* positions in the arrays above, near ones first */
} sl_visible;

/* One cluster's vertices after the transform. */
typedef struct sl_vertex_buffer {
    float x[SL_CLUSTER_VERTICES]; /* clip space */
    float y[SL_CLUSTER_VERTICES], z[SL_CLUSTER_VERTICES], w[SL_CLUSTER_VERTICES];
    float window_x[SL_CLUSTER_VERTICES], window_y[SL_CLUSTER_VERTICES], depth[SL_CLUSTER_VERTICES];
    float oow[SL_CLUSTER_VERTICES];
    int32_t snapped_u[SL_CLUSTER_VERTICES], snapped_v[SL_CLUSTER_VERTICES]; /* 1/256 pixel from the first pixel's centre */
    int32_t cell[SL_CLUSTER_VERTICES]; /* the first pixel centre at or beyond it: j << 16 | i */
    int32_t code[SL_CLUSTER_VERTICES];
} sl_vertex_buffer;

/* What becomes of a cluster's triangles. Lists hold cluster-local numbers. */
typedef struct sl_classes {
    uint32_t tiny, other, clipped, culled, dropped;
    uint32_t clipped_once; /* how many of those to be clipped cross one plane only; they come first on the list */
    uint8_t tiny_list[SL_CLUSTER_TRIANGLES + SL_LANES];    /* their pixels lie in a square of SL_BLOCK, anywhere; no mask */
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
typedef struct sl_batch {
    uint32_t count;
    uint32_t id[SL_BATCH];
    uint8_t masked[SL_BATCH];
    /* in */
    int32_t snapped_u[3][SL_BATCH], snapped_v[3][SL_BATCH];
    float x[3][SL_BATCH], y[3][SL_BATCH], depth[3][SL_BATCH]; /* window, not snapped */
    /* out: pixels that may be covered, inclusive; empty: x0 > x1 */
    int32_t x0[SL_BATCH], y0[SL_BATCH], x1[SL_BATCH], y1[SL_BATCH];
    /* out, where at most SL_SPAN pixels wide and high: edge functions a i + b j + e, (i, j) from the first pixel of the
     * first block; inside where all three are >= 0 */
    int32_t a[3][SL_BATCH], b[3][SL_BATCH], e[3][SL_BATCH];
    /* out: depth = (origin + dv (256 j - origin_v)) + du (256 i - origin_u), clamped to [min, max]; by SL_OPENGL_PLANE
     * fma(dv, j, fma(du, i, origin)); where steep, in double from the corners */
    int32_t steep[SL_BATCH];
    float depth_du[SL_BATCH], depth_dv[SL_BATCH], depth_origin[SL_BATCH], depth_min[SL_BATCH], depth_max[SL_BATCH];
    int32_t origin_u[SL_BATCH], origin_v[SL_BATCH];
} sl_batch;

/* Thin slivers may have so steep a plane that its terms, each many times the depth itself, would leave little of it in float. They
 * are few, and cover few pixels: their plane is kept in double, told from the first corner. */
typedef struct sl_steep_plane {
    double u, v, depth, du, dv;
} sl_steep_plane;

static inline sl_steep_plane sl_steep_plane_of(const sl_batch *b, uint32_t t) {
    double u0 = (double)((b->x[0][t] - 0.5f) * 256.0f), v0 = (double)((b->y[0][t] - 0.5f) * 256.0f), z0 = (double)b->depth[0][t];
    double du1 = (double)((b->x[1][t] - 0.5f) * 256.0f) - u0, dv1 = (double)((b->y[1][t] - 0.5f) * 256.0f) - v0;
    double du2 = (double)((b->x[2][t] - 0.5f) * 256.0f) - u0, dv2 = (double)((b->y[2][t] - 0.5f) * 256.0f) - v0;
    double dz1 = (double)b->depth[1][t] - z0, dz2 = (double)b->depth[2][t] - z0, over = 1.0 / (du1 * dv2 - dv1 * du2);
    return (sl_steep_plane){u0, v0, z0, (dz1 * dv2 - dz2 * dv1) * over, (dz2 * du1 - dz1 * du2) * over};
}

static inline float sl_steep_depth_at(const sl_steep_plane *p, int32_t x, int32_t y) {
    return (float)(p->depth + (p->du * ((double)(x * SL_SUBPIXEL) - p->u) + p->dv * ((double)(y * SL_SUBPIXEL) - p->v)));
}

/* Depth of triangle t at pixel (x, y), by itself, so that it does not depend on blocks, lanes or tiles. All that is turned to
 * float is whole and below 2^23, exact. */
static inline float sl_depth_at(sl_depth_rule rule, const sl_batch *b, uint32_t t, int32_t x, int32_t y) {
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

/* The picture in the making: at most SL_TILE x SL_TILE pixels, block by block. */
typedef struct sl_tile {
    int left, low;         /* the first block's first pixel, in the target; multiples of SL_TILE */
    int x0, y0, x1, y1;    /* the pixels to draw, half-open */
    int blocks_x, blocks_y;
    uint32_t *id;
    float *depth;
} sl_tile;

/* Pixels, inclusive. */
typedef struct sl_rectangle {
    int x0, y0, x1, y1;
} sl_rectangle;

/* Edge functions of a triangle of any size: a i + b j + c at pixel (i, j) of the target, inside where all three are >= 0. */
typedef struct sl_wide_edges {
    int64_t a[3], b[3], c[3];
} sl_wide_edges;

/* Edge k runs from corner k+1 to corner k+2; E(u, v) = a (u - u_P) + b (v - v_P) is positive inside once the signs are
 * turned by the area's. At pixel centres E = 256 (a i + b j) + c, so E >= 0 is a i + b j + floor(c / 256) >= 0. Edges that do
 * not own their points (all but left edges and lowest horizontal ones) ask for E >= 1. Returns false if there is no area. */
static inline bool sl_widen_edges(const sl_batch *batch, uint32_t t, sl_wide_edges *w) {
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

static inline int sl_larger(int a, int b) { return a > b ? a : b; }
static inline int sl_smaller(int a, int b) { return a < b ? a : b; }
static inline int32_t sl_min3(int32_t a, int32_t b, int32_t c) { return sl_smaller(sl_smaller(a, b), c); }
static inline int32_t sl_max3(int32_t a, int32_t b, int32_t c) { return sl_larger(sl_larger(a, b), c); }

/* Choices by bits instead of by truth values, which keep compilers from vectorizing: all ones where x < 0 (or x is not 0),
 * else 0; x turned where the mask is set. */
static inline int32_t sl_if_negative(int32_t x) { return x >> 31; }
static inline int32_t sl_if_nonzero(int32_t x) { return (x | -x) >> 31; }
static inline int32_t sl_turn_if(int32_t mask, int32_t x) { return (x ^ mask) - mask; }

/* The constant of edge function a i + b j + e at a pixel from which a corner on the edge is seen at (u, v): as above, but in
 * 32 bits, for differences below 2^15. */
static inline int32_t sl_edge_constant(int32_t a, int32_t b, int32_t u, int32_t v) {
    int32_t owns = sl_if_negative(-a) | (~sl_if_nonzero(a) & sl_if_negative(-b));
    return (-(a * u + b * v) - (1 + owns)) >> 8;
}

/* To 32 bits, where only the sign matters beyond: within a span an edge function changes by less than 2^30. */
static inline int32_t sl_clamp_edge(int64_t e) {
    const int64_t limit = (int64_t)1 << 30;
    return (int32_t)(e < -limit ? -limit : e > limit ? limit : e);
}

struct sl_raster_kernels {
    void (*cull)(const sl_raster *raster, const sl_pass_view *view, sl_visible *visible);
    void (*transform)(const sl_raster *raster, uint32_t cluster, const sl_pass_view *view, sl_vertex_buffer *out);
    void (*classify)(const sl_raster *raster, uint32_t cluster, const sl_pass_view *view, const sl_tile *tile,
                     const sl_vertex_buffer *vertices, sl_classes *classes);
    void (*cover_tiny)(const sl_raster *raster, uint32_t cluster, const sl_tile *tile, const sl_vertex_buffer *vertices,
                       const sl_classes *classes, sl_tiny *tiny);
    /* Appends what is left of at most SL_LANES triangles of the cluster that starts at triangle `first`; there must be room for
     * SL_CLIP_ROOM. Returns those left to sl_clip_triangle(), a bit each. */
    uint32_t (*clip)(const sl_raster *raster, uint32_t first, const sl_pass_view *view, const sl_vertex_buffer *vertices,
                     const uint8_t *list, uint32_t count, sl_batch *batch);
    /* Edge functions and pixels of triangles [first, count); depth planes of [0, count). */
    void (*set_up_edges)(const sl_tile *tile, sl_batch *batch, uint32_t first);
    void (*set_up_depth)(const sl_pass_view *view, sl_batch *batch);
    /* Draws the tiny triangles, the first of the batch. */
    void (*rasterize_tiny)(const sl_pass_view *view, const sl_tile *tile, const sl_batch *batch, const sl_tiny *tiny);
    /* Draws triangles [first, count) that have no mask. */
    void (*rasterize)(const sl_pass_view *view, const sl_tile *tile, const sl_batch *batch, uint32_t first);
    /* Whether all pixels of the rectangle, which lies within the tile, show something nearer than `nearest`. */
    bool (*occluded)(const sl_pass_view *view, const sl_tile *tile, sl_rectangle pixels, float nearest);
    void (*clear)(const sl_pass_view *view, const sl_tile *tile);
    /* Copies the tile's pixels into planes of the whole target (either may be NULL). */
    void (*copy_out)(const sl_pass_view *view, const sl_tile *tile, uint32_t *id, float *depth);
    /* Additive blending (add.h): adds the batch to a tile, and returns how many pixels; brings the tile back to the target. */
    uint64_t (*add)(const sl_tile *tile, const sl_batch *batch, struct sl_add_tile *add);
    void (*add_return)(const sl_tile *tile, struct sl_add_tile *add);
    const struct sl_resolve_kernels *resolve; /* resolve.h */
};

const sl_raster_kernels *sl_raster_kernels_best(void);

/* A worker's buffers. */
struct sl_raster_scratch {
    sl_tile tile;
    sl_visible visible; /* of a small render; a large one's workers share one elsewhere */
    _Atomic uint32_t *fate;
    sl_vertex_buffer vertices;
    sl_classes classes;
    sl_tiny tiny;
    sl_batch batch;
};

static inline sl_vec3 sl_mesh_position(const sl_raster_mesh *m, uint32_t vertex) {
    return sl_v3(m->x[vertex], m->y[vertex], m->z[vertex]);
}

/* The view's constants for a target of this size. */
sl_pass_view sl_pass_view_make(const sl_view *view, int width, int height);
/* A tile's place in the target and the viewport's part of it. */
void sl_tile_place(sl_tile *tile, const sl_pass_view *view, int column, int row);
/* Number and first of the tiles that the viewport touches. */
typedef struct sl_tiles {
    int first_column, first_row, columns, rows;
} sl_tiles;
sl_tiles sl_tiles_of(const sl_pass_view *view);

bool sl_visible_allocate(sl_visible *visible, const sl_raster *raster);
void sl_visible_free(sl_visible *visible);
/* A worker's buffers, all of them, from an earlier pass or new; what is in them is left over. NULL: no memory. Then back, NULL too. */
struct sl_spares *sl_spares_create(void);
void sl_spares_destroy(struct sl_spares *spares);
sl_raster_scratch *sl_spare_take(const sl_raster *raster);
void sl_spare_give(const sl_raster *raster, sl_raster_scratch *scratch);
/* Sorts the visible clusters by distance into `order` (order.c). */
void sl_visible_sort(sl_visible *visible);

/* SL_OK if the viewport lies within the target. */
sl_status sl_viewport_check(const sl_view *view, const sl_target *target, sl_error *error);
/* Room for the clusters' bounds, and bounds around vertices (clusters.c). */
bool sl_bounds_allocate(sl_raster *raster, size_t clusters);
void sl_vertex_sources_destroy(struct sl_vertex_sources *sources);
void sl_bound_cluster(sl_raster *raster, size_t cluster, const float *x, const float *y, const float *z, size_t count);

/* Appends a triangle that needs no clipping. */
static inline void sl_batch_append(const sl_raster *raster, const sl_vertex_buffer *from, uint32_t triangle, sl_batch *batch) {
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

/* Appends what is left of a triangle inside all planes, as a fan, if its box holds a pixel centre; corners are vertices of the buffer. At most
 * SL_CLIP_TRIANGLES; returns how many. */
uint32_t sl_clip_triangle(const sl_pass_view *view, const sl_vertex_buffer *vertices, const uint16_t corner[3],
                          sl_batch *batch);
/* Draws triangle t of the batch, pixel by pixel, where its alpha mask is opaque (alpha.c). */
void sl_rasterize_masked(const sl_raster *raster, const sl_view *view, const sl_pass_view *pass, const sl_tile *tile,
                         const sl_batch *batch, uint32_t t);

/* What happened to a visible cluster in one render: 0 if no tile drew it, else how many of its triangles fell into each
 * class (sl_fate_of), which is the same whatever tile drew it. */
typedef _Atomic uint32_t sl_cluster_fate;
static inline uint32_t sl_fate_of(const sl_classes *c) {
    return UINT32_C(1) << 31 | c->culled << 16 | c->dropped << 8 | c->clipped; /* each at most 128, and culled + clipped too */
}

/* Clears and draws a tile; fate: by position in `visible`, what this tile drew is filled in. */
void sl_tile_draw(const sl_raster *raster, const sl_view *view, const sl_pass_view *pass, const sl_visible *visible,
                  sl_raster_scratch *scratch, sl_cluster_fate *fate);
/* Counts a render. */
void sl_pass_count(const sl_raster *raster, const sl_visible *visible, const sl_cluster_fate *fate, sl_counters *counters);

/* Index of a pixel in the tile's planes. */
static inline size_t sl_tile_index(const sl_tile *tile, int x, int y) {
    int i = x - tile->left, j = y - tile->low;
    return (size_t)(((j >> 2) * tile->blocks_x + (i >> 2)) * SL_LANES + (j & 3) * SL_BLOCK + (i & 3));
}

#endif
