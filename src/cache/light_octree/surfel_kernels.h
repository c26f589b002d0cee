/* Small triangles as points with a normal and an area: the loop that finds how much of them an ellipsoid
 * holds, for every instruction set. */
#ifndef SL_CACHE_LIGHT_OCTREE_SURFEL_KERNELS_H
#define SL_CACHE_LIGHT_OCTREE_SURFEL_KERNELS_H

#include "base/isa.h"
#include "base/vec.h"

#include <stddef.h>

enum { SL_SURFEL_LANES = 8 };

/* Whole groups of SL_SURFEL_LANES; fill-ups have area 0. */
typedef struct sl_surfels {
    float *x, *y, *z, *normal_x, *normal_y, *normal_z, *area;
} sl_surfels;

typedef struct sl_surfel_query {
    sl_vec3 centre, normal;      /* zero normal: all count as front */
    float stretch;               /* 1 / f^2 - 1 */
    float limit;                 /* R^2 */
    float least_cosine;          /* of the normals' angle, whatever its sign */
} sl_surfel_query;

/* Sums by the sign of the cosine: area, area projected along the normal, and area times height above the
 * centre's plane. Added to. */
typedef struct sl_surfel_sums {
    double front, back, front_flat, back_flat, front_height, back_height;
} sl_surfel_sums;

typedef void sl_surfel_kernel(const sl_surfels *surfels, size_t first, size_t end,
                              const sl_surfel_query *query, sl_surfel_sums *sums);
SL_KERNEL_VARIANTS(sl_surfel_kernel, sl_surfel_area);

static inline sl_surfel_kernel *sl_surfel_kernel_for(sl_isa isa) { return SL_KERNEL_OF(isa, sl_surfel_area); }

#endif
