/* Curved mirrors: an environment cube for each object of a mirror material that is not planar, taken from the middle of its box, the
 * object itself left out (pass 4). */
#ifndef SL_CACHE_DIRECT_RADIANCE_MIRRORS_H
#define SL_CACHE_DIRECT_RADIANCE_MIRRORS_H

#include "cache/direct_radiance/light_receivers.h"

typedef struct sl_curved_mirrors sl_curved_mirrors;

typedef struct sl_mirror_pass {
    const sl_scene *scene;
    const sl_raster *raster;
    const sl_mirrors *planar;
    const sl_light_pass *light;          /* how the cubes' faces are lit */
    int cube_size, reflections;
    int generations;                     /* 0: 1 */
    bool indirect;                       /* cubes hold indirect light */
} sl_mirror_pass;

/* Cubes of the curved mirrors that `seen` shows (NULL: of all), in scene order. Where there are none nothing is made, and *mirrors is NULL,
 * which all functions below take for none. Inside a cube the other curved mirrors show their cube of the generation before, and in
 * generation 0 k_s times the mean of the cube in which they are seen; so do planar mirrors beyond the nesting limit. */
sl_status sl_curved_mirrors_render(const sl_mirror_pass *pass, const sl_receivers *seen, sl_curved_mirrors **mirrors, sl_counters *counters,
                                   sl_error *error);
void sl_curved_mirrors_destroy(sl_curved_mirrors *mirrors);
size_t sl_curved_mirrors_bytes(const sl_curved_mirrors *mirrors);
/* Adds, at the pixels of curved mirrors, k_s times what their cubes hold along the reflected eye vector: emission, direct and indirect light
 * apart, three planes each; before the planar mirrors' throughput. */
void sl_curved_mirrors_reflect(const sl_curved_mirrors *mirrors, const sl_receivers *receivers, unsigned threads, float *const emission[3],
                               float *const direct[3], float *const indirect[3], sl_counters *counters);

/* The trick (SL_MIRROR_LIGHT_TRICK): the indirect light that is missing in a cube is k_s (rho / pi) E at the reflected point. A
 * curved mirror that receives it as if it were diffuse takes k_s times the mean diffuse albedo, by area, of all that is no mirror: this one. */
sl_rgb sl_trick_albedo(const sl_scene *scene);

#endif
