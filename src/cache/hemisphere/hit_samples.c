/* Emitters and environment light the hits of a gather by samples: all hits together share a budget, as many
 * samples as there are hits that can be lit (times hit_samples). Where they go is decided in steps, each of
 * which keeps the estimate unbiased:
 *
 *     which hits     in proportion to the light that each is expected to send back, E albedo W, where E is
 *                    the sum over the sources of what they would give unhindered, mixed with an even share;
 *                    by systematic sampling, so a hit gets the number expected, rounded up or down
 *     which source   in proportion to the terms of that sum
 *     which point    uniform in area; within twice an emitter's size uniform in solid angle (Arvo 1995),
 *                    where 1 / distance^2 would make single hits outshine the gather
 *
 * Samples are sorted by source before their points are chosen and their shadow rays traced: points of one
 * source are then well spread over all hits that chose it. */
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/hemisphere/hit_light.h"
#include "cache/light/spherical_triangle.h"

/* How much of the budget is spread evenly over the hits. */
#define EVEN_SHARE 0.2

static float unit(uint32_t bits) { return (float)(bits >> 8) * 0x1p-24f; }

/* ---- a worker's buffers ---- */

static bool allocate(sl_light_scratch *s, size_t slots, size_t sources) {
    size_t padded = s->capacity + SL_SOURCE_LANES;
    float **const by_slot[] = {&s->reflects, &s->expected, &s->samples_at};
    float **const by_sample[] = {&s->share,       &s->u1,          &s->u2,       &s->origin_x,
                                 &s->origin_y,    &s->origin_z,    &s->direction_x, &s->direction_y,
                                 &s->direction_z, &s->arriving,    &s->near};
    s->slot_block = sl_allocate_planes(slots, sizeof by_slot / sizeof *by_slot, by_slot);
    s->sample_block = sl_allocate_planes(padded, sizeof by_sample / sizeof *by_sample, by_sample);
    s->of_block = sl_allocate(slots, SL_SOURCE_BLOCKS_MAX * sizeof *s->of_block);
    s->chosen = sl_allocate(s->capacity, sizeof *s->chosen);
    s->of_source = sl_allocate(sources + 1, sizeof *s->of_source);
    s->sample_slot = sl_allocate(padded, sizeof *s->sample_slot);
    s->sample_source = sl_allocate(padded, sizeof *s->sample_source);
    return s->slot_block && s->sample_block && s->of_block && s->chosen && s->of_source && s->sample_slot &&
           s->sample_source;
}

sl_status sl_light_scratch_create(const sl_gather *gather, size_t slots, sl_light_scratch **out,
                                  sl_error *error) {
    *out = NULL;
    sl_light_scratch *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "a gather's light samples");
    s->capacity = slots * gather->settings.hit_samples + 2;
    if (!allocate(s, slots, gather->sources->count)) {
        sl_light_scratch_destroy(s);
        return sl_fail_memory(error, "a gather's light samples");
    }
    *out = s;
    return SL_OK;
}

void sl_light_scratch_destroy(sl_light_scratch *s) {
    if (!s) return;
    void *blocks[] = {s->slot_block, s->sample_block, s->of_block,     s->chosen,
                      s->of_source,  s->sample_slot,  s->sample_source};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) sl_free(blocks[i]);
    sl_free(s);
}

/* ---- what may come ---- */

static sl_expected_light expected_light(const sl_gather_view *view, size_t first, size_t count) {
    const sl_light_scratch *s = view->scratch->light;
    return (sl_expected_light){sl_hit_points(&view->scratch->hits, first, count), s->reflects + first,
                               s->of_block + first * SL_SOURCE_BLOCKS_MAX, s->expected + first};
}

void sl_gather_expect_light(const sl_gather_view *view, size_t first, size_t count) {
    sl_light_scratch *s = view->scratch->light;
    for (size_t k = first; k < first + count; k++) s->reflects[k] = sl_hit_reflectance(view, k);
    sl_expected_light light = expected_light(view, first, count);
    view->gather->light_kernels.expect(view->gather->sources, &light);
}

