/* Light seen directly: emitters' shining sides, and the environment where nothing stands before it. */
#ifndef SL_CACHE_DIRECT_RADIANCE_EMISSION_H
#define SL_CACHE_DIRECT_RADIANCE_EMISSION_H

#include "cache/direct_radiance/receivers.h"

/* Adds to three planes, before the mirrors' throughput: L_e on the shining side of emitters; the environment in each background pixel's
 * direction, which is that of its own path; and k_s times the environment's mean where a planar mirror lies beyond the nesting limit. */
void sl_add_emission(const sl_scene *scene, const sl_receivers *receivers, unsigned threads, float *const emission[3], sl_counters *counters);
/* The same row by row: what is found out once for a picture, and row y of the receivers that it is given, which may be some rows of it. */
typedef struct sl_emission {
    const sl_scene *scene;
    sl_rgb mean;  /* of the environment, where it is wanted */
    bool none;    /* nothing shines */
} sl_emission;
sl_emission sl_emission_of(const sl_scene *scene, const sl_receivers *picture);
/* Returns whether anything was added. */
bool sl_emission_add_row(const sl_emission *e, const sl_receivers *receivers, size_t y, float *const emission[3]);
/* Mean radiance of the environment over all directions; black where there is none. */
sl_rgb sl_environment_mean(const sl_environment *environment);

#endif
