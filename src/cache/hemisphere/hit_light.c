/* Direct light on what a gather sees, by shadow rays: every light without extent lights every hit (where
 * there are more than eight, they are drawn from as the others are), emitters and environment are sampled
 * (hit_samples.c).
 *
 * Of more than SL_HIT_SIDES_MAX sides of emitters, or of masked ones, and where lights without extent are
 * many, the light sampler chooses one for each sample (emitters by place: trace/light_tree.h); the numbers
 * that do so are one three-dimensional Kronecker sequence over the hits of the gather (Roberts' R3), rotated
 * by the point's key, so that all hits together are spread evenly over the lights. */
#include "cache/hemisphere/hit_light.h"

#include "base/random.h"
#include "trace/bsdf.h"

/* ---- shadow rays ---- */

void sl_flush_shadow_rays(sl_shadow_queue *q) {
    if (q->count == 0) return;
    const sl_gather_hits *h = &q->view->scratch->hits;
    uint32_t occluded =
        sl_trace_occluded(q->view->gather->tracer, &q->rays, q->count, q->coherent, q->counters);
    for (unsigned i = 0; i < q->count; i++) {
        if (occluded >> i & 1u) continue;
        sl_rgb_add_at(h->irradiance_r, h->irradiance_g, h->irradiance_b, q->slot[i], q->light[i]);
        if (q->view->gather->glossy)
            sl_rgb_add_at(h->glossy_r, h->glossy_g, h->glossy_b, q->slot[i], q->glossy[i]);
    }
    q->count = 0;
}

/* Returns the radiance that irradiance from there sends back to the gather by the surface's lobe. */
static sl_rgb glossy_radiance(const sl_gather_view *view, size_t k, sl_vec3 to_light, sl_rgb irradiance) {
    const sl_gather_hits *h = &view->scratch->hits;
    const sl_material *m = sl_hit_material(view, k);
    if (!sl_material_is_glossy(m)) return sl_grey(0.0f);
    const sl_vec3 n = sl_hit_normal(h, k), way = sl_hit_direction(h, k);
    const sl_surface surface = {.normal = n, .geometric_normal = n, .material = m};
    const sl_bsdf lobe = sl_bsdf_make(&surface, sl_normalize_or(sl_neg(way), n), SL_LOBE_GLOSSY);
    const sl_rgb f = sl_bsdf_value(&lobe, sl_normalize_or(to_light, n), SL_LOBE_GLOSSY);
    return sl_rgb_mul(sl_rgb_mul(irradiance, f), sl_gather_throughput(view, k));
}

void sl_push_shadow_ray(sl_shadow_queue *q, size_t k, sl_vec3 to_light, bool far_away, sl_rgb irradiance) {
    const sl_gather_hits *h = &q->view->scratch->hits;
    float offset = sl_scene_offset_at(q->view->gather->scene, q->view->gather->offset, sl_hit_position(h, k));
    unsigned i = q->count++;
    sl_ray16_set_shadow(&q->rays, i, sl_hit_position(h, k), sl_hit_true_normal(h, k), offset, to_light,
                        far_away, h->triangle[k]);
    q->slot[i] = (uint32_t)k;
    q->light[i] = irradiance;
    if (q->view->gather->glossy) q->glossy[i] = glossy_radiance(q->view, k, to_light, irradiance);
    if (q->count == SL_PACKET) sl_flush_shadow_rays(q);
}

/* ---- lights without extent ---- */

static void light_by_each(const sl_gather_view *view, size_t first, size_t count, sl_shadow_queue *q) {
    const sl_scene *scene = view->gather->scene;
    const sl_gather_hits *h = &view->scratch->hits;
    for (size_t i = 0; i < scene->light_count; i++) {
        for (size_t k = first; k < first + count; k++) {
            sl_vec3 to_light;
            float distance;
            sl_rgb facing;
            if (!sl_hit_reflects(view, k)) continue;
            if (!sl_light_illuminate(&scene->lights[i], sl_hit_position(h, k), &to_light, &distance, &facing))
                continue;
            float cosine = sl_hit_cosine(h, k, to_light);
            if (!(cosine > 0.0f)) continue;
            bool far_away = isinf(distance);
            sl_push_shadow_ray(q, k, far_away ? to_light : sl_scale(to_light, distance), far_away,
                               sl_rgb_scale(facing, cosine));
        }
        sl_flush_shadow_rays(q); /* packets hold rays to one light */
    }
}

