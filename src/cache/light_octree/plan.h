/* What the light octree runs for a scene, and its settings completed. */
#ifndef SL_CACHE_LIGHT_OCTREE_PLAN_H
#define SL_CACHE_LIGHT_OCTREE_PLAN_H

#include "cache/frame/method.h"

typedef struct sl_octree_plan {
    bool photons;      /* something shines and something reflects */
    /* some surface is: view vectors, lobes by direction even where the colour octree would do */
    bool glossy;
    bool mirrors;
    bool direct;       /* direct light of pixels */
    bool environment;
    /* what is smooth of the environment is in the octree; off where pixels are to have all direct light, or
     * none */
    bool sky;
    int first_depth;   /* the shallowest octree that is shown */
} sl_octree_plan;

/* Replaces what is 0 in settings->light_octree, or left to quality. The radius stays 0: it follows from the
 * photons. */
void sl_octree_complete(sl_settings *settings);
sl_octree_plan sl_octree_plan_make(const sl_scene *scene, const sl_settings *settings);
void sl_octree_transport(const sl_settings *settings, sl_transport *transport);
/* Where fewer photons than that share of k come to a voxel, and where gathers reach farther than so many
 * voxels, something is to be said. (Gathers of high quality reach 2.0 voxels in the Cornell box and 2.3 in
 * the room, of normal 1.1 and 1.3, and depth 6 errs less all the same: to warn of 2 would be to warn of every
 * picture of high quality. From 4 on a shallower octree shows as much.) */
static const double SL_OCTREE_FEW_PHOTONS = 0.1, SL_OCTREE_WIDE_GATHERS = 4.0;
/* Returns how many voxels of that edge surfaces will take: 3/2 A / h^2, since a plane of any tilt meets |n_x|
 * + |n_y|
 * + |n_z| of them in each h^2. */
double sl_octree_voxels_expected(const sl_scene *scene, double voxel);
/* Objects that are smaller than two voxels: one set of lights is all that there is of them. */
size_t sl_octree_small_objects(const sl_scene *scene, double voxel);
/* Do directional lights show some of the scene's gloss blurred? */
bool sl_octree_widens_gloss(const sl_scene *scene, const sl_light_octree_settings *settings);
void sl_octree_plan_write(const sl_scene *scene, const sl_settings *settings, sl_plan_writer *writer);

/* Returns how many chunks of photon paths one update traces. */
size_t sl_octree_photon_chunks(const sl_settings *settings);
sl_memory_need sl_octree_need(const sl_scene *scene, const sl_settings *settings);
extern const sl_reduction sl_octree_reductions[];

#endif
