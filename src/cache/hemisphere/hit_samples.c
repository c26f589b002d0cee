/* Emitters and environment light the hits of a gather by samples: all hits together share a budget, as many
 * samples as there are hits that can be lit (times hit_samples). Where they go is decided in steps:
 *
 *     which hits     in proportion to the light that each is expected to send back, E albedo W, where E is
 *                    the sum over the sources of what they would give unhindered (of emitters in closed form,
 *                    as for pixels), mixed with an even share; by systematic sampling, so a hit gets the
 *                    number expected, rounded up or down
 *     which source   in proportion to the terms of that sum
 *     which point    uniform in area, or, of what is near, by solid angle (near_light.h)
 *
 * A sample of an emitter brings what its point gives. The closed form times 0 or 1 would have less noise
 * where all of an emitter is seen, but be off wherever the part that is hidden gives more or less than the
 * rest.
 *
 * Samples are sorted by source before their points are chosen and their shadow rays traced: points of one
 * source are then well spread over all hits that chose it. */
#include <float.h>
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/hemisphere/hit_light.h"
#include "cache/light/near_light.h"
#include "trace/bsdf.h"

/* This share of the budget is spread evenly over the hits. */
#define EVEN_SHARE 0.2

/* ---- sources ---- */

/* Irradiance on the six planes, each texel by its middle. */
static void find_sky(const sl_environment *e, double irradiance[6]) {
    for (int d = 0; d < 6; d++)
        irradiance[d] = e->width > 0 ? 0.0 : SL_PI * (double)sl_luminance(e->constant);
    for (int row = 0; row < e->height; row++) {
        for (int column = 0; column < e->width; column++) {
            sl_rgb radiance;
            float solid_angle;
            sl_vec3 d = sl_environment_texel(e, row, column, &radiance, &solid_angle);
            const double light = (double)sl_luminance(radiance) * (double)solid_angle;
            const float axes[3] = {d.x, d.y, d.z};
            for (int axis = 0; axis < 3; axis++)
                irradiance[2 * axis + (axes[axis] < 0.0f ? 1 : 0)] += light * fabs((double)axes[axis]);
        }
    }
}

/* Returns a power of two near the strongest source; squares of what is counted in it stay within floats. */
static float choose_unit(const sl_gather *gather, const double sky[6]) {
    int exponent = 0;
    double most = gather->sides.count ? 0.5 * (double)gather->sides.unit : 0.0;
    for (int d = 0; d < 6; d++) most = fmax(most, sky[d]);
    if (most > 0.0 && isfinite(most)) (void)frexp(most, &exponent);
    return ldexpf(1.0f, exponent > FLT_MAX_EXP - 1 ? FLT_MAX_EXP - 1 : exponent);
}

sl_status sl_hit_sources_make(sl_gather *gather, sl_error *error) {
    const sl_environment *environment = &gather->extended.environment;
    double sky[6] = {0.0};
    sl_status status = sl_light_sides_make(&gather->extended, SL_HIT_SIDES_MAX, &gather->sides, error);
    if (status != SL_OK) return status;
    gather->sources = gather->sides.count + (environment->present ? 1 : 0);
    gather->strength = sl_allocate(gather->sources, sizeof *gather->strength);
    if (!gather->strength) return sl_fail_memory(error, "the light sources");
    if (environment->present) find_sky(environment, sky);
    gather->unit = choose_unit(gather, sky);
    for (size_t i = 0; i < gather->sides.count; i++)
        gather->strength[i] = gather->sides.luminance[i] * (gather->sides.unit / gather->unit);
    if (environment->present) gather->strength[gather->sides.count] = 1.0f;
    for (int d = 0; d < 6; d++) gather->sky_irradiance[d] = (float)(sky[d] / (double)gather->unit);
    return SL_OK;
}

/* ---- a worker's buffers ---- */

sl_status sl_light_scratch_create(const sl_gather *gather, size_t slots, sl_light_scratch **out,
                                  sl_error *error) {
    *out = NULL;
    sl_light_scratch *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "a gather's light samples");
    float **const planes[] = {&s->reflects, &s->expected, &s->samples_at};
    s->slots = slots;
    s->capacity = slots * gather->settings.hit_samples + 2;
    s->block = sl_allocate_planes(slots, sizeof planes / sizeof *planes, planes);
    s->from = sl_allocate(slots * gather->sources, sizeof *s->from);
    s->drawn = sl_allocate(s->capacity, sizeof *s->drawn);
    s->sorted = sl_allocate(s->capacity, sizeof *s->sorted);
    s->of_source = sl_allocate(gather->sources + 1, sizeof *s->of_source);
    if (!s->block || !s->from || !s->drawn || !s->sorted || !s->of_source) {
        sl_light_scratch_destroy(s);
        return sl_fail_memory(error, "a gather's light samples");
    }
    *out = s;
    return SL_OK;
}

void sl_light_scratch_destroy(sl_light_scratch *s) {
    if (!s) return;
    SL_FREE_ALL(s->block, s->from, s->drawn, s->sorted, s->of_source, s);
}

/* ---- what may come ---- */

