/* The light octree (Vivanloc, Hoelt, Hong, Paulin 2007): a photon map condensed, voxel by voxel, into a few
 * directional lights, which shaders then use like any others.
 *
 *   light_octree.c    the paper: one picture, step by step; state.h: what is between the steps
 *   method.c          what a method holds of that, what edits leave, direct light; plan.c: which passes a
 * scene needs; picture.c: a picture's layers, and what is said of it
 *   ../photons/       photon tracing, the kd-tree, and the k nearest photons
 *   octree.c          the voxels, on geometry; triangle_cells.c, coplanar.c
 *   voxel_gather.c    a voxel's photons; own_photons.c: those in it, without a
 * search photon_area.c     the area that they were strewn over; surroundings.c: of all triangles around;
 *                     photon_hull.c: without what no photon met
 *   cluster.c         K-means on their directions; voxel_lobes.c: from clusters to lights
 *   voxel_lights.c    the lights of every voxel; voxel_sets.c, normal_groups.c: several sets in a voxel
 *   voxel_texture.c   all of it in textures, as the hardware holds it; direction_packing.c
 *   shade.c           surface points lit from the octree; pixels.c: which pixels go which way
 *   atlas/            the same by way of a texture atlas
 *   ../reflect/       what mirrors show
 *   explanation.c     what made a pixel; what can be seen of photons and lights
 *   photon_pixels.c   the photon map shown as it is: what the octree is compared with
 */
#ifndef SL_CACHE_LIGHT_OCTREE_H
#define SL_CACHE_LIGHT_OCTREE_H

#include "cache/light/direct.h"
#include "cache/light_octree/pixels.h"
#include "cache/light_octree/plan.h"
#include "cache/reflect/reflect.h"
#include "cache/light_octree/shade.h"
#include "cache/light_octree/voxel_lights.h"

/* Of completed settings; radius: theirs, or that of the octree's density. */
sl_voxel_light_options sl_octree_light_options(const sl_light_octree_settings *settings, double radius);

sl_octree_shading sl_octree_shading_of(const sl_light_octree_settings *settings,
                                       const sl_voxel_texture *texture);

/* What a picture is made of; planes of the G-buffer's size, row 0 at the bottom. */
typedef struct sl_octree_composition {
    const sl_scene *scene;
    const sl_gbuffer *gbuffer;
    const sl_reflections *reflections; /* or NULL */
    const float *direct[3], *indirect[3];
    bool drawn;                        /* the G-buffer holds this view */
    unsigned threads;
} sl_octree_composition;

/* R, G, B = emission + direct + indirect, and each of the three alone, mirrors' reflectances included; top
 * row first. */
sl_status sl_octree_compose(const sl_octree_composition *parts, sl_image **image, sl_error *error);

#endif
