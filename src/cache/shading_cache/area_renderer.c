/* Direct light. An area light's irradiance without occluders is known in closed form (Lambert's formula,
 * light_sample/closed_forms.c); N points spread over the light tell what share of it is seen:
 *
 *     E = E_closed  sum w_i V_i / sum w_i,   w = (n . w)+ (-m . w)+ / r^2,
 *
 * so that noise is left where there are shadows alone. Or by the points alone, as the paper has it: E = L A /
 * N sum w_i V_i. Lights without extent take a shadow ray. Every vertex uses the same points: vertices under
 * the same light have the same error, and an unchanged scene unchanged bits.
 *
 * The glossy lobe reflects what the same points send, and what directions drawn from the lobe itself meet of
 * lamps, put together by the balance heuristic (Veach and Guibas 1995): a narrow lobe would fall between the
 * points.
 *
 * Who counts what: lamps and lights as seen from the point are counted here and nowhere else, by its diffuse
 * part and by its glossy lobe. Mirrors reflect lamps as well as all else by bidirectional_renderer.c. So does
 * the environment shine, which is counted here only where no renderer of indirect light is wanted. */
#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/shading_cache/renderer_parts.h"
#include "cache/patches/solids.h"

/* What lies within this share of the way to the light, at the light, is the light, or too near it to be told
 * from it. */
static const double light_margin = 1e-4;

typedef struct area_renderer {
    sl_renderer_settings settings;
    sl_sampled_lights *lights;
    sl_area_light *area;       /* by light; of those without extent empty */
    size_t area_count;
    sl_halton lobe_points;
    sl_solids *solids;
} area_renderer;

/* ---- at a point ------------------------------------------------------------------------------ */

typedef struct lit {
    const area_renderer *renderer;
    const sl_sample_request *request;
    sl_lit_point point;
    sl_vec3 origin;            /* of shadow rays: above the surface in spite of rounding */
    sl_vec3d x, n, g;
    sl_bsdf lobe;
    bool has_lobe;
    sl_counters *counters;
} lit;

/* Sums over a light's points. */
typedef struct sums {
    double all, seen;          /* of weights: w, w V */
    double all_squares, seen_squares;
    double lobe;               /* radiance of the lobe by the points, ks = 1, L = 1 */
} sums;

typedef struct packet {
    sl_ray16 rays;
    double weight[SL_PACKET], lobe[SL_PACKET];
    unsigned count;
} packet;

static void put_ray(const lit *at, packet *p, sl_vec3 direction, double far, uint32_t skip, double weight,
                    double lobe) {
    unsigned i = p->count++;
    sl_ray16_set(&p->rays, i, at->origin, direction, 0.0f, (float)far, skip);
    p->weight[i] = weight;
    p->lobe[i] = lobe;
}

static void trace(const lit *at, packet *p, sums *s) {
    if (p->count == 0) return;
    uint32_t hidden =
        sl_trace_occluded(*at->renderer->settings.tracer, &p->rays, p->count, true, at->counters);
    for (unsigned i = 0; i < p->count; i++) {
        if (hidden >> i & 1) continue;
        s->seen += p->weight[i];
        s->seen_squares += p->weight[i] * p->weight[i];
        s->lobe += p->weight[i] * p->lobe[i];
    }
    p->count = 0;
}

static uint32_t lobe_draws(const area_renderer *r) {
    return (uint32_t)(r->settings.cache.area_samples + 1) / 2;
}

/* f of the lobe for ks = 1. */
static double lobe_value(const lit *at, sl_vec3 to_light) {
    return at->has_lobe ? (double)sl_bsdf_value(&at->lobe, to_light, SL_LOBE_GLOSSY).r : 0.0;
}

static void add(sl_rgb *to, sl_rgb colour, double scale) {
    *to = sl_rgb_add(*to, (sl_rgb){(float)((double)colour.r * scale), (float)((double)colour.g * scale),
                                   (float)((double)colour.b * scale)});
}

static sl_rgb lobe_colour(const lit *at, sl_rgb light) {
    return at->has_lobe ? sl_rgb_mul(light, at->request->material->specular) : sl_grey(0.0f);
}

/* ---- area lights ----------------------------------------------------------------------------- */

/* The balance heuristic's density of a direction: of all points of the light and all draws from the lobe. */
static double density_of(const lit *at, const sl_area_light *area, double squared, double cosine,
                         sl_vec3 to_light) {
    double points = (double)at->renderer->settings.cache.area_samples;
    return points * squared / (area->surface.area * cosine) +
           (double)lobe_draws(at->renderer) * (double)sl_bsdf_pdf(&at->lobe, to_light);
}

