/* Passes 5 to 8 strip by strip (strips.c). */
#ifndef SL_CACHE_DIRECT_RADIANCE_STRIPS_H
#define SL_CACHE_DIRECT_RADIANCE_STRIPS_H

#include "cache/direct_radiance/light_receivers.h"
#include "cache/direct_radiance/mirrors.h"

typedef struct sl_strip_pass {
    const sl_raster *raster;
    const sl_receivers *outline;  /* sl_receivers_outline() */
    const sl_light_pass *light;   /* without visibility */
    const sl_curved_mirrors *curved; /* or NULL */
    bool direct;                  /* there are receivers and lights */
    bool layers;                  /* wanted, besides R, G, B */
} sl_strip_pass;

/* The same picture and the same costs as sl_raster_resolve(), sl_add_emission(), sl_light_directly(), sl_light_indirectly(),
 * sl_curved_mirrors_reflect() and sl_radiance_compose() one after another. */
sl_status sl_radiance_draw_strips(const sl_strip_pass *pass, sl_image **image, sl_counters *counters, sl_error *error);

#endif
