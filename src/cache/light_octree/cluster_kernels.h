/* The loop over a voxel's photons that K-means consists of, compiled for every instruction set. */
#ifndef SL_CACHE_LIGHT_OCTREE_CLUSTER_KERNELS_H
#define SL_CACHE_LIGHT_OCTREE_CLUSTER_KERNELS_H

#include "base/isa.h"
#include "cache/light_octree/lights.h"

/* Of each cluster's members: sum w omega, sum w, and how many. */
typedef struct sl_cluster_sums {
    double x[SL_VOXEL_LIGHTS_MAX], y[SL_VOXEL_LIGHTS_MAX], z[SL_VOXEL_LIGHTS_MAX],
        weight[SL_VOXEL_LIGHTS_MAX];
    size_t members[SL_VOXEL_LIGHTS_MAX];
} sl_cluster_sums;

/* Puts every point into the cluster with the largest omega . d, ties to the lower one, and sums up; returns
 * how many changed. */
typedef size_t sl_assign_kernel(const sl_directions *directions, int clusters, const sl_vec3d *centre,
                                uint8_t *of, sl_cluster_sums *sums);
/* nearest[i] = min(nearest[i], |omega - centre|^2); returns the point with the largest w * nearest, ties to
 * the lower, and its value. */
typedef size_t sl_farthest_kernel(const sl_directions *directions, sl_vec3d centre, double *nearest,
                                  double *value);

typedef struct sl_cluster_kernels {
    sl_assign_kernel *assign;
    sl_farthest_kernel *farthest;
} sl_cluster_kernels;

SL_KERNEL_VARIANTS(sl_assign_kernel, sl_cluster_assign);
SL_KERNEL_VARIANTS(sl_farthest_kernel, sl_cluster_farthest);

static inline sl_cluster_kernels sl_cluster_kernels_for(sl_isa isa) {
    return (sl_cluster_kernels){SL_KERNEL_OF(isa, sl_cluster_assign), SL_KERNEL_OF(isa, sl_cluster_farthest)};
}

#endif