/* One point of the light: its weight, and its ray where it has any. */
static void add_point(const lit *at, const sl_area_light *area, uint32_t index, packet *p, sums *s) {
    sl_area_point y = sl_area_light_point(at->renderer->settings.scene, area, index);
    sl_vec3d d = sl_subd(y.position, at->x);
    double squared = sl_dotd(d, d), high = sl_dotd(at->n, d), front = -sl_dotd(y.normal, d);
    if (area->light->two_sided) front = fabs(front);
    if (!(squared > 0.0 && high > 0.0 && front > 0.0 && sl_dotd(at->g, d) > 0.0)) return;
    double weight = high / squared * (front / squared);
    if (!(weight > 0.0 && weight <= 0x1p500)) return;
    s->all += weight;
    s->all_squares += weight * weight;
    if (!y.shines) return;
    double lobe = 0.0;
    if (at->has_lobe) {
        double distance = sqrt(squared), cosine = front / distance;
        sl_vec3 to_light = sl_to_float(sl_scaled(d, 1.0 / distance));
        lobe = lobe_value(at, to_light) * squared / cosine / density_of(at, area, squared, cosine, to_light);
    }
    sl_vec3 direction = sl_to_float(sl_subd(y.position, sl_to_double(at->origin)));
    put_ray(at, p, direction, 1.0 - light_margin, y.triangle, weight, lobe);
    if (p->count == SL_PACKET) trace(at, p, s);
}

/* What little of the light is above the horizon has none of the points: one ray to its middle. */
static void add_middle(const lit *at, const sl_area_light *area, sums *s) {
    sl_vec3 direction = sl_light_direction(area->light, &at->point);
    if (!(sl_dot(direction, direction) > 0.0f)) return;
    packet p = {.count = 0};
    sl_hit16 hit;
    put_ray(at, &p, direction, INFINITY, at->point.triangle, 1.0, 0.0);
    sl_trace(*at->renderer->settings.tracer, &p.rays, 1, true, &hit, at->counters);
    s->all = s->all_squares = 1.0;
    const sl_sampled_lights *lights = at->renderer->lights;
    uint32_t met = hit.triangle[0] != SL_NO_INDEX ? lights->light_of_triangle[hit.triangle[0]] : SL_NO_INDEX;
    if (met == SL_NO_INDEX || &lights->light[met] != area->light) return;
    s->seen = s->seen_squares = 1.0;
}

/* Variances of the mean: of a ratio of sums, and of a mean. */
static double ratio_variance(const sums *s, double n) {
    double share = s->seen / s->all, hidden = fmax(s->all_squares - s->seen_squares, 0.0);
    double squares = s->seen_squares * (1.0 - share) * (1.0 - share) + hidden * share * share;
    return n > 1.0 ? squares / (s->all * s->all) * n / (n - 1.0) : 0.0;
}

static double mean_variance(const sums *s, double n) {
    return n > 1.0 ? fmax(s->seen_squares - s->seen * s->seen / n, 0.0) / (n * (n - 1.0)) : 0.0;
}

static void add_points(const lit *at, const sl_area_light *area, uint32_t first, uint32_t end, sums *s) {
    packet p = {.count = 0};
    for (uint32_t i = first; i < end; i++) add_point(at, area, i, &p, s);
    trace(at, &p, s);
}

/* The first set goes on until its points are dense, where there is an edge of a shadow, or where the closed
 * form does not smooth what is lit all over. Lobes have their part from the points before, with which their
 * densities reckon. Returns how many points there are. */
static uint32_t add_dense_points(const lit *at, const sl_area_light *area, uint32_t points, sums *s) {
    bool edge = (s->seen > 0.0 && s->seen < s->all) || at->renderer->settings.cache.area == SL_AREA_SAMPLED;
    if (!at->request->dense || at->request->set > 0 || points >= SL_DENSE_POINTS || !edge) return points;
    lit diffuse = *at;
    diffuse.has_lobe = false;
    add_points(&diffuse, area, points + 1, SL_DENSE_POINTS + 1, s);
    return SL_DENSE_POINTS;
}