/* ---- one of many sources ---- */

/* Aims anew at the emitter that the sampler has chosen: at what is near by solid angle, or single hits would
 * outshine the gather. */
static void aim_at_emitter(const sl_gather_view *view, size_t k, const sl_light_sample *sample, float u1,
                           float u2, sl_vec3 *to_light, sl_rgb *irradiance) {
    const sl_scene *scene = view->gather->scene;
    if (sample->triangle == SL_NO_INDEX || sl_scene_has_alpha(scene, sample->triangle)) return;
    const sl_emitter *emitter = &scene->emitters[sample->entry];
    const sl_polygon_light front = sl_polygon_light_of(scene, emitter, false);
    const bool back = sl_dot(front.normal, sample->to_light) > 0.0f;
    const sl_polygon_light light = back ? sl_polygon_light_of(scene, emitter, true) : front;
    const float form = sl_hit_aim(&view->scratch->hits, &light, k, u1, u2, to_light);
    *irradiance = sl_rgb_scale(emitter->radiance, form / sample->chance);
}

/* One light sample at slot k, one of 1 / share. */
static void light_by_one_of_many(const sl_gather_view *view, sl_shadow_queue *q, size_t k, float select,
                                 float u1, float u2, float share) {
    const sl_gather_hits *h = &view->scratch->hits;
    sl_light_sample sample;
    if (!sl_light_sampler_sample_at(view->gather->sampler, sl_hit_position(h, k), sl_hit_normal(h, k), select,
                                    u1, u2, &sample))
        return;
    const bool far_away = isinf(sample.distance);
    sl_vec3 to_light = far_away ? sample.to_light : sl_scale(sample.to_light, sample.distance);
    sl_rgb irradiance = sl_rgb_scale(sample.radiance, sl_hit_cosine(h, k, sample.to_light));
    aim_at_emitter(view, k, &sample, u1, u2, &to_light, &irradiance);
    if (sl_rgb_max(irradiance) > 0.0f && sl_rgb_is_finite(irradiance))
        sl_push_shadow_ray(q, k, to_light, far_away, sl_rgb_scale(irradiance, share));
}

/* Steps of the R3 sequence: powers of 1/g, g^4 = g + 1, as fractions of 2^32. */
static void light_by_many(const sl_gather_view *view, sl_shadow_queue *q) {
    uint64_t key = sl_random_key(view->point->key, 1);
    uint32_t select = sl_random_bits(key, 0), u1 = sl_random_bits(key, 1), u2 = sl_random_bits(key, 2);
    uint32_t samples = view->gather->settings.hit_samples;
    float share = 1.0f / (float)samples;
    for (uint32_t i = 0; i < samples; i++) {
        for (size_t k = 0; k < view->scratch->slots;
             k++, select += 3518319155u, u1 += 2882110345u, u2 += 2360945575u) {
            if (sl_hit_reflects(view, k))
                light_by_one_of_many(view, q, k, sl_unit_of_bits(select), sl_unit_of_bits(u1),
                                     sl_unit_of_bits(u2), share);
        }
    }
    sl_flush_shadow_rays(q);
}

void sl_gather_light_first(const sl_gather_view *view, size_t first, size_t count, sl_counters *counters) {
    sl_shadow_queue queue = {.view = view, .counters = counters, .coherent = true};
    if (view->gather->every_light) light_by_each(view, first, count, &queue);
    if (view->gather->sources) sl_gather_expect_light(view, first, count);
}

void sl_gather_light_sampled(const sl_gather_view *view, sl_counters *counters) {
    sl_shadow_queue queue = {.view = view, .counters = counters, .coherent = false};
    if (view->gather->sources) sl_gather_light_by_samples(view, &queue);
    if (view->gather->sampler) light_by_many(view, &queue);
}