/* The squares of a unit normal's components sum to 1, they weigh the six irradiances. */
static void weigh_sky(const float sky[6], const sl_light_points *at, float *from) {
    for (size_t i = 0; i < at->count; i++) {
        float x = at->normal_x[i], y = at->normal_y[i], z = at->normal_z[i];
        from[i] = x * x * sky[x < 0.0f] + y * y * sky[2 + (y < 0.0f)] + z * z * sky[4 + (z < 0.0f)];
    }
}

static void expect_block(const sl_gather_view *view, size_t first, size_t count) {
    const sl_gather *g = view->gather;
    const sl_light_scratch *s = view->scratch->light;
    const sl_light_points at = sl_hit_points(&view->scratch->hits, first, count);
    float *expected = s->expected + first;
    for (size_t i = 0; i < count; i++) expected[i] = 0.0f;
    for (size_t source = 0; source < g->sources; source++) {
        float *from = s->from + source * s->slots + first, strength = g->strength[source];
        if (source < g->sides.count)
            SL_KERNEL_OF(g->isa, sl_polygon_light)(&at, &g->sides.polygon[source], from);
        else weigh_sky(g->sky_irradiance, &at, from);
        for (size_t i = 0; i < count; i++) expected[i] += from[i] *= strength;
    }
    for (size_t i = 0; i < count; i++) {
        float reflects = s->reflects[first + i] = sl_hit_reflectance(view, first + i);
        expected[i] = reflects > 0.0f && expected[i] < 1e30f ? expected[i] : 0.0f;
    }
}

void sl_gather_expect_light(const sl_gather_view *view, size_t first, size_t count) {
    for (size_t k = first; k < first + count; k += SL_LIGHT_BLOCK)
        expect_block(view, k, sl_fewer(first + count - k, SL_LIGHT_BLOCK));
}

/* ---- which hits get how many ---- */

/* s->samples_at becomes the expected number of samples of every hit. */
static void share_budget(const sl_gather_view *view) {
    sl_light_scratch *s = view->scratch->light;
    size_t slots = view->scratch->slots, lit = 0;
    const float *weight = view->gather->tables->weight, *share = view->scratch->slot_share;
    double sum = 0.0;
    for (size_t k = 0; k < slots; k++) {
        s->samples_at[k] = s->expected[k] * s->reflects[k] * (weight[view->scratch->slot_cell[k]] * share[k]);
        sum += (double)s->samples_at[k];
        lit += s->expected[k] > 0.0f;
    }
    double budget = (double)view->gather->settings.hit_samples;
    bool uneven = sum > 0.0 && isfinite(sum);
    float even = (float)(uneven ? EVEN_SHARE * budget : budget),
          by_light = (float)(uneven ? (1.0 - EVEN_SHARE) * budget * (double)lit / sum : 0.0);
    for (size_t k = 0; k < slots; k++)
        s->samples_at[k] = s->expected[k] > 0.0f ? even + by_light * s->samples_at[k] : 0.0f;
}

/* ---- which source ---- */

/* Finds the first source before which and with which u of all that is expected at slot k is used up, the last
 * that gives any where rounding leaves some; returns its chance. */
static float choose_source(const sl_gather *gather, const sl_light_scratch *s, size_t k, float u,
                           uint32_t *source) {
    float target = u * s->expected[k], chosen = 0.0f;
    for (uint32_t i = 0; i < gather->sources; i++) {
        const float from = s->from[i * s->slots + k];
        if (!(from > 0.0f)) continue;
        *source = i;
        chosen = from;
        if (target < from) break;
        target -= from;
    }
    return chosen / s->expected[k];
}

/* Systematic sampling: hit after hit, one sample whenever the sum of the expected numbers passes the next
 * whole one. */
static void draw_samples(const sl_gather_view *view, uint64_t key) {
    sl_light_scratch *s = view->scratch->light;
    double sum = (double)sl_random_unit(key, 0);
    uint32_t before = 0, select = sl_random_bits(key, 1);
    s->samples = 0;
    for (size_t k = 0; k < view->scratch->slots; k++) {
        sum += (double)s->samples_at[k];
        for (uint32_t now = (uint32_t)sum; before < now; before++) {
            sl_hit_sample sample = {.slot = (uint32_t)k};
            select += 2654435769u; /* golden ratio */
            if (s->samples == s->capacity) continue;
            float chance = choose_source(view->gather, s, k, sl_unit_of_bits(select), &sample.source);
            if (!(chance > 0.0f)) continue;
            sample.share = 1.0f / (chance * s->samples_at[k]);
            s->drawn[s->samples++] = sample;
        }
    }
}

static void sort_by_source(const sl_gather *gather, sl_light_scratch *s) {
    memset(s->of_source, 0, (gather->sources + 1) * sizeof *s->of_source);
    for (size_t m = 0; m < s->samples; m++) s->of_source[s->drawn[m].source + 1]++;
    for (size_t i = 0; i < gather->sources; i++) s->of_source[i + 1] += s->of_source[i];
    for (size_t m = 0; m < s->samples; m++) s->sorted[s->of_source[s->drawn[m].source]++] = s->drawn[m];
}