static void add_area_light(const lit *at, const sl_area_light *area, sl_sample *sample) {
    const sl_shading_cache_settings *settings = &at->renderer->settings.cache;
    double share = sl_light_unoccluded(area->light, &at->point);
    sl_count(at->counters, SL_COUNT_LIGHT_SAMPLES, 1);
    if (!(share > 0.0)) {
        sl_count(at->counters, SL_COUNT_LIGHT_SAMPLES_SKIPPED, 1);
        return;
    }
    sums s = {.all = 0.0};
    uint32_t points = (uint32_t)settings->area_samples, first = at->request->set * points + 1;
    add_points(at, area, first, first + points, &s);
    double n = (double)add_dense_points(at, area, points, &s);
    /* of E / L */
    double scale = area->surface.area / n,
           variance = mean_variance(&s, n) * area->surface.area * area->surface.area;
    if (settings->area == SL_AREA_RATIO) {
        if (!(s.all > 0.0)) add_middle(at, area, &s);
        if (!(s.all > 0.0)) return;
        scale = SL_PI * share / s.all;
        variance = ratio_variance(&s, n) * SL_PI * SL_PI * share * share;
    }
    add(&sample->irradiance, area->light->radiance, scale * s.seen);
    add(&sample->radiance, lobe_colour(at, area->light->radiance), s.lobe);
    double mean = (double)sl_rgb_mean(area->light->radiance);
    sample->variance += (float)(variance * mean * mean);
}

/* ---- lamps that the lobe meets --------------------------------------------------------------- */

static void add_met_lamp(const lit *at, sl_vec3 direction, const sl_hit16 *hits, unsigned i,
                         sl_sample *sample) {
    const area_renderer *r = at->renderer;
    uint32_t triangle = hits->triangle[i],
             light = triangle != SL_NO_INDEX ? r->lights->light_of_triangle[triangle] : SL_NO_INDEX;
    if (light == SL_NO_INDEX) return;
    const sl_area_light *area = &r->area[light];
    double cosine = -(double)sl_dot(sl_scene_geometric_normal(r->settings.scene, triangle), direction),
           distance = (double)hits->t[i];
    if (area->light->two_sided) cosine = fabs(cosine);
    double arriving = (double)sl_dot(direction, at->point.normal);
    if (!(cosine > 0.0 && arriving > 0.0 && distance > 0.0)) return;
    double density = density_of(at, area, distance * distance, cosine, direction);
    add(&sample->radiance, lobe_colour(at, area->light->radiance),
        lobe_value(at, direction) * arriving / density);
}

static void add_lobe(const lit *at, sl_sample *sample) {
    const area_renderer *r = at->renderer;
    uint32_t draws = lobe_draws(r), first = at->request->set * draws + 1;
    for (uint32_t i = 0; i < draws;) {
        packet p = {.count = 0};
        sl_vec3 direction[SL_PACKET];
        sl_hit16 hits;
        for (; i < draws && p.count < SL_PACKET; i++) {
            double u[2];
            sl_halton_point(&r->lobe_points, first + i, u);
            float u1 = fminf((float)u[0], 0x1.fffffep-1f), u2 = fminf((float)u[1], 0x1.fffffep-1f);
            sl_vec3 *d = &direction[p.count];
            if (sl_bsdf_sample(&at->lobe, 0.0f, u1, u2, d))
                put_ray(at, &p, *d, INFINITY, at->point.triangle, 0.0, 0.0);
        }
        if (p.count > 0) sl_trace(*r->settings.tracer, &p.rays, p.count, true, &hits, at->counters);
        for (unsigned k = 0; k < p.count; k++) add_met_lamp(at, direction[k], &hits, k, sample);
    }
}

/* ---- lights without extent ------------------------------------------------------------------- */

static void add_lights_without_extent(const lit *at, sl_sample *sample) {
    const sl_scene *scene = at->renderer->settings.scene;
    for (size_t first = 0; first < scene->light_count; first += SL_PACKET) {
        packet p = {.count = 0};
        sl_rgb arriving[SL_PACKET];
        sl_vec3 to_light[SL_PACKET];
        for (size_t l = first; l < scene->light_count && l < first + SL_PACKET; l++) {
            float distance;
            unsigned i = p.count;
            sl_count(at->counters, SL_COUNT_LIGHT_SAMPLES, 1);
            bool shines = sl_light_illuminate(&scene->lights[l], at->point.position, &to_light[i], &distance,
                                              &arriving[i]);
            float cosine = shines ? sl_dot(at->point.normal, to_light[i]) : 0.0f;
            if (!(cosine > 0.0f && sl_dot(at->point.geometric_normal, to_light[i]) > 0.0f)) {
                sl_count(at->counters, SL_COUNT_LIGHT_SAMPLES_SKIPPED, 1);
                continue;
            }
            put_ray(at, &p, to_light[i], (double)distance * (1.0 - light_margin), at->point.triangle,
                    (double)cosine, lobe_value(at, to_light[i]));
        }
        uint32_t hidden =
            p.count ? sl_trace_occluded(*at->renderer->settings.tracer, &p.rays, p.count, true, at->counters)
                    : 0;
        for (unsigned i = 0; i < p.count; i++) {
            if (hidden >> i & 1) continue;
            add(&sample->irradiance, arriving[i], p.weight[i]);
            add(&sample->radiance, lobe_colour(at, arriving[i]), p.weight[i] * p.lobe[i]);
        }
    }
}

