/* Direct light, by src/cache/light. An area light's irradiance without occluders is known in closed form
 * (Lambert's formula); N points spread over the light tell what share of it is seen:
 *
 *     E = E_closed  sum w_i V_i / sum w_i,   w = (n . w)+ (-m . w)+ / r^2,
 *
 * so that noise is left where there are shadows alone. Or by the points alone, as the paper has it: E = L A /
 * N sum w_i V_i. Lights without extent take a shadow ray. Every vertex uses the same points: vertices under
 * the same light have the same error, and an unchanged scene unchanged bits.
 *
 * Who counts what: lamps and lights as seen from the point are counted here and nowhere else, by its diffuse
 * part and by its glossy lobe. Mirrors reflect lamps as well as all else by bidirectional_renderer.c. So does
 * the environment shine, which is counted here only where no renderer of indirect light is wanted. */
#include "base/error.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/shading_cache/renderers.h"

typedef struct area_renderer {
    sl_renderer_settings settings;
    sl_sampled_lights *lights;
    sl_light_sampling *sampling;
    sl_sequence sequence;
} area_renderer;

/* ---- at a point ------------------------------------------------------------------------------ */

typedef struct lit {
    const area_renderer *renderer;
    const sl_sample_request *request;
    sl_lit_lobe lobe;
    bool has_lobe;
    sl_counters *counters;
} lit;

static sl_light_numbers numbers_of(const area_renderer *r, uint64_t stream, uint32_t first, uint32_t count) {
    return (sl_light_numbers){&r->sequence, sl_random_key(r->settings.seed, stream), first, count};
}

static uint32_t points_of(const area_renderer *r, const sl_sample_request *request) {
    const uint32_t points = (uint32_t)r->settings.cache.area_samples;
    return request->quick ? (points + SL_QUICK_PART - 1) / SL_QUICK_PART : points;
}

static void add(sl_rgb *to, sl_rgb colour, double scale) {
    *to = sl_rgb_add(*to, (sl_rgb){(float)((double)colour.r * scale), (float)((double)colour.g * scale),
                                   (float)((double)colour.b * scale)});
}

static void add_reflected(const lit *at, sl_rgb light, double share, sl_sample *sample) {
    if (at->has_lobe) add(&sample->radiance, sl_rgb_mul(light, at->request->material->specular), share);
}

/* ---- area lights ----------------------------------------------------------------------------- */

/* Return the variance of the mean: of a ratio of sums, and of a mean. */
static double ratio_variance(const sl_light_sums *s, double n) {
    double share = s->seen / s->all, hidden = fmax(s->all_squares - s->seen_squares, 0.0);
    double squares = s->seen_squares * (1.0 - share) * (1.0 - share) + hidden * share * share;
    return n > 1.0 ? squares / (s->all * s->all) * n / (n - 1.0) : 0.0;
}

static double mean_variance(const sl_light_sums *s, double n) {
    return n > 1.0 ? fmax(s->seen_squares - s->seen * s->seen / n, 0.0) / (n * (n - 1.0)) : 0.0;
}

/* Goes on with the first set until its points are dense, where there is an edge of a shadow, or where the
 * closed form does not smooth what is lit all over. Lobes have their part from the points before, with
 * which their densities reckon. Returns how many points there are. */
static uint32_t add_dense_points(const lit *at, size_t l, uint32_t points, sl_light_sums *s) {
    const area_renderer *r = at->renderer;
    const bool edge = (s->seen > 0.0 && s->seen < s->all) || r->settings.cache.area == SL_AREA_SAMPLED,
               dense = at->request->dense && !at->request->quick;
    if (!dense || at->request->set > 0 || points >= SL_DENSE_POINTS || !edge) return points;
    sl_light_numbers more = numbers_of(r, l, points, SL_DENSE_POINTS - points);
    sl_light_by_points(r->sampling, l, &at->request->point, &more, NULL, s, at->counters);
    return SL_DENSE_POINTS;
}

/* Adds its light. Where little of it is above the horizon none of the points may be: one ray to its middle
 * then. */
static void add_area_light(const lit *at, size_t l, sl_sample *sample) {
    const area_renderer *r = at->renderer;
    const sl_sampled_light *light = &r->lights->light[l];
    const uint32_t points = points_of(r, at->request);
    sl_light_numbers numbers = numbers_of(r, l, at->request->set * points, points);
    sl_light_sums s = {.all = 0.0};
    const sl_lit_lobe *lobe = at->has_lobe ? &at->lobe : NULL;
    double form = sl_light_by_points(r->sampling, l, &at->request->point, &numbers, lobe, &s, at->counters);
    if (!(form > 0.0)) return;
    double n = (double)add_dense_points(at, l, points, &s), e = s.seen / n, variance = mean_variance(&s, n);
    if (r->settings.cache.area == SL_AREA_RATIO) {
        bool weighed = s.all > 0.0;
        e = weighed ? form * (s.seen / s.all)
                    : (double)sl_light_probe(r->sampling, l, &at->request->point, 1, at->counters);
        variance = weighed ? form * form * ratio_variance(&s, n) : 0.0;
    }
    add(&sample->irradiance, light->colour, e);
    add_reflected(at, light->radiance, s.lobe, sample);
    double mean = (double)sl_rgb_mean(light->colour);
    sample->variance += (float)(variance * mean * mean);
}

