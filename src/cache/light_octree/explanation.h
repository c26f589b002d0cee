/* What made a pixel, and what can be seen of photons and voxels: for those who look on. */
#ifndef SL_CACHE_LIGHT_OCTREE_EXPLANATION_H
#define SL_CACHE_LIGHT_OCTREE_EXPLANATION_H

#include "cache/frame/announce.h"
#include "cache/photons/photons.h"
#include "cache/light_octree/shade.h"
#include "cache/frame/method.h"
#include "cache/reflect/reflect.h"

typedef struct sl_octree_told {
    const sl_scene *scene;
    const sl_gbuffer *gbuffer;
    const sl_reflections *reflections; /* or NULL */
    sl_octree_shading shading;         /* texture NULL: indirect light is another's, as below */
    const char *otherwise;             /* what it is then */
    bool drawn, atlas;                 /* atlas: surfaces that are not glossy are lit from there */
} sl_octree_told;

/* Adds the terms of a pixel, row 0 at the bottom. */
void sl_octree_tell(const sl_octree_told *told, size_t pixel, sl_explanation_writer *writer);

/* These do nothing without an observer. */

/* Photons where they hit, some thousands of them. */
void sl_octree_announce_photons(sl_announcer *announcer, const sl_photon_list *photons);
/* Voxels' lights as arrows from their centroids towards where the light comes from, some thousands of them.
 */
void sl_octree_announce_lights(sl_announcer *announcer, const sl_octree *octree,
                               const sl_voxel_lights *lights);

#endif
