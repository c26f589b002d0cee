/* Points of a plane, as loops over lanes for every instruction set: which lie farthest out, and which lie
 * outside a polygon. */
#ifndef SL_CACHE_LIGHT_OCTREE_PHOTON_HULL_KERNELS_H
#define SL_CACHE_LIGHT_OCTREE_PHOTON_HULL_KERNELS_H

#include "base/isa.h"

#include <stddef.h>
#include <stdint.h>

enum { SL_HULL_LANES = 8, SL_HULL_WAYS = 8 };

/* Edges of a convex polygon, counter-clockwise: start and direction. */
typedef struct sl_hull_edges {
    int count;
    float x[SL_HULL_WAYS], y[SL_HULL_WAYS], along_x[SL_HULL_WAYS], along_y[SL_HULL_WAYS];
} sl_hull_edges;

/* The points that are farthest along (1,0), (1,1), (0,1) and on, counter-clockwise; ties to the lower number.
 * count > 0. */
typedef void sl_hull_extremes_kernel(const float *x, const float *y, size_t count,
                                     uint32_t extreme[SL_HULL_WAYS]);
/* Numbers of the points that are not clearly inside: to the right of an edge, or nearer to it than `slack`
 * over its length. Returns how many. */
typedef size_t sl_hull_outside_kernel(const float *x, const float *y, size_t count,
                                      const sl_hull_edges *edges, float slack, uint32_t *outside);

typedef struct sl_hull_kernels {
    sl_hull_extremes_kernel *extremes;
    sl_hull_outside_kernel *outside;
} sl_hull_kernels;

SL_KERNEL_VARIANTS(sl_hull_extremes_kernel, sl_hull_extremes);
SL_KERNEL_VARIANTS(sl_hull_outside_kernel, sl_hull_outside);

static inline sl_hull_kernels sl_hull_kernels_for(sl_isa isa) {
    return (sl_hull_kernels){SL_KERNEL_OF(isa, sl_hull_extremes), SL_KERNEL_OF(isa, sl_hull_outside)};
}

#endif
