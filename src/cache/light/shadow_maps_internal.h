/* Shared by the making of shadow maps and their use. */
#pragma once

#include "cache/light/depth_cube.h"
#include "cache/light/shadow_maps.h"

/* A light without extent, or a sample of one with extent, and its map. */
typedef struct sl_mapped_source {
    sl_light_source source;
    sl_depth_cube cube;
    unsigned part;
} sl_mapped_source;

/* A side of an emissive triangle, and its samples among the sources. */
typedef struct sl_mapped_emitter {
    sl_polygon_light polygon;
    sl_rgb radiance;
    size_t first, count;
} sl_mapped_emitter;

struct sl_shadow_maps {
    const sl_scene *scene;
    sl_shadow_map_settings settings;
    sl_isa isa;
    float offset;
    /* the first plain_count sources are no samples of emitters */
    size_t source_count, emitter_count, plain_count, capacity;
    sl_mapped_source *sources;
    sl_mapped_emitter *emitters;
    uint8_t square_order[SL_LIGHT_BLOCK];
};

/* ---- points and samples of an emitter (shadow_map_light.c) ---- */

/* Of a block's points: sums of weights. */
typedef struct sl_light_shares {
    float seen[SL_LIGHT_BLOCK], all[SL_LIGHT_BLOCK];
} sl_light_shares;

/* Samples that points ask, as sl_cube_looks has them: `each` the first, those that follow the second. */
typedef struct sl_questions {
    size_t count, each;
    const sl_mapped_source *source[SL_LIGHT_BLOCK];
} sl_questions;

/* Some of a block's points. */
typedef struct sl_thinned_points {
    uint8_t place[SL_LIGHT_BLOCK]; /* in the block */
    float x[SL_LIGHT_BLOCK], y[SL_LIGHT_BLOCK], z[SL_LIGHT_BLOCK];
    float geometric[3][SL_LIGHT_BLOCK], normal[3][SL_LIGHT_BLOCK];
    sl_light_points points;
} sl_thinned_points;

/* Points [first, first + count). */
sl_light_points sl_points_from(const sl_light_points *points, size_t first, size_t count);
/* Takes `count` points whose places are set. */
void sl_points_thin(const sl_light_points *all, size_t count, sl_thinned_points *few);
void sl_shares_put_back(const sl_light_shares *own, const sl_thinned_points *few, sl_light_shares *all);
/* Adds what the samples give to the sums of the points. */
void sl_ask_samples(const sl_shadow_maps *maps, const sl_questions *questions, const sl_light_points *points,
                    float *seen, float *all, sl_counters *counters);
/* Adds what samples [first, last) give to points [begin, end). */
void sl_add_samples(const sl_shadow_maps *maps, const sl_mapped_emitter *emitter, size_t first, size_t last,
                    const sl_light_points *points, size_t begin, size_t end, sl_light_shares *shares,
                    sl_counters *counters);

/* ---- squares of two by two pixels (shadow_map_squares.c) ---- */

enum { SL_SQUARE = 4, SL_SQUARES = SL_LIGHT_BLOCK / SL_SQUARE, SL_SQUARE_PAIRS = 6 };

/* The squares of two tiles. */
typedef struct sl_light_squares {
    /* in each half the first pixels of all squares, then the second ones, and so on */
    sl_thinned_points sorted;
    uint32_t alike[SL_SQUARE_PAIRS][SL_SQUARES]; /* whether two of a square's pixels show one surface */
} sl_light_squares;

/* Finds the places of pixels that are sorted so. */
void sl_order_squares(uint8_t place[SL_LIGHT_BLOCK]);
void sl_sort_by_squares(const sl_shadow_maps *maps, const sl_light_points *points, sl_light_squares *squares);
/* Tells whether an emitter has enough samples for the pixels of a square to share. */
bool sl_can_interleave(const sl_mapped_emitter *emitter);
/* Finds the shares of all samples that the points of two tiles see. */
void sl_share_by_squares(const sl_shadow_maps *maps, const sl_mapped_emitter *emitter,
                         const sl_light_squares *squares, sl_light_shares *shares, sl_counters *counters);
