/* Direct light on what a gather sees, by shadow rays: every light without extent lights every hit (where
 * there are more than eight, they are drawn from as the others are), emitters and environment are sampled
 * (hit_samples.c).
 *
 * Of more than SL_HIT_SIDES_MAX sides of emitters, or of masked ones, and where lights without extent are
 * many, the light sampler chooses one for each sample (emitters by place: trace/light_tree.h); the numbers
 * that do so are one three-dimensional Kronecker sequence over the hits of the gather (Roberts' R3), rotated
 * by the point's key, so that all hits together are spread evenly over the lights. */
#include "cache/hemisphere/hit_light.h"

#include "base/math.h"
#include "base/random.h"

/* ---- shadow rays ---- */

void sl_flush_shadow_rays(sl_shadow_queue *q) {
    if (q->count == 0) return;
    const sl_gather_hits *h = &q->view->scratch->hits;
    uint32_t occluded =
        sl_trace_occluded(q->view->gather->tracer, &q->rays, q->count, q->coherent, q->counters);
    for (unsigned i = 0; i < q->count; i++) {
        if (occluded >> i & 1u) continue;
        h->irradiance_r[q->slot[i]] += q->light[i].r;
        h->irradiance_g[q->slot[i]] += q->light[i].g;
        h->irradiance_b[q->slot[i]] += q->light[i].b;
    }
    q->count = 0;
}

void sl_push_shadow_ray(sl_shadow_queue *q, size_t k, sl_vec3 to_light, bool far_away, sl_rgb irradiance) {
    const sl_gather_hits *h = &q->view->scratch->hits;
    float offset = sl_scene_offset_at(q->view->gather->scene, q->view->gather->offset, sl_hit_position(h, k));
    unsigned i = q->count++;
    sl_ray16_set_shadow(&q->rays, i, sl_hit_position(h, k),
                        sl_v3(h->geometric_x[k], h->geometric_y[k], h->geometric_z[k]), offset, to_light,
                        far_away, h->triangle[k]);
    q->slot[i] = (uint32_t)k;
    q->light[i] = irradiance;
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

static float unit(uint32_t bits) { return (float)(bits >> 8) * 0x1p-24f; }

/* Given its emitter, a sample stands for 1 / pdf of solid angle; very near to the emitter that grows beyond a
 * hemisphere, which none fills, and single hits would outshine the gather. So it is cut there. */
static float bounded(const sl_light_sample *sample) {
    if (sample->triangle == SL_NO_INDEX || !(sample->chance > 0.0f)) return 1.0f;
    float share = sample->pdf / sample->chance * (float)(2.0 * SL_PI);
    return share < 1.0f ? share : 1.0f;
}

/* One light sample at slot k, one of 1 / share. */
static void light_by_one_of_many(const sl_gather_view *view, sl_shadow_queue *q, size_t k, float select,
                                 float u1, float u2, float share) {
    const sl_gather_hits *h = &view->scratch->hits;
    sl_light_sample sample;
    sl_vec3 n = sl_v3(h->normal_x[k], h->normal_y[k], h->normal_z[k]);
    if (!sl_light_sampler_sample_at(view->gather->sampler, sl_hit_position(h, k), n, select, u1, u2, &sample))
        return;
    float cosine = sl_hit_cosine(h, k, sample.to_light);
    if (!(cosine > 0.0f)) return;
    bool far_away = isinf(sample.distance);
    sl_push_shadow_ray(q, k, far_away ? sample.to_light : sl_scale(sample.to_light, sample.distance),
                       far_away, sl_rgb_scale(sample.radiance, share * cosine * bounded(&sample)));
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
                light_by_one_of_many(view, q, k, unit(select), unit(u1), unit(u2), share);
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
