/* Curved mirrors in a light's view: no picture shows what lies at the end of such a way, so it is traced. */
#ifndef SL_CACHE_DIRECT_RADIANCE_MAP_TRACED_H
#define SL_CACHE_DIRECT_RADIANCE_MAP_TRACED_H

#include "cache/direct_radiance/map_pictures.h"

/* Texels that show a mirror which is no planar one are given what their ray meets by way of mirrors: its end point, the light that
 * arrives there, and the area over which the texel's light is spread. Needs options->tracer, and the map's planes for it. */
sl_status sl_map_trace_mirrors(const sl_map_drawing *drawing, sl_error *error);

#endif
