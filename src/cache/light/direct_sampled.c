/* Lights without extent, one ray each; and what is not known unoccluded, the sun, and emitters that are too
 * many or masked: plain light samples. */
#include "cache/light/direct_internal.h"
#include "cache/frame/picture_value.h"

/* ---- lights without extent ---- */

void sl_direct_add_lobe(const sl_direct *direct, const sl_gbuffer *gbuffer, size_t pixel, sl_vec3 to_light,
                        sl_rgb irradiance, float *const glossy[3], size_t p) {
    if (!sl_pixel_is_glossy(gbuffer, direct->scene, pixel)) return;
    sl_bsdf lobe = sl_pixel_lobe(direct, gbuffer, pixel);
    sl_rgb f = sl_bsdf_value(&lobe, to_light, SL_LOBE_GLOSSY);
    glossy[0][p] += sl_picture_value(f.r * irradiance.r);
    glossy[1][p] += sl_picture_value(f.g * irradiance.g);
    glossy[2][p] += sl_picture_value(f.b * irradiance.b);
}

/* The kernel's directions are unit; rays to a light that is near want to end there. */
static void lengthen(const sl_lit_block *block, sl_vec3 light, sl_arrivals *a) {
    for (size_t i = 0; i < block->count; i++) {
        a->x[i] = light.x - block->x[i];
        a->y[i] = light.y - block->y[i];
        a->z[i] = light.z - block->z[i];
    }
}

void sl_direct_delta(const sl_direct *direct, const sl_gbuffer *gbuffer, const sl_lit_block *block,
                     sl_direct_sums *sums, sl_counters *counters) {
    sl_light_points points = sl_lit_points(block);
    sl_arrivals a;
    float visible[SL_LIGHT_BLOCK];
    for (size_t l = 0; l < direct->scene->light_count; l++) {
        sl_light_source source = sl_light_source_of(&direct->scene->lights[l]);
        bool far_away = source.kind == SL_SOURCE_DIRECTIONAL;
        SL_KERNEL_OF(direct->isa, sl_light_arrive)(&points, &source, &a);
        if (!far_away) lengthen(block, source.position, &a);
        sl_direct_visible(direct, block, (sl_aims){a.x, a.y, a.z, far_away}, a.weight, visible, counters);
        for (size_t i = 0; i < block->count; i++) {
            float arrives = a.weight[i] * visible[i];
            if (!(arrives > 0.0f)) continue;
            size_t p = block->pixel[i] - sums->first;
            sl_rgb irradiance = sl_rgb_scale(source.colour, arrives);
            sums->plain[0][p] += irradiance.r;
            sums->plain[1][p] += irradiance.g;
            sums->plain[2][p] += irradiance.b;
            if (direct->glossy) {
                sl_vec3 to_light = sl_normalize_or(sl_v3(a.x[i], a.y[i], a.z[i]), sl_v3(0.0f, 0.0f, 1.0f));
                sl_direct_add_lobe(direct, gbuffer, block->pixel[i], to_light, irradiance, sums->glossy, p);
            }
        }
    }
}

/* ---- samples of lights with extent ---- */

typedef struct {
    float x[SL_LIGHT_BLOCK], y[SL_LIGHT_BLOCK], z[SL_LIGHT_BLOCK];
    float r[SL_LIGHT_BLOCK], g[SL_LIGHT_BLOCK], b[SL_LIGHT_BLOCK]; /* irradiance, shadows aside */
    float wanted[SL_LIGHT_BLOCK], visible[SL_LIGHT_BLOCK];
} light_samples;

static void set_sample(const sl_lit_block *block, size_t i, sl_vec3 to_light, float length, sl_rgb radiance,
                       light_samples *s) {
    float cosine =
        block->normal_x[i] * to_light.x + block->normal_y[i] * to_light.y + block->normal_z[i] * to_light.z;
    float facing = block->geometric_x[i] * to_light.x + block->geometric_y[i] * to_light.y +
                   block->geometric_z[i] * to_light.z;
    cosine = cosine > 0.0f ? cosine : 0.0f;
    sl_put(s->x, s->y, s->z, i, sl_scale(to_light, length));
    sl_rgb_put(s->r, s->g, s->b, i, sl_rgb_scale(radiance, cosine));
    s->wanted[i] = cosine > 0.0f && facing > 0.0f ? 1.0f : 0.0f;
}

static void add_samples(const sl_lit_block *block, const light_samples *s, sl_direct_sums *sums) {
    for (size_t i = 0; i < block->count; i++) {
        size_t p = block->pixel[i] - sums->first;
        bool visible = s->visible[i] > 0.0f; /* what is not may be infinite */
        sums->plain[0][p] += visible ? s->r[i] : 0.0f;
        sums->plain[1][p] += visible ? s->g[i] : 0.0f;
        sums->plain[2][p] += visible ? s->b[i] : 0.0f;
    }
}

/* A direction from the sun alone, or a point of an emitter. False: nothing arrives. */
static bool draw(const sl_direct *direct, const sl_lit_block *block, size_t i, bool sun, const float u[3],
                 sl_light_sample *light) {
    if (sun) {
        *light = (sl_light_sample){.distance = 1.0f};
        light->to_light =
            sl_environment_sample(direct->settings.sun, u[1], u[2], &light->radiance, &light->pdf);
        light->radiance = sl_rgb_scale(light->radiance, light->pdf > 0.0f ? 1.0f / light->pdf : 0.0f);
        return light->pdf > 0.0f;
    }
    sl_vec3 p = sl_v3(block->x[i], block->y[i], block->z[i]),
            n = sl_v3(block->normal_x[i], block->normal_y[i], block->normal_z[i]);
    return sl_light_sampler_sample_at(direct->sampler, p, n, u[0], u[1], u[2], light) &&
           light->triangle != SL_NO_INDEX && light->triangle != block->triangle[i];
}

void sl_direct_sampled(const sl_direct *direct, const sl_lit_block *block, bool sun, sl_direct_sums *sums,
                       sl_counters *counters) {
    light_samples s;
    float scale = 1.0f / (float)sl_direct_samples(direct);
    for (uint32_t sample = 0; sample < sl_direct_samples(direct); sample++) {
        float u0[SL_LIGHT_BLOCK], u1[SL_LIGHT_BLOCK], u2[SL_LIGHT_BLOCK];
        sl_direct_points(direct, block, (sl_sample_range){sample, sample + 1},
                         sun ? SL_STREAM_SUN : SL_STREAM_EMITTERS, 0, u0, u1, u2);
        for (size_t i = 0; i < block->count; i++) {
            sl_light_sample light;
            if (draw(direct, block, i, sun, (float[3]){u0[i], u1[i], u2[i]}, &light))
                set_sample(block, i, light.to_light, light.distance, sl_rgb_scale(light.radiance, scale), &s);
            else
                s.wanted[i] = s.r[i] = s.g[i] = s.b[i] = s.x[i] = s.y[i] = s.z[i] = 0.0f;
        }
        sl_direct_visible(direct, block, (sl_aims){s.x, s.y, s.z, sun}, s.wanted, s.visible, counters);
        add_samples(block, &s, sums);
    }
}
