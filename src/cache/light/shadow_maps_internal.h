/* Shared by the making of shadow maps and their use. */
#ifndef SL_CACHE_LIGHT_SHADOW_MAPS_INTERNAL_H
#define SL_CACHE_LIGHT_SHADOW_MAPS_INTERNAL_H

#include "cache/light/depth_cube.h"
#include "cache/light/shadow_maps.h"

/* A light without extent, or a sample of one with extent, and its map. */
typedef struct sl_mapped_source {
    sl_light_source source;
    sl_depth_cube cube;
    unsigned part;
} sl_mapped_source;

/* A side of an emissive triangle, and its samples among the sources. */
typedef struct sl_mapped_emitter {
    sl_polygon_light polygon;
    sl_rgb radiance;
    size_t first, count;
} sl_mapped_emitter;

struct sl_shadow_maps {
    const sl_scene *scene;
    sl_shadow_map_settings settings;
    sl_isa isa;
    float offset;
    /* the first plain_count sources are no samples of emitters */
    size_t source_count, emitter_count, plain_count, capacity;
    sl_mapped_source *sources;
    sl_mapped_emitter *emitters;
};

#endif
