/* Direct light by shadow maps, as the paper's hardware had it:
 *   point and spot lights    a depth cube each
 *   directional lights       an orthographic depth map each, over the scene's box
 *   emissive triangles       a grid of point samples, a depth cube each (at half the size); at most 32 emitters
 *   environment              32 directional lights of equal power, a map each
 * Good for lights without extent; for the others a stated approximation, which rays do not need. */
#ifndef SL_CACHE_SHADOW_MAPS_H
#define SL_CACHE_SHADOW_MAPS_H

#include "raster/raster.h"

typedef struct sl_shadow_maps sl_shadow_maps;

/* size: texels a side of a map or of a cube's face. Scene and raster must outlive the maps. */
sl_status sl_shadow_maps_create(const sl_scene *scene, const sl_raster *raster, int size, unsigned threads,
                                sl_shadow_maps **maps, sl_counters *counters, sl_error *error);
void sl_shadow_maps_destroy(sl_shadow_maps *maps);
size_t sl_shadow_maps_bytes(const sl_shadow_maps *maps);

/* Irradiance from all lights at p, on the side of the unit geometric normal, for the unit shading normal n. */
sl_rgb sl_shadow_maps_irradiance(const sl_shadow_maps *maps, sl_vec3 p, sl_vec3 geometric_normal, sl_vec3 n,
                                 sl_counters *counters);
/* Light by light, for materials that reflect each in its own way: the unit direction to the light and what it adds to the
 * irradiance, shadowed. */
typedef void sl_shadow_map_visitor(void *context, sl_vec3 to_light, sl_rgb irradiance);
void sl_shadow_maps_each(const sl_shadow_maps *maps, sl_vec3 p, sl_vec3 geometric_normal, sl_vec3 n,
                         sl_shadow_map_visitor *visit, void *context, sl_counters *counters);

#endif
