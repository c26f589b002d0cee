/* The loops over hits and light sources that are compiled for every instruction set. */
#ifndef SL_CACHE_GATHER_HIT_LIGHT_KERNELS_H
#define SL_CACHE_GATHER_HIT_LIGHT_KERNELS_H

#include "base/isa.h"
#include "cache/hemisphere/light_sources.h"
#include "cache/light/light_kernels.h"

/* Hits to be lit, by slot. In: points, what reflects. Out: what each block of sources may give,
 * unhindered, and all of them together (0: nothing, or no hit). */
typedef struct sl_expected_light {
    sl_light_points at;
    const float *reflects; /* > 0: yes */
    float *of_block;       /* [slot][SL_SOURCE_BLOCKS_MAX] */
    float *sum;
} sl_expected_light;

/* What the sixteen sources of a block may give to one hit. */
typedef struct sl_block_weights {
    _Alignas(64) float of[SL_SOURCE_LANES];
} sl_block_weights;

/* Light samples with their source chosen: sample m lights slot[m]. In: what is known; out: the shadow ray
 * from the hit's shifted position to the light, and the factor of the emitter's radiance that arrives (0:
 * none). */
typedef struct sl_point_samples {
    size_t count;
    const uint32_t *slot, *source;
    const float *share;       /* 1 over the expected number of samples with this slot and source */
    const float *u1, *u2;
    sl_light_points at;       /* slots */
    /* a share of its greatest coordinate that a point leaves its surface at least (sl_scene_rounding()) */
    float offset, rounding;
    float *origin_x, *origin_y, *origin_z, *direction_x, *direction_y, *direction_z, *arriving;
    float *near;              /* 1: so near to its emitter that it must be sampled by solid angle */
} sl_point_samples;

typedef void sl_hit_light_expect_kernel(const sl_light_sources *sources, const sl_expected_light *light);
typedef void sl_hit_light_block_kernel(const sl_light_sources *sources, const sl_expected_light *light,
                                       size_t slot, size_t block, sl_block_weights *weights);
typedef void sl_hit_light_points_kernel(const sl_light_sources *sources, const sl_point_samples *samples);

typedef struct sl_hit_light_kernels {
    sl_hit_light_expect_kernel *expect;
    sl_hit_light_block_kernel *block;
    sl_hit_light_points_kernel *points;
} sl_hit_light_kernels;

SL_KERNEL_VARIANTS(sl_hit_light_expect_kernel, sl_hit_light_expect);
SL_KERNEL_VARIANTS(sl_hit_light_block_kernel, sl_hit_light_block);
SL_KERNEL_VARIANTS(sl_hit_light_points_kernel, sl_hit_light_points);

static inline sl_hit_light_kernels sl_hit_light_kernels_for(sl_isa isa) {
    return (sl_hit_light_kernels){
        SL_KERNEL_OF(isa, sl_hit_light_expect), SL_KERNEL_OF(isa, sl_hit_light_block),
        SL_KERNEL_OF(isa, sl_hit_light_points)};
}

#endif
