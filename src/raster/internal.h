/* Inside the simulated hardware: how the geometry is held, what one triangle looks like after set-up, and the table
 * of kernels.
 *
 * One render (pass.c) runs, for every cluster that the view does not reject:
 *
 *     transform   vertices -> clip space, clip codes, viewport, snapping          (setup_kernels.c)
 *     classify    triangles: outside | not finite | to be clipped | no pixel centre | accepted
 *     clip        Sutherland-Hodgman, scalar, for the few that cross a plane      (clip.c)
 *     set up      edge functions and depth plane of the accepted                  (setup_kernels.c)
 *     rasterize   coverage, depth test, write                                     (rasterize_kernels.c)
 *
 * The depth test is a total order (nearer first, then lower triangle index), so the order in which clusters are
 * drawn cannot be seen in the picture: it is as if the triangles had been submitted in index order. */
#ifndef SL_RASTER_INTERNAL_H
#define SL_RASTER_INTERNAL_H

#include "base/counters.h"
#include "raster/raster.h"

enum {
    SL_CLUSTER_TRIANGLES = 128,
    SL_CLUSTER_VERTICES = 3 * SL_CLUSTER_TRIANGLES,
    SL_CLIP_TRIANGLES = 7, /* a triangle cut by six planes has at most nine corners, so a fan of seven */
    SL_BATCH = 176,        /* set up together: a cluster and room for clipping; no power of two, for the cache's sets */
    SL_BLOCK = 64,         /* coverage is found in blocks of 64 x 64 pixels, within which edge functions fit 32 bits */
    SL_LANES = 16,         /* pixels (or vertices) done together */
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

typedef struct sl_raster_kernels sl_raster_kernels;

struct sl_raster {
    const sl_scene *scene;
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
    size_t memory_bytes;
};

/* Constants of one view, worked out once a render. */
typedef struct sl_pass_view {
    float clip[4][4];
    float origin[3];
    float half_width, half_height;
    int width, height;
    int x0, y0, x1, y1;    /* the region to draw, half-open, in pixels */
    bool inverse_w;
    uint32_t skip;
    int planes;            /* for culling: 5 without a far plane, 6 with one */
    float plane[6][4];     /* inside: n . (p - origin) + d >= 0 */
    float plane_length[6]; /* |n| */
} sl_pass_view;

/* One cluster's vertices after the transform. */
typedef struct sl_vertex_buffer {
    float x[SL_CLUSTER_VERTICES]; /* clip space */
    float y[SL_CLUSTER_VERTICES], z[SL_CLUSTER_VERTICES], w[SL_CLUSTER_VERTICES];
    float u[SL_CLUSTER_VERTICES], v[SL_CLUSTER_VERTICES]; /* window position in 1/256 pixel from the first pixel's centre */
    float depth[SL_CLUSTER_VERTICES];
    int32_t snapped_u[SL_CLUSTER_VERTICES], snapped_v[SL_CLUSTER_VERTICES];
    int32_t cell[SL_CLUSTER_VERTICES]; /* the first pixel centre at or beyond it: j << 16 | i */
    int32_t code[SL_CLUSTER_VERTICES];
} sl_vertex_buffer;

/* What the rasterizer needs of a triangle. Pixel centres lie at multiples of 256 in (u, v). */
typedef struct sl_batch {
    uint32_t count;
    uint32_t id[SL_BATCH];
    uint8_t masked[SL_BATCH];
    /* in */
    int32_t snapped_u[3][SL_BATCH];
    int32_t snapped_v[3][SL_BATCH];
    float u[3][SL_BATCH], v[3][SL_BATCH], depth[3][SL_BATCH];
    /* out: edge functions a i + b j + c at pixel (i, j), inside where all three are >= 0 */
    int32_t a[3][SL_BATCH], b[3][SL_BATCH];
    int64_t c[3][SL_BATCH];
    int32_t x0[SL_BATCH], y0[SL_BATCH], x1[SL_BATCH], y1[SL_BATCH]; /* pixels, inclusive; empty: x0 > x1 */
    /* out: depth = (depth_origin + depth_dv (256 j - origin_v)) + depth_du (256 i - origin_u), clamped to [min, max] */
    float depth_du[SL_BATCH], depth_dv[SL_BATCH], depth_origin[SL_BATCH], depth_min[SL_BATCH], depth_max[SL_BATCH];
    int32_t origin_u[SL_BATCH], origin_v[SL_BATCH];
} sl_batch;

/* Outcome of classification, for the counters. */
typedef struct sl_classes {
    uint32_t accepted, clipped, culled, dropped;
} sl_classes;

/* Pixels whose weights are computed together: corners relative to the eye, centres in [-1,1]. */
enum { SL_BARYCENTRIC_BLOCK = 64 };
typedef struct sl_barycentric_block {
    float corner[9][SL_BARYCENTRIC_BLOCK]; /* x y z of corners 0, 1, 2 */
    double x[SL_BARYCENTRIC_BLOCK], y[SL_BARYCENTRIC_BLOCK];
} sl_barycentric_block;

struct sl_raster_kernels {
    /* Writes the indices of the clusters that may be seen, in order; returns how many. visible has room for
     * whole groups of SL_LANES. */
    uint32_t (*cull)(const sl_raster *raster, const sl_pass_view *view, uint32_t *visible);
    void (*transform)(const sl_raster *raster, uint32_t cluster, const sl_pass_view *view, sl_vertex_buffer *out);
    /* accepted, clipped: cluster-local triangle numbers, room for SL_CLUSTER_TRIANGLES. */
    sl_classes (*classify)(const sl_raster *raster, uint32_t cluster, const sl_pass_view *view,
                           const sl_vertex_buffer *vertices, uint8_t *accepted, uint8_t *clipped);
    /* Makes the "out" of triangles [0, batch->count). */
    void (*set_up)(const sl_pass_view *view, sl_batch *batch);
    /* Draws the batch's triangles that have no mask into planes of the view's whole target. */
    void (*rasterize)(const sl_pass_view *view, const sl_batch *batch, uint32_t *id, float *depth);
    /* Weights of SL_BARYCENTRIC_BLOCK pixels, see barycentrics.h. */
    void (*barycentrics)(const sl_barycentric_block *block, const sl_pass_view *view, float *w1, float *w2);
};

const sl_raster_kernels *sl_raster_kernels_best(void);

/* A worker's buffers. */
struct sl_raster_scratch {
    size_t max_pixels;
    uint32_t *visible;
    sl_vertex_buffer *vertices;
    sl_batch *batch;
    uint32_t *id;  /* for targets that want no ids, or no depth */
    float *depth;
};

/* The view's constants, region = whole target. */
sl_pass_view sl_pass_view_make(const sl_view *view);
/* Appends what is left of a triangle inside all planes, as a fan; corners are vertices of the buffer. At most
 * SL_CLIP_TRIANGLES; returns how many. */
uint32_t sl_clip_triangle(const sl_pass_view *view, const sl_vertex_buffer *vertices, const uint16_t corner[3],
                          sl_batch *batch);
/* Draws triangle t of the batch, pixel by pixel, where its alpha mask is opaque (alpha.c). */
void sl_rasterize_masked(const sl_raster *raster, const sl_view *view, const sl_pass_view *pass, const sl_batch *batch,
                         uint32_t t, uint32_t *id, float *depth);
/* The clusters to draw. Where a target is cut into regions, a cluster is drawn in regions [first_region,
 * last_region] and counted in the first; first_region NULL: one region. */
typedef struct sl_cluster_list {
    const uint32_t *cluster;
    uint32_t count;
    const uint16_t *first_region, *last_region; /* by cluster */
    uint16_t region;
} sl_cluster_list;

/* Clears and draws the pass's region of the whole target's planes. */
void sl_pass_draw(const sl_raster *raster, const sl_view *view, const sl_pass_view *pass, uint32_t *id, float *depth,
                  sl_raster_scratch *scratch, const sl_cluster_list *list, sl_counters *counters);
/* Counts a render of which `visible` clusters were left. */
void sl_pass_count(const sl_raster *raster, uint32_t visible, sl_counters *counters);

#endif
