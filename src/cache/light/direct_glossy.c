/* Glossy lobes and lights with extent. Light samples are bad where the lobe is narrow, directions drawn from
 * the lobe are bad where lights are small: both are taken, each weighted by the power heuristic (Veach and
 * Guibas 1995), since one of them mostly has all but no noise. */
#include "base/math.h"
#include "cache/light/direct_internal.h"
#include "cache/frame/picture_value.h"

/* Both kinds of samples of a pixel wait here for their rays. */
typedef struct {
    const sl_direct *direct;
    sl_vec3 position;
    uint32_t triangle;
    sl_bsdf lobe;
    sl_ray16 rays;
    sl_rgb light[SL_PACKET];     /* what a light sample brings, if nothing is in the way */
    float pdf[SL_PACKET];        /* of lobe samples */
    unsigned count;
    float light_count, lobe_count; /* samples of each kind */
    const sl_lamps *lamps;       /* what light samples are drawn from; NULL: the sampler, by power */
    /* luminance of what the light samples would bring to a diffuse surface, shadows aside */
    float irradiance;
    sl_rgb sum;
} queue;

static float offset_at(const queue *q) {
    return sl_scene_offset_at(q->direct->scene, q->direct->offset, q->position);
}

static void end_light_samples(queue *q, sl_counters *counters) {
    uint32_t occluded =
        q->count ? sl_trace_occluded(q->direct->tracer, &q->rays, q->count, true, counters) : 0;
    for (unsigned i = 0; i < q->count; i++) {
        if (!(occluded >> i & 1u)) q->sum = sl_rgb_add(q->sum, q->light[i]);
    }
    q->count = 0;
}

/* The heuristic's weight of a sample of the technique with density p, which the other one draws with density
 * q; over the samples taken. */
static float weight_of(float p, float samples, float q, float others) {
    p *= samples;
    q *= others;
    return p * p / ((p * p + q * q) * samples);
}

static void add_light_sample(queue *q, const float u[2], sl_counters *counters) {
    sl_light_sample s;
    bool any = q->lamps ? sl_lamps_draw(q->lamps, u, &s)
                        : sl_light_sampler_sample_2d(q->direct->sampler, q->position, u[0], u[1], &s);
    if (!any || s.triangle == q->triangle) return;
    q->irradiance +=
        sl_luminance(s.radiance) * fmaxf(0.0f, sl_dot(q->lobe.normal, s.to_light)) / q->light_count;
    sl_rgb f = sl_bsdf_reflect(&q->lobe, s.to_light, SL_LOBE_GLOSSY);
    if (sl_rgb_is_black(f)) return;
    float weight = weight_of(s.pdf, q->light_count, sl_bsdf_pdf(&q->lobe, s.to_light), q->lobe_count);
    q->light[q->count] = sl_rgb_scale(sl_rgb_mul(f, s.radiance), weight);
    bool far_away = isinf(s.distance);
    sl_ray16_set_shadow(&q->rays, q->count++, q->position, q->lobe.geometric_normal, offset_at(q),
                        far_away ? s.to_light : sl_scale(s.to_light, s.distance), far_away, q->triangle);
    if (q->count == SL_PACKET) end_light_samples(q, counters);
}

/* Returns what a ray of the lobe meets, if that is a light that the sampler knows. */
static sl_rgb light_met(const sl_direct *direct, sl_vec3 direction, uint32_t triangle) {
    const sl_scene *scene = direct->scene;
    if (triangle == SL_NO_INDEX)
        return direct->settings.sun ? sl_environment_radiance(direct->settings.sun, direction)
                                    : sl_grey(0.0f);
    uint32_t emitter = scene->emitter_of_triangle[triangle];
    if (emitter == SL_NO_INDEX) return sl_grey(0.0f);
    bool front = sl_dot(sl_scene_geometric_normal(scene, triangle), direction) < 0.0f;
    return front || scene->emitters[emitter].two_sided ? scene->emitters[emitter].radiance : sl_grey(0.0f);
}