/* ---- which point ---- */

/* Aims by solid angle; returns the irradiance of radiance 1, 0 where nothing arrives from there. */
static float aim_by_angle(const sl_gather_hits *h, const sl_near_light *near, size_t k, float u1, float u2,
                          sl_vec3 *to_light) {
    double density, distance;
    sl_vec3d direction = sl_near_light_draw(near, (double)u1, (double)u2, &density, &distance);
    *to_light = sl_to_float(sl_scaled(direction, distance));
    if (!(distance > 0.0 && isfinite(distance))) return 0.0f;
    return (float)(near->seen.solid_angle / density) * sl_hit_cosine(h, k, sl_to_float(direction));
}

/* Returns a point uniform on the triangle, seen from p. */
static sl_vec3 aim_by_area(const sl_polygon_light *light, sl_vec3 p, float u1, float u2) {
    float root = sqrtf(u1), w1 = root * (1.0f - u2), w2 = root * u2;
    sl_vec3 d = sl_mad(sl_sub(light->corner[0], p), w1, sl_sub(light->corner[1], light->corner[0]));
    return sl_mad(d, w2, sl_sub(light->corner[2], light->corner[0]));
}

/* Returns area cos cos' / d^2, both cosines times d: the irradiance of radiance 1. */
static float form_of(const sl_gather_hits *h, const sl_polygon_light *light, size_t k, sl_vec3 d) {
    float squared = sl_dot(d, d), over = 1.0f / (squared > 0.0f ? squared : 1.0f),
          emitted = -sl_dot(light->normal, d), cosine = sl_hit_cosine(h, k, d);
    return squared > 0.0f && emitted > 0.0f ? (light->area * over) * (cosine * over) * emitted : 0.0f;
}

float sl_hit_aim(const sl_gather_hits *h, const sl_polygon_light *light, size_t k, float u1, float u2,
                 sl_vec3 *to_light) {
    const sl_vec3 p = sl_hit_position(h, k);
    sl_near_light near;
    near.seen.parts = 0;
    if (sl_light_is_near(light, p)) sl_near_light_make(light, p, sl_hit_normal(h, k), &near);
    if (near.seen.parts) return aim_by_angle(h, &near, k, u1, u2, to_light);
    *to_light = aim_by_area(light, p, u1, u2);
    return form_of(h, light, k, *to_light);
}

static void light_by_side(const sl_gather_view *view, sl_shadow_queue *q, const sl_hit_sample *sample,
                          float u1, float u2) {
    const sl_light_sides *sides = &view->gather->sides;
    const size_t k = sample->slot;
    sl_vec3 to_light;
    float form = sl_hit_aim(&view->scratch->hits, &sides->polygon[sample->source], k, u1, u2, &to_light);
    sl_rgb radiance = view->gather->scene->emitters[sides->emitter[sample->source]].radiance,
           irradiance = sl_rgb_scale(radiance, form * sample->share);
    if (form > 0.0f && sl_rgb_is_finite(irradiance)) sl_push_shadow_ray(q, k, to_light, false, irradiance);
}

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
    *direction = sl_direction_around(sl_hit_normal(h, k), sqrtf(1.0f - u1), u2);
    *irradiance = sl_rgb_scale(e->constant, (float)SL_PI);
    return sl_hit_cosine(h, k, *direction) > 0.0f;
}

static void light_by_sky(const sl_gather_view *view, sl_shadow_queue *q, const sl_hit_sample *sample,
                         float u1, float u2) {
    sl_vec3 direction;
    sl_rgb irradiance;
    bool lit = sample_sky(view, sample->slot, u1, u2, &direction, &irradiance);
    irradiance = sl_rgb_scale(irradiance, lit ? sample->share : 0.0f);
    if (lit && sl_rgb_is_finite(irradiance))
        sl_push_shadow_ray(q, sample->slot, direction, true, irradiance);
}

/* ---- all of it ---- */

void sl_gather_light_by_samples(const sl_gather_view *view, sl_shadow_queue *q) {
    sl_light_scratch *s = view->scratch->light;
    uint64_t key = sl_random_key(view->point->key, 1);
    share_budget(view);
    draw_samples(view, key);
    sort_by_source(view->gather, s);
    /* Steps of the R2 sequence: 1/g and 1/g^2, g^3 = g + 1, as fractions of 2^32. */
    uint32_t u1 = sl_random_bits(key, 3), u2 = sl_random_bits(key, 4);
    for (size_t m = 0; m < s->samples; m++, u1 += 3242174889u, u2 += 2447445414u) {
        const sl_hit_sample *sample = &s->sorted[m];
        const bool side = sample->source < view->gather->sides.count;
        if (q->coherent && !side) sl_flush_shadow_rays(q);
        q->coherent = side; /* hits in a row lie near each other; the sky is anywhere */
        if (side)
            light_by_side(view, q, sample, sl_unit_of_bits(u1), sl_unit_of_bits(u2));
        else light_by_sky(view, q, sample, sl_unit_of_bits(u1), sl_unit_of_bits(u2));
    }
    sl_flush_shadow_rays(q);
}
