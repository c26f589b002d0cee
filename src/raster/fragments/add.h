/* Inside additive blending (add.c): what a batch of triangles adds, and the tile that it is added to.
 *
 * Rows of a target lie thousands of bytes apart, at power-of-two widths all in the same lines of the cache, and a pixel is blended to
 * many times. So a tile's pixels are worked on in memory of the worker's own, as tile-based hardware does: span by span, a span's planes
 * one after the other and small enough for the first-level cache. A span is fetched when first touched, and returned at the end. */
#ifndef SL_RASTER_ADD_H
#define SL_RASTER_ADD_H

#include "raster/internal.h"

enum {
    SL_ADD_WIDTH = SL_SPAN, /* of a span; edge functions fit 32 bits within it */
    SL_ADD_HEIGHT = 32,
    SL_ADD_PIXELS = SL_ADD_WIDTH * SL_ADD_HEIGHT,
    SL_ADD_COLUMNS = SL_TILE / SL_ADD_WIDTH, /* spans of a tile */
    SL_ADD_ROWS = SL_TILE / SL_ADD_HEIGHT,
    SL_ADD_SPANS = SL_ADD_COLUMNS * SL_ADD_ROWS
};

/* (c + b dy) + a dx at pixel (x + dx, y + dy), (x, y) being the triangle's origin. */
typedef struct sl_value_plane {
    float a, b, c;
} sl_value_plane;

/* What is added is value / denominator, between least and most. */
typedef struct sl_add_channel {
    sl_value_plane value;
    float least, most; /* of the corners */
} sl_add_channel;

/* By triangle of a batch. */
typedef struct sl_add_planes {
    int32_t x[SL_BATCH], y[SL_BATCH]; /* origins */
    sl_value_plane denominator[SL_BATCH];
    uint8_t level[SL_BATCH];          /* the denominator is 1 all over the triangle */
    sl_add_channel *channel;          /* `channels` a triangle */
} sl_add_planes;

typedef struct sl_add_tile {
    int width, channels;  /* of the target */
    size_t plane;         /* pixels of a plane of the target */
    float *target;
    uint32_t fetched;     /* bit s: span s is in memory */
    float *memory;        /* SL_ADD_SPANS x channels x SL_ADD_PIXELS */
    sl_add_planes planes;
    sl_wide_edges edges[SL_BATCH];
    /* Of the span that is being drawn. */
    int32_t outside[SL_ADD_PIXELS]; /* negative: not covered */
    float over[SL_ADD_PIXELS];      /* 1 / denominator */
    float column[SL_ADD_WIDTH];     /* a plane's part of each column */
    int32_t begin[SL_ADD_HEIGHT], end[SL_ADD_HEIGHT]; /* columns with pixels to draw, half-open, multiples of SL_LANES */
} sl_add_tile;

static inline float *sl_add_plane(const sl_add_tile *add, int span, int channel) {
    return add->memory + ((size_t)span * (size_t)add->channels + (size_t)channel) * SL_ADD_PIXELS;
}

/* Triangles in index order, SL_CLUSTER_TRIANGLES at a time (in_order.c): bounds of all these clusters, for culling; and one of them with its
 * vertices, for the passes that come after it, as cluster 0 of a raster of its own. */
sl_status sl_in_order_bounds(const sl_raster *raster, unsigned threads, sl_raster **bounds, sl_error *error);

typedef struct sl_one_cluster {
    sl_raster raster;
    uint32_t first_triangle, triangles, first_vertex, vertices, triangle[SL_CLUSTER_TRIANGLES];
    float x[SL_CLUSTER_VERTICES], y[SL_CLUSTER_VERTICES], z[SL_CLUSTER_VERTICES];
    uint16_t corner[3][SL_CLUSTER_TRIANGLES + SL_LANES];
} sl_one_cluster;
/* The arrays are the cluster's own, so it must stay where it is. */
void sl_one_cluster_make(const sl_raster *raster, sl_one_cluster *one);
void sl_one_cluster_fetch(sl_one_cluster *one, uint32_t cluster);

#endif
