/* From a voxel's photons to its virtual directional lights: K-means on directions (cluster_kernels.c), and
 * what each cluster's colour means (voxel_lobes.c). */
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
 * index; J never rises. iterations: at most so many. of: the cluster of each point; a cluster may end without
 * any. scratch: count doubles. */
SL_KERNELS(void, sl_cluster,
           (const sl_directions *directions, int wanted, int iterations, uint8_t *of, double *scratch,
            sl_clusters *clusters));

static inline void sl_cluster_directions(const sl_directions *directions, int wanted, uint8_t *of,
                                         double *scratch, sl_clusters *clusters) {
    SL_KERNEL_OF(sl_isa_best(), sl_cluster)(directions, wanted, SL_CLUSTER_ITERATIONS, of, scratch, clusters);
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
