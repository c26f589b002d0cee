/* Points of area lights that stand behind something: bars, jambs, a frame. */
#ifndef SL_CACHE_DIRECT_RADIANCE_LIGHT_OPENINGS_H
#define SL_CACHE_DIRECT_RADIANCE_LIGHT_OPENINGS_H

#include "cache/direct_radiance/lights.h"
#include "raster/raster.h"

/* What was found. */
typedef struct sl_light_openings {
    size_t points; /* of area lights */
    size_t moved;  /* to where light gets out */
    size_t shut;   /* light gets out nowhere in their cells */
} sl_light_openings;

/* (9) takes a cell of an area light for a point, which is wrong where something stands closer to the light than the cell is large: behind
 * a bar the point sees nothing, and the cell's light is gone. Where the point's view is not that of the cell (16 places in it tell, by a small
 * picture each), the point goes to the place whose view is most like it, and keeps of its intensity what brings its light to the cell's
 * mean. Where nothing is that close, which is the rule, points stay where they are, for the price of a picture of 16 x 16 each. */
sl_status sl_map_lights_find_openings(const sl_scene *scene, const sl_raster *raster, unsigned subdivision, unsigned threads,
                                      sl_map_lights *lights, sl_light_openings *found, sl_counters *counters, sl_error *error);

#endif
