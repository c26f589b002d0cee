/* Where photons start: a light is chosen in proportion to its luminous power, and a ray leaves it as its
 * light does, so that all photons carry about the same power.
 *
 *   point         all directions alike
 *   spot          its cone, and the smooth edge by inverting the edge's own distribution
 *   directional   enters the scene's box through the faces that it lights
 *   emissive      uniform on the triangle, cosine law about its normal; either side where two-sided
 *   environment   directions by its sampling tables, then as directional
 *
 * The paper speaks of none but point and area lights. Parallel light needs a cross-section to be measured on:
 * the scene's box as that light sees it (often it is the bounding sphere's disc, of which the box fills
 * little more than half). */
#ifndef SL_CACHE_PHOTONS_PHOTON_EMISSION_H
#define SL_CACHE_PHOTONS_PHOTON_EMISSION_H

#include "scene/scene.h"

typedef struct sl_photon_sources sl_photon_sources;

sl_status sl_photon_sources_create(const sl_scene *scene, sl_photon_sources **sources, sl_error *error);
void sl_photon_sources_destroy(sl_photon_sources *sources);
/* Luminance, W, of all lights together; 0: there is none. */
double sl_photon_sources_power(const sl_photon_sources *sources);

enum { SL_EMISSION_NUMBERS = 5 }; /* random numbers for one ray */

typedef struct sl_emitted_photon {
    sl_vec3 origin, direction; /* unit */
    sl_rgb flux;               /* W: if it were the only one */
    uint32_t triangle;         /* that it leaves, or SL_NO_INDEX */
    bool parallel;             /* of a directional light or the environment */
    bool environment;
} sl_emitted_photon;

/* select in [0,1) decides the light: evenly spread numbers give each its share. False: nothing leaves there
 * (an alpha mask). */
bool sl_photon_emit(const sl_photon_sources *sources, double select, const float number[SL_EMISSION_NUMBERS],
                    sl_emitted_photon *photon);

#endif
