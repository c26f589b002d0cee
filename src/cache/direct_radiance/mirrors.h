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
    bool indirect;                       /* cubes hold indirect light */
} sl_mirror_pass;

/* Cubes of the curved mirrors that `seen` (per object, or NULL: all) names, in scene order; inside a cube the other curved mirrors show their
 * cube of the generation before, and in generation 0 k_s times the cube's mean. */
sl_status sl_curved_mirrors_render(const sl_mirror_pass *pass, const sl_receivers *seen, sl_curved_mirrors **mirrors, sl_counters *counters,
                                   sl_error *error);
void sl_curved_mirrors_destroy(sl_curved_mirrors *mirrors);
size_t sl_curved_mirrors_bytes(const sl_curved_mirrors *mirrors);
/* Adds, at the pixels of curved mirrors, k_s times what their cubes hold along the reflected eye vector: emission, direct and indirect light
 * apart, three planes each. */
void sl_curved_mirrors_reflect(const sl_curved_mirrors *mirrors, const sl_receivers *receivers, unsigned threads, float *const emission[3],
                               float *const direct[3], float *const indirect[3], sl_counters *counters);

#endif