static void end_lobe_samples(queue *q, sl_counters *counters) {
    sl_hit16 hits;
    if (q->count) sl_trace(q->direct->tracer, &q->rays, q->count, true, &hits, counters);
    for (unsigned i = 0; i < q->count; i++) {
        sl_vec3 d = sl_v3(q->rays.direction_x[i], q->rays.direction_y[i], q->rays.direction_z[i]);
        sl_rgb radiance = light_met(q->direct, d, hits.triangle[i]);
        if (sl_rgb_is_black(radiance)) continue;
        float other = q->lamps ? sl_lamps_pdf(q->lamps, d, hits.triangle[i], hits.t[i])
                               : sl_light_sampler_pdf(q->direct->sampler, q->position, d, hits.triangle[i],
                                                      hits.t[i]);
        sl_rgb f = sl_bsdf_reflect(&q->lobe, d, SL_LOBE_GLOSSY);
        q->sum = sl_rgb_add(
            q->sum, sl_rgb_scale(sl_rgb_mul(f, radiance),
                                 weight_of(q->pdf[i], q->lobe_count, other, q->light_count) / q->pdf[i]));
    }
    q->count = 0;
}

static void add_lobe_sample(queue *q, const float u[2], sl_counters *counters) {
    sl_vec3 direction;
    if (!sl_bsdf_sample(&q->lobe, 0.0f, u[0], u[1], &direction)) return;
    float pdf = sl_bsdf_pdf(&q->lobe, direction);
    if (!(pdf > 0.0f)) return;
    q->pdf[q->count] = pdf;
    sl_ray16_set_shadow(&q->rays, q->count++, q->position, q->lobe.geometric_normal, offset_at(q), direction,
                        true, q->triangle);
    if (q->count == SL_PACKET) end_lobe_samples(q, counters);
}

/* Of twice as many samples. Directions from a lobe find a lamp better than points on it where the lamp is
 * wider than the lobe; a small one they miss. */
static uint32_t lobe_samples(const queue *q, uint32_t samples) {
    float exponent = q->lobe.exponent;
    if (!q->lamps) return (uint32_t)(2.0f * (float)samples * exponent / (exponent + 3000.0f));
    float lobe = (float)(2.0 * SL_PI) / (exponent + 2.0f), lamps = (float)q->lamps->solid_angle;
    return (uint32_t)(2.0f * (float)samples * 0.9f * q->lamps->closest * lamps / (lamps + 2.0f * lobe));
}

sl_rgb sl_direct_lobe(const sl_direct *direct, const sl_gbuffer *gbuffer, size_t pixel, float exact,
                      uint32_t samples, sl_direct_scratch *scratch, sl_counters *counters) {
    sl_lit_block one = {.count = 0};
    sl_lit_block_add(direct, gbuffer, pixel, &one);
    queue q = {.direct = direct,
               .position = sl_gbuffer_position(gbuffer, pixel),
               .triangle = gbuffer->id[pixel],
               .lobe = sl_pixel_lobe(direct, gbuffer, pixel)};
    sl_lamps *lamps = &scratch->lamps;
    bool by_angle =
        direct->sides.count && !direct->settings.sun && sl_lamps_look(direct, &q.lobe, q.position, lamps);
    q.lamps = by_angle ? lamps : NULL;
    uint32_t lobes = lobe_samples(&q, samples), lights = 2 * samples - lobes;
    q.light_count = (float)lights;
    q.lobe_count = (float)lobes;
    float u[2];
    for (uint32_t s = 0; s < lights; s++) {
        sl_direct_point_2d(direct, &one, 0, s, SL_STREAM_LAMPS, u);
        add_light_sample(&q, u, counters);
    }
    end_light_samples(&q, counters);
    /* The light that the samples bring to a diffuse surface is known (direct_exact.c): the samples' error
     * there tells of the lobe, too. */
    float off = q.irradiance > 0.0f ? exact / q.irradiance : 0.0f;
    if (!by_angle && off > 0.0f && isfinite(off)) q.sum = sl_rgb_scale(q.sum, off);
    for (uint32_t s = 0; s < lobes; s++) {
        sl_direct_point_2d(direct, &one, 0, s, SL_STREAM_LOBE, u);
        add_lobe_sample(&q, u, counters);
    }
    end_lobe_samples(&q, counters);
    return (sl_rgb){sl_picture_value(q.sum.r), sl_picture_value(q.sum.g), sl_picture_value(q.sum.b)};
}
