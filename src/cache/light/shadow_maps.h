/* Direct light by shadow maps, as the paper's hardware had it, for pixels and for what gathers see:
 *
 *   point and spot lights    a cube of six maps each
 *   directional lights       a map each, over the scene's box
 *   emissive triangles       32 point samples among all of them, by power and at least one each, with a
 *                            small cube each. The light itself is exact (Lambert's formula); the samples
 *                            tell which share of it arrives
 *   environment              sun and sky as directional lights of equal power, 8 and 32, a map each
 *
 * Read in this order:
 *   shadow_maps.c        making the maps
 *   shadow_map_light.c   lighting points, a block at a time
 *   depth_cube.c         the pictures around a light
 *   depth_cube_kernels.c what a cube says of a point
 *   light_kernels.c      Lambert's formula
 */
#pragma once

#include "cache/light/light_kernels.h"
#include "raster/raster.h"

typedef struct sl_shadow_maps sl_shadow_maps;

typedef struct sl_shadow_map_settings {
    int size;         /* texels a side of a map or of a cube's face; the sky has half */
    int emitter_size; /* of samples of emitters; 0: a quarter */
    const sl_environment *sun; /* part of SL_MAPPED_LIGHTS; or NULL */
    const sl_environment *sky; /* is SL_MAPPED_SKY; or NULL */
    unsigned threads;
} sl_shadow_map_settings;

/* More sides of emissive triangles than that are too many for maps. */
enum { SL_SHADOW_MAP_SIZE = 1024, SL_SHADOW_MAP_SIDES_MAX = 64 };

/* Scene and raster must outlive the maps; lights and geometry are those of now. */
sl_status sl_shadow_maps_create(const sl_scene *scene, const sl_raster *raster,
                                const sl_shadow_map_settings *settings, sl_shadow_maps **maps,
                                sl_counters *counters, sl_error *error);
void sl_shadow_maps_destroy(sl_shadow_maps *maps);
size_t sl_shadow_maps_bytes(const sl_shadow_maps *maps);

enum {
    SL_MAPPED_LIGHTS = 1,
    SL_MAPPED_SKY = 2,
    SL_MAPPED_FEW = 4, /* the first quarter of an emitter's samples does: for gathers, which see thousands of
                          points each */
    SL_MAPPED_TILE = 8, /* the block are tiles of a picture, part by part */
    SL_MAPPED_INTERLEAVED = 16 /* ... without gaps: neighbours share the first half of an emitter's samples */
};

/* Points a row of a part of a tile, and of the part. */
enum { SL_MAPPED_COLUMNS = 8, SL_MAPPED_PART = 32 };

/* Irradiance of one block of points from all lights of the parts: adds to r, g, b. */
void sl_shadow_maps_irradiance(const sl_shadow_maps *maps, const sl_light_points *points, unsigned parts,
                               float *r, float *g, float *b, sl_counters *counters);

/* Light by light, for materials that reflect each in its own way; emitters are their samples. What arrives at
 * point i is the irradiance colour x arrivals->weight[i] x lit[i]. */
typedef void sl_shadow_map_visitor(void *context, const sl_arrivals *arrivals, const float *lit,
                                   sl_rgb colour);
void sl_shadow_maps_each(const sl_shadow_maps *maps, const sl_light_points *points, unsigned parts,
                         sl_shadow_map_visitor *visit, void *context, sl_counters *counters);
