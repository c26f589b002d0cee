/* Sample renderers: what computes shading at points. A renderer takes a batch as a pure function of (scene,
 * requests), so that other threads, or other processes, could compute it; the cache adds up what several of
 * them return for one point.
 *
 *   area_renderer.c            direct light (cache/light)
 *   bidirectional_renderer.c   indirect light (trace/bidirectional); direct light of the environment; all
 *                              that mirrors reflect
 *   caustic_renderer.c         caustics by photons (cache/photons)
 *   renderers.c                a batch of requests on the workers
 */
#pragma once

#include "cache/frame/settings.h"
#include "cache/patches/layers.h"

typedef struct sl_sample_request {
    sl_lit_point point;
    const sl_material *material;
    sl_vec3 eye;               /* for radiance */
    bool dense;                /* shadows' edges want SL_DENSE_POINTS on area lights */
    bool quick;                /* a quarter of the points on lights do: it will be asked for again */
    bool few_paths;            /* half of the paths do, likewise */
    bool radiance;             /* exitant radiance of the lobe is wanted too */
    /* which set of samples: 0, 1, ...; the same one gives the same bits for an unchanged scene */
    uint32_t set;
    unsigned layers;           /* SL_LAYER_ bits: renderers of other layers are not asked */
    bool passed_over;          /* nothing is asked: it is in the batch, which is the better for being large */
} sl_sample_request;

typedef struct sl_sample {
    sl_rgb irradiance;         /* W/m^2; 0 of materials without a diffuse part, where nobody needs it */
    sl_rgb radiance;           /* W/(m^2 sr), of the lobe alone (of a mirror: all of it), towards the eye */
    /* of the irradiance's channel mean, of this mean of samples; 0 where the renderer is exact */
    float variance;
    bool valid;                /* false: the point lies inside other geometry; no renderer is asked for it */
    bool broken;               /* it could not be computed, or is not finite: it says nothing */
} sl_sample;

typedef struct sl_sample_renderer {
    void *state;
    /* Before a batch of requests; NULL: there is nothing to be made. */
    void (*prepare)(void *state, size_t count, const sl_sample_request *requests);
    /* Answers one of them, whatever the others are; worker < threads chooses scratch memory alone. */
    void (*render)(const void *state, const sl_sample_request *request, unsigned worker, sl_sample *sample,
                   sl_counters *counters);
    /* More than the camera has changed; the tracer has been made anew where objects moved. */
    sl_status (*edit)(void *state, sl_error *error);
    void (*destroy)(void *state);
    /* Returns about how many rays a sample takes; NULL: none. */
    double (*rays)(const void *state);
    unsigned layer;            /* SL_LAYER_CHEAP or SL_LAYER_DEAR, as the cache has it */
} sl_sample_renderer;
/* samples[i] answers requests[i]; nothing of it depends on `threads` (settings' at most). One batch at a
 * time. */
void sl_render(const sl_sample_renderer *renderer, size_t count, const sl_sample_request *requests,
               unsigned threads, sl_sample *samples, sl_counters *counters);

/* tracer: where the caller keeps it; it may be made anew between batches. */
typedef struct sl_renderer_settings {
    const sl_scene *scene;
    const sl_tracer *const *tracer;
    sl_shading_cache_settings cache; /* complete */
    uint64_t seed;
    unsigned threads;
} sl_renderer_settings;

/* All vertices share their points on a light, so light is the same all over where the same of these are seen:
 * 64 points leave bands of 1/64 of it in a shadow's edge. They do not show between vertices some pixels
 * apart; the vertices of leaves as small as pixels have so many points there. */
#define SL_DENSE_POINTS 400
/* While things move light is not what it is for long: so small parts of the points and of the paths do,
 * everywhere. */
#define SL_QUICK_PART 4
#define SL_FEW_PATHS 2

/* Glossy surfaces without a diffuse part count as mirrors for caustics from this exponent on: half of the
 * lobe's peak is then within 7 degrees. */
#define SL_POLISHED 100.0f

sl_status sl_area_renderer(const sl_renderer_settings *settings, sl_sample_renderer *renderer,
                           sl_error *error);
sl_status sl_bidirectional_renderer(const sl_renderer_settings *settings, sl_sample_renderer *renderer,
                                    sl_error *error);
sl_status sl_caustic_renderer(const sl_renderer_settings *settings, sl_sample_renderer *renderer,
                              sl_error *error);

/* ---- what they share (renderers.c) ------------------------------------------------------------ */

/* Tells what is asked for: irradiance of materials that have a diffuse part, and of points without a
 * material; radiance of glossy lobes and of mirrors. */
bool sl_request_wants_irradiance(const sl_sample_request *request);
bool sl_request_wants_lobe(const sl_sample_request *request);
bool sl_request_wants_mirror(const sl_sample_request *request);
/* The lobe alone, ks = 1, seen from the eye; false where the eye is behind the surface. */
bool sl_request_lobe(const sl_sample_request *request, sl_bsdf *lobe);

/* Adds the environment's direct light by so many directions (light/light_sample.h), and its variance. */
void sl_request_sky_light(const sl_renderer_settings *settings, const sl_sequence *sequence,
                          const sl_sample_request *request, int samples, sl_sample *sample,
                          sl_counters *counters);