static void add_light(const lit *at, size_t l, sl_sample *sample) {
    const area_renderer *r = at->renderer;
    const sl_sampled_light *light = &r->lights->light[l];
    double e = (double)sl_light_sample_by_rays(r->sampling, l, &at->request->point, 1, at->counters);
    if (!(e > 0.0)) return;
    add(&sample->irradiance, light->colour, e);
    if (!at->has_lobe) return;
    sl_vec3 to_light = sl_light_direction(light, &at->request->point);
    add_reflected(at, light->colour, e * (double)sl_bsdf_value(&at->lobe.bsdf, to_light, SL_LOBE_GLOSSY).r,
                  sample);
}

/* ---- the renderer ---------------------------------------------------------------------------- */

enum { LOBE_STREAM = 0x6c6f6265 };

static void add_lights(const lit *at, sl_sample *sample) {
    const area_renderer *r = at->renderer;
    for (size_t l = 0; l < r->lights->count; l++) {
        if (sl_light_has_extent(&r->lights->light[l])) add_area_light(at, l, sample);
        else add_light(at, l, sample);
    }
    if (!at->has_lobe || r->settings.scene->emitter_count == 0) return;
    uint32_t draws = (uint32_t)at->lobe.draws;
    sl_light_numbers numbers = numbers_of(r, LOBE_STREAM, at->request->set * draws, draws);
    sl_rgb met = sl_lobe_draws(r->sampling, &at->request->point, &at->lobe, &numbers, at->counters);
    add_reflected(at, met, 1.0, sample);
}

static void render_point(const void *state, const sl_sample_request *request, unsigned worker,
                         sl_sample *sample, sl_counters *counters) {
    (void)worker;
    const area_renderer *r = state;
    const int points = (int)points_of(r, request);
    lit at = {.renderer = r,
              .request = request,
              .lobe = {.points = (double)points, .draws = (double)((points + 1) / 2)},
              .counters = counters};
    at.has_lobe = sl_request_lobe(request, &at.lobe.bsdf);
    if (!at.has_lobe && !sl_request_wants_irradiance(request)) return;
    add_lights(&at, sample);
    if (r->settings.cache.indirect == SL_INDIRECT_NONE)
        sl_request_sky_light(&r->settings, &r->sequence, request, points, sample, counters);
}

static void prepare(void *state, size_t count, const sl_sample_request *requests) {
    (void)count, (void)requests;
    const area_renderer *r = state;
    sl_light_sampling_trace_by(r->sampling, *r->settings.tracer);
}

static void release_lights(area_renderer *r) {
    sl_light_sampling_destroy(r->sampling);
    sl_sampled_lights_destroy(r->lights);
    r->sampling = NULL;
    r->lights = NULL;
}

static sl_status make_lights(void *state, sl_error *error) {
    area_renderer *r = state;
    sl_light_sample_settings by_rays = sl_light_sample_defaults();
    by_rays.estimator = SL_LIGHT_RAYS;
    release_lights(r);
    sl_status status = sl_sampled_lights_find(r->settings.scene, &r->lights, error);
    if (status == SL_OK)
        status = sl_light_sampling_create(r->settings.scene, NULL, *r->settings.tracer, r->lights, &by_rays,
                                          &r->sampling, error);
    return status;
}

static void destroy(void *state) {
    area_renderer *r = state;
    if (!r) return;
    release_lights(r);
    sl_free(r);
}

static double rays(const void *state) {
    const area_renderer *r = state;
    double sum = 0.0;
    for (size_t l = 0; l < r->lights->count; l++)
        sum += sl_light_has_extent(&r->lights->light[l]) ? (double)r->settings.cache.area_samples : 1.0;
    return sum;
}

sl_status sl_area_renderer(const sl_renderer_settings *settings, sl_sample_renderer *renderer,
                           sl_error *error) {
    *renderer = (sl_sample_renderer){
        .prepare = prepare, .render = render_point, .edit = make_lights, .destroy = destroy, .rays = rays};
    area_renderer *r = sl_allocate(1, sizeof *r);
    if (!r) return sl_fail_memory(error, "a sample renderer");
    r->settings = *settings;
    sl_sequence_make(&r->sequence);
    sl_status status = make_lights(r, error);
    if (status == SL_OK) renderer->state = r;
    else destroy(r);
    return status;
}