/* ---- which hits get how many ---- */

/* s->samples_at becomes the expected number of samples of every hit. */
static void share_budget(const sl_gather_view *view) {
    sl_light_scratch *s = view->scratch->light;
    size_t slots = view->scratch->slots;
    const float *weight = view->gather->tables->weight, *share = view->scratch->slot_share;
    double sum = 0.0;
    s->lit = 0;
    for (size_t k = 0; k < slots; k++) {
        s->samples_at[k] = s->expected[k] * s->reflects[k] * (weight[view->scratch->slot_cell[k]] * share[k]);
        sum += (double)s->samples_at[k];
        s->lit += s->expected[k] > 0.0f;
    }
    double budget = (double)view->gather->settings.hit_samples;
    bool uneven = sum > 0.0 && isfinite(sum);
    float even = (float)(uneven ? EVEN_SHARE * budget : budget),
          by_light = (float)(uneven ? (1.0 - EVEN_SHARE) * budget * (double)s->lit / sum : 0.0);
    for (size_t k = 0; k < slots; k++)
        s->samples_at[k] = s->expected[k] > 0.0f ? even + by_light * s->samples_at[k] : 0.0f;
}

/* ---- which source ---- */

/* Returns the first of n weights before which and with which u of their sum is used up, the last that has any
 * where rounding leaves some; n: none has. *target: what is left of it. */
static size_t pick(const float *weight, size_t n, float *target) {
    size_t chosen = n;
    for (size_t i = 0; i < n; i++) {
        if (!(weight[i] > 0.0f)) continue;
        chosen = i;
        if (*target < weight[i]) break;
        *target -= weight[i];
    }
    return chosen;
}

/* The block first, then its source, in proportion to their weights. */
static bool choose_source(const sl_gather_view *view, const sl_expected_light *light, size_t k, float u,
                          uint32_t *source, float *chance) {
    const sl_light_sources *sources = view->gather->sources;
    float target = u * light->sum[k];
    size_t block = pick(light->of_block + k * SL_SOURCE_BLOCKS_MAX, sources->blocks, &target);
    if (block == sources->blocks) return false;
    sl_block_weights w;
    view->gather->light_kernels.block(sources, light, k, block, &w);
    size_t lane = pick(w.of, SL_SOURCE_LANES, &target);
    if (lane == SL_SOURCE_LANES) return false;
    *source = (uint32_t)(block * SL_SOURCE_LANES + lane);
    *chance = w.of[lane] / light->sum[k];
    return *chance > 0.0f;
}

/* Systematic sampling: hit after hit, one sample whenever the sum of the expected numbers passes the next
 * whole one. */
static void draw_samples(const sl_gather_view *view, uint64_t key) {
    sl_light_scratch *s = view->scratch->light;
    sl_expected_light light = expected_light(view, 0, view->scratch->slots);
    double sum = (double)sl_random_unit(key, 0);
    uint32_t before = 0, select = sl_random_bits(key, 1);
    s->samples = 0;
    for (size_t k = 0; k < light.at.count; k++) {
        sum += (double)s->samples_at[k];
        for (uint32_t now = (uint32_t)sum; before < now; before++) {
            uint32_t source;
            float chance;
            select += 2654435769u; /* golden ratio */
            if (s->samples == s->capacity ||
                !choose_source(view, &light, k, unit(select), &source, &chance))
                continue;
            s->chosen[s->samples++] =
                (sl_chosen_source){(uint32_t)k, source, 1.0f / (chance * s->samples_at[k])};
        }
    }
}

/* ---- in order of the sources ---- */

