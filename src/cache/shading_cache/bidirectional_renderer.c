/* Indirect light by bidirectional path tracing (trace/bidirectional): light of all paths with something
 * between light and point.
 *
 * Who counts what, beside area_renderer.c:
 *   the environment seen from the point     here, among the paths that leave the scene
 *   lamps that a mirror at the point shows  here: a mirror reflects all there is
 *   caustics at diffuse points, L S+ D      here, or, where settings ask for a caustic renderer, there alone.
 * S: mirrors, and surfaces without diffuse part whose lobe is at least as narrow as SL_POLISHED. What a
 * mirror shows of a caustic, or light that goes on from one, or the lobe's part of it, is here in any case
 *
 * Set k of samples takes the next N pairs of subpaths of one sequence. Light subpaths serve all points and
 * are walked once a set, when the first request asks for it. */
#include <math.h>

#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "cache/shading_cache/renderers.h"
#include "trace/bidirectional/bidirectional.h"

/* Sets that are kept; more begin again. */
enum { SETS_MAX = 256 };

typedef struct sets {
    sl_bidirectional_points *points[SETS_MAX];
} sets;

typedef struct renderer {
    sl_renderer_settings settings;
    sets *sets;
    sl_bidirectional_scratch **scratch; /* by worker */
    unsigned workers;
    sl_sequence sequence;
} renderer;

static sl_status make_set(const renderer *r, uint32_t set, sl_error *error) {
    const sl_shading_cache_settings *cache = &r->settings.cache;
    if (r->sets->points[set]) return SL_OK;
    const sl_bidirectional_point_settings settings = {.samples = (uint32_t)cache->indirect_samples,
                                                      .first = set * (uint32_t)cache->indirect_samples,
                                                      .bounces = (uint32_t)cache->path_depth,
                                                      .seed = r->settings.seed,
                                                      .without_caustics = cache->caustics,
                                                      .polished = SL_POLISHED};
    return sl_bidirectional_points_create(r->settings.scene, *r->settings.tracer, &settings,
                                          &r->sets->points[set], error);
}

static void forget_sets(renderer *r) {
    for (uint32_t s = 0; s < SETS_MAX; s++) {
        sl_bidirectional_points_destroy(r->sets->points[s]);
        r->sets->points[s] = NULL;
    }
}

/* ---- at a point ------------------------------------------------------------------------------ */

/* Of the channels' mean, as if they varied together: never less than it is. */
static float mean_variance(const double v[3]) {
    double deviation = (sqrt(v[0]) + sqrt(v[1]) + sqrt(v[2])) / 3.0;
    return (float)(deviation * deviation);
}

static uint32_t paths_of(const renderer *r, const sl_sample_request *q) {
    const uint32_t paths = (uint32_t)r->settings.cache.indirect_samples;
    return q->few_paths ? (paths + SL_FEW_PATHS - 1) / SL_FEW_PATHS : paths;
}

static void render_point(const void *state, const sl_sample_request *q, unsigned worker, sl_sample *sample,
                         sl_counters *counters) {
    const renderer *r = state;
    const sl_bidirectional_points *points = r->sets->points[q->set % SETS_MAX];
    bool irradiance = sl_request_wants_irradiance(q), lobe = sl_request_wants_lobe(q),
         mirror = sl_request_wants_mirror(q);
    if (!points) { /* no memory for it */
        *sample = (sl_sample){.broken = true};
        return;
    }
    const sl_bidirectional_request request = {q->point.position, q->point.geometric_normal, q->point.normal,
                                              q->point.triangle, q->material, paths_of(r, q)};
    sl_bidirectional_value value;
    if (irradiance) {
        sl_bidirectional_irradiance(points, &request, r->scratch[worker], &value, counters);
        sample->irradiance = sl_sum_over(value.mean, 1.0);
        sample->variance = mean_variance(value.variance);
        sl_count(counters, SL_COUNT_INDIRECT_SAMPLES, 1);
    }
    if (lobe || mirror) {
        sl_bidirectional_radiance(points, &request, q->eye, r->scratch[worker], &value, counters);
        sample->radiance = sl_sum_over(value.mean, 1.0);
        sl_count(counters, SL_COUNT_INDIRECT_SAMPLES, 1);
    }
    if (irradiance || lobe)
        sl_request_sky_light(&r->settings, &r->sequence, q, (int)paths_of(r, q), sample, counters);
}

/* ---- the renderer ---------------------------------------------------------------------------- */

static void prepare(void *state, size_t count, const sl_sample_request *requests) {
    for (size_t i = 0; i < count; i++)
        if (!requests[i].passed_over) make_set(state, requests[i].set % SETS_MAX, NULL);
}

/* The first set is made at once, so that what fails fails here. */
static sl_status edit(void *state, sl_error *error) {
    renderer *r = state;
    forget_sets(r);
    return make_set(r, 0, error);
}

static void destroy(void *state) {
    renderer *r = state;
    if (!r) return;
    if (r->sets) forget_sets(r);
    for (unsigned w = 0; r->scratch && w < r->workers; w++) sl_bidirectional_scratch_destroy(r->scratch[w]);
    SL_FREE_ALL(r->scratch, r->sets, r);
}

static sl_status make(renderer *r, sl_error *error) {
    r->workers = r->settings.threads > 0 ? r->settings.threads : 1;
    r->sets = sl_allocate(1, sizeof *r->sets);
    r->scratch = sl_allocate(r->workers, sizeof *r->scratch);
    if (!r->sets || !r->scratch) return sl_fail_memory(error, "a sample renderer");
    sl_status status = SL_OK;
    for (unsigned w = 0; w < r->workers && status == SL_OK; w++)
        status = sl_bidirectional_scratch_create(&r->scratch[w], error);
    return status == SL_OK ? make_set(r, 0, error) : status;
}

/* Measured: 6 to 9 rays a path, vertices on the way joined to lights and to each other. */
static double rays(const void *state) {
    return 8.0 * (double)((const renderer *)state)->settings.cache.indirect_samples;
}

sl_status sl_bidirectional_renderer(const sl_renderer_settings *settings, sl_sample_renderer *out,
                                    sl_error *error) {
    *out = (sl_sample_renderer){
        .prepare = prepare, .render = render_point, .edit = edit, .destroy = destroy, .rays = rays};
    renderer *r = sl_allocate(1, sizeof *r);
    if (!r) return sl_fail_memory(error, "a sample renderer");
    r->settings = *settings;
    sl_sequence_make(&r->sequence);
    sl_status status = make(r, error);
    if (status == SL_OK) out->state = r;
    else destroy(r);
    return status;
}
