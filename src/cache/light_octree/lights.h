/* From a voxel's photons to its virtual directional lights: K-means on directions (cluster.c), and what each
 * cluster's colour means (voxel_lobes.c). */
#ifndef SL_CACHE_LIGHT_OCTREE_LIGHTS_H
#define SL_CACHE_LIGHT_OCTREE_LIGHTS_H

#include "base/isa.h"
#include "cache/photons/photon_tree.h"

enum { SL_VOXEL_LIGHTS_MAX = 8, SL_CLUSTER_ITERATIONS = 32 };

/* Points to be clustered: unit vectors and their weights, n of each. */
typedef struct sl_directions {
    size_t count;
    const float *x, *y, *z;
    const double *weight; /* > 0 */
} sl_directions;

typedef struct sl_clusters {
    /* at most what was asked for; fewer where there are fewer distinct directions */
    int count;
    sl_vec3d centre[SL_VOXEL_LIGHTS_MAX];    /* unit */
    double cost;                             /* J = sum w |omega - d|^2 */
    int iterations;
} sl_clusters;

/* Deterministic: first centre nearest to the mean, next ones by largest weighted distance, ties to the lower
 * index; J never rises. of: the cluster of each point. scratch: count doubles. */
void sl_cluster_directions(const sl_directions *directions, int wanted, uint8_t *of, double *scratch,
                           sl_clusters *clusters);

/* Its parts: centres to start from, and one iteration, which returns how many points changed their cluster.
 */
void sl_cluster_start(const sl_directions *directions, int wanted, double *scratch, sl_clusters *clusters);
size_t sl_cluster_step(const sl_directions *directions, uint8_t *of, sl_clusters *clusters);

/* ---- the loop over a voxel's photons, for every instruction set (cluster_kernels.c) ---- */

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

/* ---- a light ---- */

/* 16 bytes: one RGBA32F texel. */
typedef struct sl_directional_light {
    float color[3];      /* W/m^2 perpendicular to the direction, or on the surface */
    float packed;        /* the direction, an integer below 2^24: exact in a float */
} sl_directional_light;

/* 254 steps of the polar angle and 256 of the azimuth: 8 + 8 bits. Axes are exact. */
float sl_direction_pack(sl_vec3d direction);
sl_vec3 sl_direction_unpack(float packed);

#endif
