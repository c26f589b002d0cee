/* The caustics' photon map (Jensen 1996): photons that came by way of specular surfaces alone and met
 * something diffuse.
 *
 *   caustic_aim.c       which way photons are sent (Jensen's projection map)
 *   caustic_photons.c   light subpaths of trace/bidirectional up to the first surface that is not specular
 *   caustic_tree.c      a balanced kd-tree, implicit in the photons' order; the k nearest of a point */
#ifndef SL_SHADING_CACHE_CAUSTIC_MAP_H
#define SL_SHADING_CACHE_CAUSTIC_MAP_H

#include "cache/shading_cache/renderers.h"

typedef struct sl_caustic_photon {
    sl_vec3 position;
    sl_vec3 to_light;          /* unit: where it came from */
    sl_vec3 normal;            /* unit, geometric, of the side that it met */
    sl_rgb flux;               /* W */
    uint32_t id;               /* in the order of emission */
    uint8_t axis;              /* in the tree: that splits what is below */
} sl_caustic_photon;

typedef struct sl_caustic_map {
    /* the tree: of each range its median comes in the middle, the lower half before it */
    sl_caustic_photon *photon;
    size_t count, emitted;
} sl_caustic_map;

/* Does a material pass caustics on? Mirrors, and lobes as narrow as SL_POLISHED without a diffuse part. */
bool sl_material_is_specular(const sl_material *material);
/* No photons where nothing is specular, or nothing specular is lit. */
sl_status sl_caustic_map_make(const sl_renderer_settings *settings, sl_caustic_map *map, sl_error *error);
void sl_caustic_map_release(sl_caustic_map *map);

/* Cells of the two numbers that choose a photon's direction, for each light (the sampler's entries; many
 * share SL_AIM_LIGHTS tables). */
enum {
    SL_AIM_LIGHTS = 64,
    SL_AIM_CELLS = 32,
    SL_AIM_PLANE = SL_AIM_CELLS * SL_AIM_CELLS,
    SL_AIM_ALL = SL_AIM_LIGHTS * SL_AIM_PLANE
};
typedef struct sl_caustic_aim {
    float row_sums[SL_AIM_LIGHTS][SL_AIM_CELLS + 1]; /* from 0 to 1 */
    float column_sums[SL_AIM_LIGHTS][SL_AIM_CELLS][SL_AIM_CELLS + 1];
    float weight[SL_AIM_ALL];                        /* 1 / density */
} sl_caustic_aim;
uint32_t sl_aim_cell(uint32_t light, const float whither[3]);
/* hits: of the photons of an even emission those that ended in a caustic, by cell. A quarter of all goes
 * everywhere, so that nothing is missed. */
void sl_caustic_aim_make(const double hits[SL_AIM_ALL], sl_caustic_aim *aim);
/* Moves the numbers; returns 1 / density. */
float sl_caustic_aim_warp(const sl_caustic_aim *aim, uint32_t light, float whither[3]);

/* Puts the photons in tree order. */
void sl_caustic_tree_build(sl_caustic_photon *photon, size_t count);

enum { SL_CAUSTIC_NEIGHBOURS = 201 }; /* the farthest of them gives the radius and has no weight */
typedef struct sl_near_photon {
    /* distance, flattened: what is off the tangent plane counts FLATNESS times as far */
    double squared;
    uint32_t place;            /* in the map */
} sl_near_photon;
/* The nearest photons on surfaces that face as the point's does, at most so far; a heap with the farthest
 * first. Returns how many. */
size_t sl_caustic_nearest(const sl_caustic_map *map, sl_vec3 position, sl_vec3 normal, double radius,
                          sl_near_photon near[SL_CAUSTIC_NEIGHBOURS]);

#endif
