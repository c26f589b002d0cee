/* Where light starts, for photons and for light subpaths.
 *
 *   emissive      uniform on the triangle, cosine law about its normal; either side where two-sided
 *   point         all directions alike
 *   spot          its cone, and the smooth edge by inverting the edge's own distribution
 *   directional   enters the scene's box through the faces that it lights
 *   environment   directions by its sampling tables, then as directional
 *
 * So what a light sends carries about the same power everywhere. Parallel light needs a cross-section to be
 * measured on: the scene's box as that light sees it, which fills little more than half of the disc of the
 * bounding sphere. */
#pragma once

#include "scene/scene.h"

enum { SL_EMISSION_NUMBERS = 5 }; /* random numbers for one ray: the first two decide the direction */

typedef struct sl_emission {
    sl_vec3 origin, direction; /* unit */
    sl_vec3 normal;            /* of the surface that it leaves; of parallel light, the way it goes */
    sl_rgb flux;               /* of the whole light, times `scale` */
    double pdf;                /* of the direction per solid angle; parallel: per area that faces it */
    double origin_pdf;         /* emissive: per area; environment: of the direction; else 1 */
    uint32_t triangle;         /* that it leaves, or SL_NO_INDEX */
    bool parallel;             /* of a directional light or the environment */
    bool environment;
} sl_emission;

/* entry: of the light sampler, emitters first, then lights, then the environment. False: nothing leaves there
 * (an alpha mask). */
bool sl_light_emit(const sl_scene *scene, uint32_t entry, const float number[SL_EMISSION_NUMBERS],
                   double scale, sl_emission *emission);
/* Luminance of the whole light, W; parallel light counts what enters the scene's box. */
double sl_light_power(const sl_scene *scene, uint32_t entry);
/* Density per solid angle of a point light's directions, or a spot's, at this cosine with its axis. */
double sl_cone_pdf(const sl_light *light, float cosine);
/* Area of the scene's box as parallel light of that direction sees it. */
double sl_seen_area(const sl_scene *scene, sl_vec3 direction);
