/* Light seen directly: emitters' shining sides, and the environment where nothing stands before it. */
#ifndef SL_CACHE_DIRECT_RADIANCE_EMISSION_H
#define SL_CACHE_DIRECT_RADIANCE_EMISSION_H

#include "cache/direct_radiance/receivers.h"

/* Adds to three planes. view: what receivers were rendered with (for the background's directions, path by path). */
void sl_add_emission(const sl_scene *scene, const sl_receivers *receivers, const sl_view *view, unsigned threads, float *const emission[3],
                     sl_counters *counters);

#endif
