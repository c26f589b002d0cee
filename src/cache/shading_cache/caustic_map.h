/* The caustics' photon map (Jensen 1996): photons that came by way of specular surfaces alone and met something diffuse.
 *
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
    sl_caustic_photon *photon; /* the tree: of each range its median comes in the middle, the lower half before it */
    size_t count, emitted;
} sl_caustic_map;

/* Does a material pass caustics on? Mirrors, and lobes as narrow as SL_POLISHED without a diffuse part. */
bool sl_material_is_specular(const sl_material *material);
/* No photons where nothing is specular, or nothing specular is lit. */
sl_status sl_caustic_map_make(const sl_renderer_settings *settings, sl_caustic_map *map, sl_error *error);
void sl_caustic_map_release(sl_caustic_map *map);

/* Puts the photons in tree order. */
void sl_caustic_tree_build(sl_caustic_photon *photon, size_t count);

enum { SL_CAUSTIC_NEIGHBOURS = 201 }; /* the farthest of them gives the radius and has no weight */
typedef struct sl_near_photon {
    double squared;            /* distance, flattened: what is off the tangent plane counts FLATNESS times as far */
    uint32_t place;            /* in the map */
} sl_near_photon;
/* The nearest photons on surfaces that face as the point's does, at most so far; a heap with the farthest first. Returns how many. */
size_t sl_caustic_nearest(const sl_caustic_map *map, sl_vec3 position, sl_vec3 normal, double radius, sl_near_photon near[SL_CAUSTIC_NEIGHBOURS]);

#endif
