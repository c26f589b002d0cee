/* The light octree (Vivanloc, Hoelt, Hong, Paulin 2007): a photon map condensed, voxel by voxel, into a few
 * directional lights, which shaders then use like any others. Passes have names here: G what is made from
 * geometry, P from photons, R what renders. Read in this order:
 *
 *   plan.c            which passes a scene needs
 *   passes.c          the passes of one picture, one after another; state.h: what is between them
 *   light_octree.c    what a method holds of that, and what edits leave; report.c: what is said of it
 *
 *   ../photons/       P1: photon tracing, from all lights; P2: the kd-tree, and the k nearest photons
 *   octree.c          G1: the voxels, on geometry; triangle_cells.c, coplanar.c; octree_cuts.c: a shallower
 * one voxel_gather.c    P3: a voxel's photons, and over which area they were strewn: photon_area.c exactly,
 * surroundings.c for all triangles, photon_hull.c without those that no photon met own_photons.c     P3
 * without a search: the photons in the voxel voxel_error.c     P3: how many photons, by an estimate of the
 * error cluster.c         P4: K-means on their directions voxel_lobes.c     P4: what each cluster's colour
 * means voxel_lights.c    P3 and P4 for every voxel; voxel_sets.c, normal_groups.c: several sets of lights in
 * a voxel direction_packing.c, voxel_texture.c   P5: all of it in textures, as the hardware holds it shade.c
 * R1: surface points lit from the octree atlas/            G2 to G4, R1' and R2: the same by way of a texture
 * atlas pixels.c          which pixels go which way
 *   ../reflect/       what mirrors show
 *   compose.c         the picture and its layers
 *   explanation.c           a picture told backwards, pixel by pixel; what can be seen of photons and lights
 *   direct_photons.c  the photon map shown as it is: what the octree is compared with
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
