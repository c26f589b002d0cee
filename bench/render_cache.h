/* The rival of the shading cache: the RenderCache (Walter, Drettakis, Parker 1999), on the same sample
 * renderers. It keeps shaded points instead of shaded patches, throws them at each new frame's pixels, and
 * fills the gaps.
 *
 *   one frame:  project ── z-buffer ── depth cull ── 3x3 fill ── picture
 *                                          └── priorities ── error diffusion ── samples ── into the cache
 *
 * Points lie on triangles, by barycentric weights: where objects move they go along. */
#pragma once

#include "cache/shading_cache/renderers.h"

typedef struct render_cache render_cache;

typedef struct render_cache_settings {
    const sl_scene *scene;
    const sl_tracer *const *tracer;     /* where the caller keeps it, made anew by him where objects move */
    const sl_sample_renderer *renderer; /* `renderers` of them: what they return is added up */
    int renderers;
    int width, height;
    int samples;                        /* rays a frame */
    unsigned threads;
    uint64_t seed;
} render_cache_settings;

/* Ends the program where there is no memory. */
render_cache *render_cache_create(const render_cache_settings *settings);
void render_cache_destroy(render_cache *cache);
/* The scene has changed, as told to sl_method_edit(). */
void render_cache_edit(render_cache *cache, unsigned changes);
/* One frame from where everything stands now; then its samples, which the next one shows. */
void render_cache_frame(render_cache *cache, sl_counters *counters);
/* Makes the picture of what the cache holds, without another sample. wide_fill: gaps wider than 3x3 are
 * filled from coarser and coarser averages (as its second version, Walter et al. 2002, does at one coarser
 * level); else they show what they showed before. */
void render_cache_show(render_cache *cache, bool wide_fill);
/* No cache at all: what the renderers say of pixels' centres, 3 values each. Of the settings samples and
 * points do not matter. */
void render_cache_reference(const render_cache_settings *settings, size_t count, const uint32_t *pixels,
                            float *values);
/* Radiance of the last frame: three planes, row 0 at the top. */
const float *render_cache_picture(const render_cache *cache);
/* Of all frames together. */
uint64_t render_cache_samples(const render_cache *cache);