static void sort_by_source(const sl_gather_view *view) {
    sl_light_scratch *s = view->scratch->light;
    size_t sources = view->gather->sources->count;
    memset(s->of_source, 0, (sources + 1) * sizeof *s->of_source);
    for (size_t m = 0; m < s->samples; m++) s->of_source[s->chosen[m].source + 1]++;
    for (size_t i = 0; i < sources; i++) s->of_source[i + 1] += s->of_source[i];
    s->of_emitters = s->of_source[view->gather->sources->sky];
    for (size_t m = 0; m < s->samples; m++) {
        uint32_t to = s->of_source[s->chosen[m].source]++;
        s->sample_slot[to] = s->chosen[m].slot;
        s->sample_source[to] = s->chosen[m].source;
        s->share[to] = s->chosen[m].share;
    }
}

/* Steps of the R2 sequence: 1/g and 1/g^2, g^3 = g + 1, as fractions of 2^32. */
static void spread_points(sl_light_scratch *s, uint64_t key) {
    uint32_t u1 = sl_random_bits(key, 3), u2 = sl_random_bits(key, 4);
    for (size_t m = 0; m < s->samples; m++, u1 += 3242174889u, u2 += 2447445414u) {
        s->u1[m] = unit(u1);
        s->u2[m] = unit(u2);
    }
}

/* ---- near emitters: points uniform in solid angle ---- */

/* A near emitter that spans less than a millionth of a steradian is seen edge-on or is very small: it is left
 * out. */
static void light_by_near_emitter(const sl_gather_view *view, sl_shadow_queue *q, size_t m) {
    const sl_scene *scene = view->gather->scene;
    const sl_gather_hits *h = &view->scratch->hits;
    const sl_light_scratch *s = view->scratch->light;
    const sl_emitter *e = &scene->emitters[view->gather->sources->index[s->sample_source[m]]];
    size_t k = s->sample_slot[m];
    sl_vec3 p = sl_hit_position(h, k), corner[3];
    sl_spherical_triangle seen;
    if (e->triangle == h->triangle[k]) return;
    for (int c = 0; c < 3; c++) corner[c] = sl_scene_position(scene, scene->vertex[c][e->triangle]);
    if (!sl_spherical_triangle_make(corner, p, &seen)) return;
    sl_vec3d direction = sl_spherical_triangle_point(&seen, (double)s->u1[m], (double)s->u2[m]);
    sl_vec3d normal = sl_to_double(sl_scene_geometric_normal(scene, e->triangle));
    sl_vec3d first = sl_to_double(sl_scene_position(scene, scene->vertex[0][e->triangle]));
    double facing = -sl_dotd(normal, direction);
    if (!(facing > 0.0) && !e->two_sided) return;
    double distance = sl_dotd(normal, sl_subd(sl_to_double(p), first)) / facing;
    sl_vec3 to_light = sl_to_float(direction);
    float cosine = sl_hit_cosine(h, k, to_light);
    if (!(cosine > 0.0f) || !(distance > 0.0) || !isfinite(distance)) return;
    sl_push_shadow_ray(q, k, to_light, (float)distance,
                       sl_rgb_scale(e->radiance, (float)seen.solid_angle * cosine * s->share[m]));
}

/* ---- emitters ---- */

static void choose_points(const sl_gather_view *view) {
    sl_light_scratch *s = view->scratch->light;
    sl_point_samples samples = {.count = s->of_emitters,
                                .slot = s->sample_slot,
                                .source = s->sample_source,
                                .share = s->share,
                                .u1 = s->u1,
                                .u2 = s->u2,
                                .at = sl_hit_points(&view->scratch->hits, 0, view->scratch->slots),
                                .offset = view->gather->offset,
                                .rounding = sl_scene_rounding(view->gather->scene),
                                .origin_x = s->origin_x,
                                .origin_y = s->origin_y,
                                .origin_z = s->origin_z,
                                .direction_x = s->direction_x,
                                .direction_y = s->direction_y,
                                .direction_z = s->direction_z,
                                .arriving = s->arriving,
                                .near = s->near};
    view->gather->light_kernels.points(view->gather->sources, &samples);
}