/* ---- the renderer ---------------------------------------------------------------------------- */

static void render_point(const void *state, const sl_sample_request *request, unsigned worker,
                         sl_sample *sample, sl_counters *counters) {
    (void)worker;
    const area_renderer *r = state;
    const sl_root_point *p = &request->point;
    sample->valid = !sl_solids_hold(r->solids, *r->settings.tracer, p->position, p->geometric_normal,
                                    p->triangle, &request->eye, counters);
    if (!sample->valid) return;
    lit at = {.renderer = r,
              .request = request,
              .point = {p->position, p->normal, p->geometric_normal, p->triangle},
              .origin = sl_surface_lift_anywhere(r->settings.scene, p->position, p->geometric_normal),
              .x = sl_to_double(p->position),
              .n = sl_to_double(p->normal),
              .g = sl_to_double(p->geometric_normal),
              .counters = counters};
    at.has_lobe = sl_request_lobe(request, &at.lobe);
    if (!at.has_lobe && !sl_request_wants_irradiance(request)) return;
    for (size_t l = 0; l < r->area_count; l++) {
        if (r->area[l].light) add_area_light(&at, &r->area[l], sample);
    }
    if (at.has_lobe && r->settings.scene->emitter_count > 0) add_lobe(&at, sample);
    add_lights_without_extent(&at, sample);
    if (r->settings.cache.indirect == SL_INDIRECT_NONE) {
        sl_sky_light(r->settings.scene, *r->settings.tracer, r->settings.seed,
                     (uint32_t)r->settings.cache.area_samples, request, sample, counters);
    }
}

static void render(const void *state, size_t count, const sl_sample_request *requests, unsigned threads,
                   sl_sample *samples, sl_counters *counters) {
    sl_render_each(render_point, state, count, requests, threads, samples, counters);
}

static void release_lights(area_renderer *r) {
    for (size_t l = 0; l < r->area_count; l++) sl_area_light_release(&r->area[l]);
    sl_free(r->area);
    sl_sampled_lights_destroy(r->lights);
    r->area = NULL;
    r->area_count = 0;
    r->lights = NULL;
}

static sl_status make_lights(area_renderer *r, sl_error *error) {
    release_lights(r);
    sl_status status = sl_sampled_lights_find(r->settings.scene, &r->lights, error);
    if (status != SL_OK) return status;
    r->area = sl_allocate(r->lights->count, sizeof *r->area);
    if (!r->area) return sl_fail_memory(error, "area lights");
    r->area_count = r->lights->count;
    for (size_t l = 0; l < r->area_count && status == SL_OK; l++) {
        const sl_sampled_light *light = &r->lights->light[l];
        if (sl_light_has_extent(light))
            status = sl_area_light_make(r->settings.scene, light, sl_random_key(r->settings.seed, l),
                                        &r->area[l], error);
    }
    return status;
}

static sl_status edit(void *state, unsigned changes, sl_error *error) {
    area_renderer *r = state;
    if (!(changes & (SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS))) return SL_OK;
    sl_status status = make_lights(r, error);
    if (status == SL_OK) sl_solids_edit(r->solids);
    return status;
}

static bool eye_matters(const void *state, sl_vec3 before, sl_vec3 now) {
    const area_renderer *r = state;
    return sl_solids_eye_matters(r->solids, before, now);
}

static void destroy(void *state) {
    area_renderer *r = state;
    if (!r) return;
    release_lights(r);
    sl_solids_destroy(r->solids);
    sl_free(r);
}

sl_status sl_area_renderer(const sl_renderer_settings *settings, sl_sample_renderer *renderer,
                           sl_error *error) {
    *renderer = (sl_sample_renderer){
        .name = "area", .render = render, .edit = edit, .eye_matters = eye_matters, .destroy = destroy};
    area_renderer *r = sl_allocate(1, sizeof *r);
    if (!r) return sl_fail_memory(error, "a sample renderer");
    r->settings = *settings;
    r->lobe_points = sl_halton_make(sl_random_key(settings->seed, 0x6c6f6265u));
    sl_status status = make_lights(r, error);
    if (status == SL_OK) status = sl_solids_find(settings->scene, &r->solids, error);
    if (status != SL_OK) {
        destroy(r);
        return status;
    }
    renderer->state = r;
    return SL_OK;
}
