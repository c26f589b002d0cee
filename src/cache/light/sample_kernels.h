/* The loops over the pixels of a light's picture and over rays, compiled for every instruction set. */
#pragma once

#include "base/isa.h"
#include "base/vec.h"

#include <stdint.h>

/* A picture in tangents at distance 1 along the view's axis: the pixel in column i, row j looks along
 * (column_x[i] + row_x[j], column_y[i] + row_y[j], 1). */
typedef struct sl_light_pixels {
    int size;
    const float *column_x, *column_y, *row_x, *row_y;
    sl_vec3 normal, geometric;   /* of the receiver, in the view's frame */
    float scale;                 /* a pixel's area in tangents, over pi */
    float *seen, *all;           /* size x size each */
} sl_light_pixels;

/* The light is what its own picture shows (light_id: a triangle with facing != 0); seen where the scene is no
 * nearer, depths being 1/w. */
SL_KERNELS(void, sl_look_at_weigh,
           (const sl_light_pixels *pixels, const uint32_t *light_id, const uint8_t *facing,
            const float *light_depth, const float *depth));

/* ---- rays ---- */

enum { SL_AIMED = 16 };

/* Where rays are aimed, from the receiver; the light's normal there; what they are worth, and how far they
 * count (1: at the light). */
typedef struct sl_aimed_rays {
    _Alignas(64) float x[SL_AIMED], y[SL_AIMED], z[SL_AIMED];
    float normal_x[SL_AIMED], normal_y[SL_AIMED], normal_z[SL_AIMED];
    float weight[SL_AIMED], far[SL_AIMED];
} sl_aimed_rays;

typedef struct sl_ray_receiver {
    sl_vec3 normal, geometric;
    float scale;                 /* weights are multiplied by this */
    /* how near to the light's plane, and to its end, a ray ends: in lengths, and in its own */
    float flatness, margin;
    bool two_sided;
} sl_ray_receiver;

/* Numbers in [0,1) of the strata in columns and rows of n x n. */
SL_KERNELS(void, sl_ray_jitter,
           (uint64_t key, int n, const int32_t *column, const int32_t *row, float *u, float *v));
SL_KERNELS(void, sl_ray_weights, (const sl_ray_receiver *receiver, sl_aimed_rays *rays));