/* Alpha masks have holes. */
static bool is_opaque_there(const sl_gather_view *view, uint32_t triangle, float u1, float u2) {
    if (!sl_scene_has_alpha(view->gather->scene, triangle)) return true;
    float root = sqrtf(u1);
    return sl_scene_is_opaque(view->gather->scene, triangle, root * (1.0f - u2), root * u2);
}

static void light_by_emitters(const sl_gather_view *view, sl_shadow_queue *q) {
    const sl_light_scratch *s = view->scratch->light;
    const sl_light_sources *sources = view->gather->sources;
    if (s->of_emitters == 0) return;
    choose_points(view);
    for (size_t m = 0; m < s->of_emitters; m++) {
        uint32_t i = s->sample_source[m];
        if (s->near[m] > 0.0f) {
            light_by_near_emitter(view, q, m);
            continue;
        }
        if (!(s->arriving[m] > 0.0f) ||
            !is_opaque_there(view, view->gather->scene->emitters[sources->index[i]].triangle, s->u1[m],
                             s->u2[m]))
            continue;
        sl_rgb light = {sources->red[i] * s->arriving[m], sources->green[i] * s->arriving[m],
                        sources->blue[i] * s->arriving[m]};
        sl_push_ready_ray(q, s->sample_slot[m], sl_v3(s->origin_x[m], s->origin_y[m], s->origin_z[m]),
                          sl_v3(s->direction_x[m], s->direction_y[m], s->direction_z[m]), false, light);
    }
}

/* ---- the sky ---- */

/* Of a constant sky in proportion to the cosine, or by its own distribution. */
static bool sample_sky(const sl_gather_view *view, size_t k, float u1, float u2, sl_vec3 *direction,
                       sl_rgb *irradiance) {
    const sl_environment *e = &view->gather->scene->environment;
    const sl_gather_hits *h = &view->scratch->hits;
    if (e->width > 0) {
        float pdf;
        *direction = sl_environment_sample(e, u1, u2, irradiance, &pdf);
        float cosine = sl_hit_cosine(h, k, *direction);
        *irradiance = sl_rgb_scale(*irradiance, pdf > 0.0f ? cosine / pdf : 0.0f);
        return pdf > 0.0f && cosine > 0.0f;
    }
    sl_frame frame = sl_frame_from_normal(sl_v3(h->normal_x[k], h->normal_y[k], h->normal_z[k]));
    float sine, cosine, radius = sqrtf(u1), height = sqrtf(1.0f - u1);
    sl_sincos_turnf(u2, &sine, &cosine);
    *direction = sl_frame_to_world(&frame, sl_v3(radius * cosine, radius * sine, height));
    *irradiance = sl_rgb_scale(e->constant, (float)SL_PI);
    return sl_hit_cosine(h, k, *direction) > 0.0f;
}

static void light_by_sky(const sl_gather_view *view, sl_shadow_queue *q) {
    const sl_light_scratch *s = view->scratch->light;
    for (size_t m = s->of_emitters; m < s->samples; m++) {
        sl_vec3 direction;
        sl_rgb irradiance;
        bool lit = sample_sky(view, s->sample_slot[m], s->u1[m], s->u2[m], &direction, &irradiance);
        irradiance = sl_rgb_scale(irradiance, lit ? s->share[m] : 0.0f);
        if (lit && sl_rgb_is_finite(irradiance))
            sl_push_shadow_ray(q, s->sample_slot[m], direction, INFINITY, irradiance);
    }
}

/* ---- all of it ---- */

void sl_gather_light_by_samples(const sl_gather_view *view, sl_shadow_queue *q) {
    sl_light_scratch *s = view->scratch->light;
    uint64_t key = sl_random_key(view->point->key, 1);
    s->samples = 0;
    share_budget(view);
    draw_samples(view, key);
    sort_by_source(view);
    spread_points(s, key);
    light_by_emitters(view, q);
    sl_flush_shadow_rays(q);
    light_by_sky(view, q);
    sl_flush_shadow_rays(q);
}
