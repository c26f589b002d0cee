/* Loops of direct light over a block of pixels that are compiled for every instruction set. */
#ifndef SL_CACHE_DIRECT_KERNELS_H
#define SL_CACHE_DIRECT_KERNELS_H

#include "cache/light/light_kernels.h"

/* A side of an emitter for sl_aim_kernel: corner, two edges, normal (unit), area, chromaticity (radiance over
 * its luminance). */
enum { SL_SIDE_VALUES = 16 };

typedef struct sl_aim_block {
    const sl_light_points *points;
    size_t sides;               /* that can light some point of the block */
    const uint32_t *side;       /* which, into triangles */
    const float *triangles;
    /* irradiance from each of them over its luminance, SL_LIGHT_BLOCK values a side */
    const float *share;
    const float *sums;          /* cumulative irradiances (luminance), SL_LIGHT_BLOCK values a side */
    const float *u0, *u1, *u2;  /* which side, and the point of it */
    int32_t *chosen;            /* out: which of the sides */
    float *x, *y, *z;           /* out: towards the light's point, whole */
    /* out: the sample's irradiance (luminance), shadows aside; both 0 where none arrives */
    float *weight;
    float *r, *g, *b;           /* out: its chromaticity */
    /* out: 1 where a ray must tell, 0: not lit, or the surface itself is in the way */
    float *wanted;
} sl_aim_block;

/* Chooses a side in proportion to its irradiance and a point of it by area. */
typedef void sl_aim_kernel(const sl_aim_block *block);

SL_KERNEL_VARIANTS(sl_aim_kernel, sl_direct_aim);

static inline sl_aim_kernel *sl_aim_kernel_for(sl_isa isa) { return SL_KERNEL_OF(isa, sl_direct_aim); }

#endif
