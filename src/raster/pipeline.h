/* The stages of a render, their kernels, and what a worker needs for them.
 *
 * One render of a tile (pass.c) runs, front to back, for every cluster that the view does not reject:
 *
 *     cull        clusters: outside | between pixel centres | their rectangle on the screen  (cull_kernels.c)
 *     occlusion   clusters behind what is drawn already                                 (occlusion_kernels.c)
 *     transform   vertices -> clip space, clip codes, viewport, snapping                (transform_kernels.c)
 *     classify    triangles: outside | not finite | to be clipped | no centre | tiny | others
 *                                                                                        (classify_kernels.c)
 *     clip        Sutherland-Hodgman for those that cross a plane                                    (clip.c)
 *     set up      edge functions and depth plane of what is left                            (setup_kernels.c)
 *     rasterize   coverage, depth test, write; pixel by pixel where there is an alpha mask
 *                                                                              (rasterize_kernels.c, alpha.c)
 *
 * clusters.c made the clusters, once; view.c makes the view's constants; culling and sorting by distance are
 * done once a render; tiles.c gives the tiles of large targets to threads; tile_kernels.c clears a tile and
 * copies it to the target. What comes after the picture of ids is told in resolve.h.
 *
 * The depth test is a total order (nearer first, then lower triangle index), so the order in which clusters
 * are drawn cannot be seen in the picture: it is as if the triangles had been submitted in index order. */
#pragma once

#include "base/counters.h"
#include "raster/tile.h"
#include "raster/triangles.h"

/* The clusters that may be seen, with room for whole groups of SL_LANES beyond the raster's cluster count. */
typedef struct sl_visible {
    uint32_t count;
    uint32_t *cluster;
    int32_t *x0, *y0, *x1, *y1; /* the pixels whose centres it may cover, inclusive */
    float *nearest;             /* no pixel of it is nearer than this depth */
    float *distance;            /* for the order, front to back */
    uint32_t *order;            /* positions in the arrays above, near ones first */
} sl_visible;

SL_KERNELS(void, sl_raster_cull, (const sl_raster *raster, const sl_pass_view *view, sl_visible *visible));
SL_KERNELS(void, sl_raster_transform,
           (const sl_raster *raster, uint32_t cluster, const sl_pass_view *view, sl_vertex_buffer *out));
SL_KERNELS(void, sl_raster_classify,
           (const sl_raster *raster, uint32_t cluster, const sl_pass_view *view, const sl_tile *tile,
            const sl_vertex_buffer *vertices, sl_classes *classes));
SL_KERNELS(void, sl_raster_cover_tiny,
           (const sl_raster *raster, uint32_t cluster, const sl_tile *tile, const sl_vertex_buffer *vertices,
            const sl_classes *classes, sl_tiny *tiny));
/* Edge functions and pixels of triangles [first, count); depth planes of [0, count). */
SL_KERNELS(void, sl_raster_set_up_edges, (const sl_tile *tile, sl_triangle_batch *batch, uint32_t first));
SL_KERNELS(void, sl_raster_set_up_depth, (const sl_pass_view *view, sl_triangle_batch *batch));
/* Draws the tiny triangles, the first of the batch. */
SL_KERNELS(void, sl_raster_rasterize_tiny,
           (const sl_pass_view *view, const sl_tile *tile, const sl_triangle_batch *batch,
            const sl_tiny *tiny));
/* Draws triangles [first, count) that have no mask. */
SL_KERNELS(void, sl_raster_rasterize,
           (const sl_pass_view *view, const sl_tile *tile, const sl_triangle_batch *batch, uint32_t first));
/* Tells whether all pixels of the rectangle, which lies within the tile, show something nearer than
 * `nearest`. */
SL_KERNELS(bool, sl_raster_occluded,
           (const sl_pass_view *view, const sl_tile *tile, sl_rectangle pixels, float nearest));
SL_KERNELS(void, sl_raster_clear, (const sl_pass_view *view, const sl_tile *tile));
/* Copies the tile's pixels into planes of the whole target (either may be NULL). */
SL_KERNELS(void, sl_raster_copy_out,
           (const sl_pass_view *view, const sl_tile *tile, uint32_t *id, float *depth));

/* A worker's buffers. */
struct sl_raster_scratch {
    sl_tile tile;
    sl_visible visible; /* of a small render; a large one's workers share one elsewhere */
    _Atomic uint32_t *fate;
    sl_vertex_buffer vertices;
    sl_classes classes;
    sl_tiny tiny;
    sl_triangle_batch batch;
};

/* Sorts the visible clusters by distance into `order`. */
void sl_visible_sort(sl_visible *visible);

/* A worker's buffers, all of them, from an earlier pass or new; what is in them is left over. NULL: no
 * memory. Then back, NULL too. */
struct sl_spares *sl_spares_create(void);
void sl_spares_destroy(struct sl_spares *spares);
sl_raster_scratch *sl_spare_take(const sl_raster *raster);
void sl_spare_give(const sl_raster *raster, sl_raster_scratch *scratch);

/* Draws triangle t of the batch, pixel by pixel, where its alpha mask is opaque (alpha.c). */
void sl_rasterize_masked(const sl_raster *raster, const sl_view *view, const sl_pass_view *pass,
                         const sl_tile *tile, const sl_triangle_batch *batch, uint32_t t);

/* Fate of a visible cluster in one render: 0 if no tile drew it, else how many of its triangles fell into
 * each class (sl_fate_of), which is the same whatever tile drew it. */
typedef _Atomic uint32_t sl_cluster_fate;
static inline uint32_t sl_fate_of(const sl_classes *c) {
    /* each at most 128, and culled + clipped too */
    return UINT32_C(1) << 31 | c->culled << 16 | c->dropped << 8 | c->clipped;
}

/* Clears and draws a tile; fate: by position in `visible`, what this tile drew is filled in. */
void sl_tile_draw(const sl_raster *raster, const sl_view *view, const sl_pass_view *pass,
                  const sl_visible *visible, sl_raster_scratch *scratch, sl_cluster_fate *fate);
/* Counts a render. */
void sl_pass_count(const sl_raster *raster, const sl_visible *visible, const sl_cluster_fate *fate,
                   sl_counters *counters);
