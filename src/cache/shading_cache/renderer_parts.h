/* Between the sample renderers (renderers.c): batches, what a request asks for, the environment's light. */
#ifndef SL_SHADING_CACHE_RENDERER_PARTS_H
#define SL_SHADING_CACHE_RENDERER_PARTS_H

#include "cache/light/light_sample.h"
#include "cache/shading_cache/renderers.h"
#include "trace/bsdf.h"

/* One request; worker < threads chooses scratch memory alone. */
typedef void sl_render_point(const void *state, const sl_sample_request *request, unsigned worker,
                             sl_sample *sample, sl_counters *counters);
void sl_render_each(sl_render_point *render, const void *state, size_t count,
                    const sl_sample_request *requests, unsigned threads, sl_sample *samples,
                    sl_counters *counters);
/* Position and normals are finite, and normals have a length. */
bool sl_request_is_sound(const sl_sample_request *request);
/* What is asked for: irradiance of materials that have a diffuse part, and of points without a material;
 * radiance of glossy lobes and of mirrors. */
bool sl_request_wants_irradiance(const sl_sample_request *request);
bool sl_request_wants_lobe(const sl_sample_request *request);
bool sl_request_wants_mirror(const sl_sample_request *request);
/* The lobe alone, ks = 1, seen from the eye; false where the eye is behind the surface. */
bool sl_request_lobe(const sl_sample_request *request, sl_bsdf *lobe);

sl_lit_point sl_request_lit_point(const sl_sample_request *request);
/* Adds the environment's direct light by so many directions (light/light_sample.h), and its variance. */
void sl_request_sky_light(const sl_renderer_settings *settings, const sl_sequence *sequence,
                          const sl_sample_request *request, int samples, sl_sample *sample,
                          sl_counters *counters);

#endif
