/* Shades what the gather sees, lit by direct light (hit_light.c, or shadow maps) and by further bounces:
 * outgoing radiance L = kd / pi * E of a Lambertian bounce. */
#include "cache/hemisphere/hit_light.h"

#include "base/counters.h"
#include "base/math.h"
#include "scene/surface_rules.h"
#include "scene/texture.h"

/* Radiance below this is 0 (its products would be denormal), above that it is cut, so that sums of w L stay
 * finite in floats. */
#define RADIANCE_MIN 1e-30f
#define RADIANCE_MAX 1e20f

/* ---- surfaces -------------------------------------------------------------------------------- */

static void clear_slot(const sl_gather_hits *h, size_t k) {
    h->depth[k] = 0.0f;
    h->normal_x[k] = h->normal_y[k] = h->normal_z[k] = 0.0f;
    h->geometric_x[k] = h->geometric_y[k] = h->geometric_z[k] = 0.0f;
    h->diffuse_r[k] = h->diffuse_g[k] = h->diffuse_b[k] = 0.0f;
}

static void load_slot(const sl_gather *gather, const sl_gather_hits *h, size_t k, const uint8_t **texel) {
    const sl_scene *s = gather->scene;
    const uint32_t triangle = h->triangle[k];
    const float w1 = h->w1[k], w2 = h->w2[k];
    sl_put(h->normal_x, h->normal_y, h->normal_z, k, sl_vertex_normal_at(s, triangle, w1, w2));
    sl_put(h->geometric_x, h->geometric_y, h->geometric_z, k, sl_scene_geometric_normal(s, triangle));
    const sl_material *material = sl_triangle_material(s, triangle);
    sl_rgb_put(h->diffuse_r, h->diffuse_g, h->diffuse_b, k, material->diffuse);
    *texel = NULL;
    if (material->texture == SL_NO_INDEX) return;
    const sl_texture_place at = sl_texture_place_at(s, triangle, w1, w2);
    *texel = sl_texture_nearest_texel(&s->textures[material->texture], at.u, at.v);
    __builtin_prefetch(*texel);
}

/* Places the surface of slot k where the last mirror shows it; how far away and askew it is, is the first
 * one's. */
static void put_mirrored(const sl_gather_view *view, size_t k) {
    const sl_gather_hits *h = &view->scratch->hits;
    const sl_mirrored_hit *m = sl_gather_mirrored(view, k);
    if (!m || h->triangle[k] == SL_NO_INDEX) return;
    sl_put(h->position_x, h->position_y, h->position_z, k, m->position);
    sl_rgb_put(h->diffuse_r, h->diffuse_g, h->diffuse_b, k, sl_rgb_mul(sl_hit_diffuse(h, k), m->share));
    h->cosine[k] = m->cosine;
}

sl_rgb sl_gather_lobe(const sl_gather_view *view, size_t k) {
    const sl_gather_hits *h = &view->scratch->hits;
    if (h->triangle[k] == SL_NO_INDEX) return sl_grey(0.0f);
    const sl_material *m = sl_hit_material(view, k);
    const sl_vec3 n = sl_hit_normal(h, k), way = sl_hit_direction(h, k);
    const float cosine = fmaxf(0.0f, -sl_dot(n, sl_normalize_or(way, n)));
    const float part = (1.0f + m->exponent * cosine) / (1.0f + m->exponent);
    return sl_rgb_scale(sl_rgb_mul(m->specular, sl_gather_throughput(view, k)), part);
}

static void take_lobe_for_diffuse(const sl_gather_view *view, size_t k) {
    const sl_gather_hits *h = &view->scratch->hits;
    sl_rgb_add_at(h->diffuse_r, h->diffuse_g, h->diffuse_b, k, sl_gather_lobe(view, k));
}

/* A texel that a ray finds is mostly in no cache: all are sent for before the first is read. */
static void make_surfaces(const sl_gather_view *view, size_t first, size_t count) {
    const uint8_t **texel = view->scratch->texel;
    const sl_gather *gather = view->gather;
    const sl_gather_hits *h = &view->scratch->hits;
    for (size_t k = first; k < first + count; k++) {
        texel[k] = NULL;
        if (h->triangle[k] == SL_NO_INDEX) clear_slot(h, k);
        else load_slot(gather, h, k, &texel[k]);
        h->irradiance_r[k] = h->irradiance_g[k] = h->irradiance_b[k] = 0.0f;
        h->glossy_r[k] = h->glossy_g[k] = h->glossy_b[k] = 0.0f;
    }
    for (size_t k = first; k < first + count; k++) {
        if (!texel[k]) continue;
        h->diffuse_r[k] *= sl_srgb_to_linear[texel[k][0]];
        h->diffuse_g[k] *= sl_srgb_to_linear[texel[k][1]];
        h->diffuse_b[k] *= sl_srgb_to_linear[texel[k][2]];
    }
    SL_KERNEL_OF(gather->isa, sl_gather_surfaces)(h, first, count, view->eye);
    if (sl_gather_is_onward(view, first)) sl_gather_put_onward(view, first, count);
    for (size_t k = first; gather->mirrors && k < first + count; k++) put_mirrored(view, k);
    for (size_t k = first; gather->glossy && view->second_alone && k < first + count; k++)
        take_lobe_for_diffuse(view, k);
}

/* A shading normal may tilt the gather below the geometric horizon: nothing arrives from there, neither from
 * the surface itself nor from what lies behind it. */
static bool is_below_horizon(const sl_gather_view *view, size_t k) {
    return !(sl_dot(view->point->geometric_normal, sl_hit_direction(&view->scratch->hits, k)) > 0.0f);
}

static void drop_below_horizon(const sl_gather_view *view, size_t first, size_t count) {
    const sl_gather_hits *h = &view->scratch->hits;
    if (sl_dot(view->point->geometric_normal, view->frame.z) >= 1.0f - 1e-6f) return; /* not tilted */
    for (size_t k = first; k < first + count; k++) {
        if (is_below_horizon(view, k)) h->triangle[k] = SL_NO_INDEX;
    }
}

/* ---- direct light by shadow maps ------------------------------------------------------------- */

static void light_by_maps(const sl_gather_view *view, size_t first, size_t count, sl_counters *counters) {
    const sl_gather_hits *h = &view->scratch->hits;
    const unsigned parts = SL_MAPPED_LIGHTS | SL_MAPPED_SKY | SL_MAPPED_FEW;
    for (size_t k = first; k < first + count; k += SL_LIGHT_BLOCK) {
        sl_light_points block = sl_hit_points(h, k, sl_fewer(first + count - k, SL_LIGHT_BLOCK));
        sl_shadow_maps_irradiance(view->gather->settings.maps, &block, parts, h->irradiance_r + k,
                                  h->irradiance_g + k, h->irradiance_b + k, counters);
    }
}

/* Adds what lobes would send back of the irradiance at hits if they were diffuse. */
static void add_as_diffuse(const sl_gather_view *view, size_t first, size_t count) {
    const sl_gather_hits *h = &view->scratch->hits;
    const float per_pi = (float)(1.0 / SL_PI);
    for (size_t k = first; k < first + count; k++) {
        const sl_rgb ks = sl_gather_lobe(view, k);
        h->glossy_r[k] += per_pi * ks.r * h->irradiance_r[k];
        h->glossy_g[k] += per_pi * ks.g * h->irradiance_g[k];
        h->glossy_b[k] += per_pi * ks.b * h->irradiance_b[k];
    }
}

static sl_second_points points_of(const sl_gather_hits *h, size_t first, size_t count) {
    return (sl_second_points){.count = count,
                              .triangle = h->triangle + first,
                              .position_x = h->position_x + first,
                              .position_y = h->position_y + first,
                              .position_z = h->position_z + first,
                              .normal_x = h->normal_x + first,
                              .normal_y = h->normal_y + first,
                              .normal_z = h->normal_z + first};
}

/* Light that has met more than one surface before it arrives at what the gather sees. Lobes reflect it as if
 * they were diffuse. */
static void add_second_light(const sl_gather_view *view, size_t first, size_t count, sl_counters *counters) {
    const sl_second_light *second = view->gather->settings.second;
    const sl_gather_hits *h = &view->scratch->hits;
    bool *missed = view->second_alone ? NULL : view->scratch->onward.missed;
    const sl_second_points points = points_of(h, first, count);
    second->irradiance(second->context, &points, h->irradiance_r + first, h->irradiance_g + first,
                       h->irradiance_b + first, missed ? missed + first : NULL, counters);
    if (missed && !sl_gather_is_onward(view, first)) sl_gather_mark_onward(view, first, count);
    if (view->gather->glossy && !view->second_alone) add_as_diffuse(view, first, count);
}

sl_gather_hits_seen sl_gather_last_hits(const sl_gather_scratch *scratch) {
    const sl_gather_hits *h = &scratch->hits;
    return (sl_gather_hits_seen){.points = points_of(h, 0, scratch->slots),
                                 .diffuse = {h->diffuse_r, h->diffuse_g, h->diffuse_b}};
}

/* ---- radiance of the cells ------------------------------------------------------------------- */

static float sane(float radiance, uint64_t *nonfinite) {
    if (radiance != radiance) {
        ++*nonfinite;
        return 0.0f;
    }
    if (radiance > RADIANCE_MAX) return RADIANCE_MAX;
    return radiance >= RADIANCE_MIN ? radiance : 0.0f;
}

static sl_rgb emission_seen(const sl_gather_view *view, size_t k) {
    const sl_gather_hits *h = &view->scratch->hits;
    const sl_scene *scene = view->gather->scene;
    const bool mirrored = sl_gather_mirrored(view, k), emission = view->gather->settings.emission || mirrored;
    if (h->triangle[k] == SL_NO_INDEX) {
        const sl_environment *environment = emission ? &scene->environment
                                                     : view->gather->settings.background;
        if (!environment || (!mirrored && is_below_horizon(view, k))) return sl_grey(0.0f);
        return sl_environment_radiance(environment, sl_normalize_or(sl_hit_direction(h, k), view->frame.z));
    }
    if (!emission) return sl_grey(0.0f);
    const sl_material *material = sl_hit_material(view, k);
    return h->back[k] > 0.0f && !material->emission_two_sided ? sl_grey(0.0f) : material->emission;
}

sl_rgb sl_gather_emission(const sl_gather_view *view, size_t k) {
    if (view->second_alone || (sl_gather_is_onward(view, k) && !sl_gather_mirrored(view, k)))
        return sl_grey(0.0f);
    return sl_rgb_mul(sl_gather_throughput(view, k), emission_seen(view, k));
}

/* The mean of the rays of a cell; the nearest thing that they met, and what the first one did. */
static void write_slot(const sl_gather_view *view, size_t k, float length, uint64_t *nonfinite) {
    const sl_gather_hits *h = &view->scratch->hits;
    const sl_gather_planes *p = &view->scratch->planes;
    uint32_t cell = view->scratch->slot_cell[k];
    float share = view->scratch->slot_share[k];
    const float inverse_pi = (float)(1.0 / SL_PI);
    sl_rgb radiance = {h->diffuse_r[k] * inverse_pi * h->irradiance_r[k] + h->glossy_r[k],
                       h->diffuse_g[k] * inverse_pi * h->irradiance_g[k] + h->glossy_g[k],
                       h->diffuse_b[k] * inverse_pi * h->irradiance_b[k] + h->glossy_b[k]};
    radiance = sl_rgb_add(radiance, sl_gather_emission(view, k));
    radiance = (sl_rgb){share * sane(radiance.r, nonfinite), share * sane(radiance.g, nonfinite),
                        share * sane(radiance.b, nonfinite)};
    float nearest_depth = 2.0f * view->gather->offset;
    bool hit = h->triangle[k] != SL_NO_INDEX;
    float nearness = hit ? 1.0f / (h->depth[k] > nearest_depth ? h->depth[k] : nearest_depth) : 0.0f;
    if (k >= view->gather->tables->used) {
        sl_rgb_add_at(p->r, p->g, p->b, cell, radiance);
        if (!sl_gather_is_onward(view, k))
            p->nearness[cell] = nearness > p->nearness[cell] ? nearness : p->nearness[cell];
        return;
    }
    sl_rgb_put(p->r, p->g, p->b, cell, radiance);
    p->nearness[cell] = p->first[cell] = nearness;
    p->distance[cell] = hit ? h->depth[k] * length : INFINITY;
}

/* ---- geometry ---- */

/* Counts in what the first ray of a cell met, whatever the light; a mirror where it met one. */
static void note_geometry(const sl_gather_view *view, size_t k, float length, float *nearest,
                          double *back_weight) {
    const sl_gather_tables *t = view->gather->tables;
    const sl_gather_scratch *s = view->scratch;
    const sl_gather_hits *h = &s->hits;
    const sl_mirrored_hit *m = sl_gather_mirrored(view, k);
    if (h->triangle[k] == SL_NO_INDEX) return;
    *back_weight += (double)((m ? m->back : h->back[k]) * t->weight[s->slot_cell[k]]);
    const float above = sl_dot(sl_hit_direction(h, k), view->point->geometric_normal);
    if (!(h->cosine[k] > 0.0f) || !(m || above > 0.0f)) return;
    float reach = h->depth[k] * length * length / h->cosine[k]; /* r / cos theta' */
    if (reach < *nearest) *nearest = reach;
}

/* ---- all of it ---- */

/* Slots first to first + count: what they see, lit by all but samples. */
static void begin_slots(const sl_gather_view *view, size_t first, size_t count, sl_counters *counters) {
    if (!sl_gather_is_onward(view, first)) drop_below_horizon(view, first, count);
    if (view->gather->mirrors) sl_gather_follow_mirrors(view, first, count, counters);
    make_surfaces(view, first, count);
    if (view->gather->settings.second) add_second_light(view, first, count, counters);
    if (view->second_alone) return;
    if (view->gather->settings.maps) light_by_maps(view, first, count, counters);
    else sl_gather_light_first(view, first, count, counters);
}

static void light_directly(const sl_gather_view *view, sl_counters *counters) {
    const size_t used = view->gather->tables->used;
    sl_gather_add_rays(view, counters);
    begin_slots(view, used, view->scratch->slots - used, counters);
    if (view->scratch->onward.count) {
        sl_gather_go_on(view, counters);
        begin_slots(view, view->scratch->onward.first, view->scratch->onward.count, counters);
    }
    if (!view->gather->settings.maps) sl_gather_light_sampled(view, counters);
}

void sl_gather_shade(const sl_gather_view *view, float *nearest, double *back_weight, sl_counters *counters) {
    const sl_gather *gather = view->gather;
    const sl_gather_tables *t = gather->tables;
    const sl_gather_scratch *s = view->scratch;
    uint64_t nonfinite = 0;
    *nearest = INFINITY;
    *back_weight = 0.0;
    begin_slots(view, 0, t->used, counters);
    if (!view->second_alone) light_directly(view, counters);
    for (size_t k = 0; k < s->slots; k++) {
        float length = t->kind == SL_GATHER_RAYS ? 1.0f : t->length[s->slot_cell[k]];
        write_slot(view, k, length, &nonfinite);
        if (k < t->used) note_geometry(view, k, length, nearest, back_weight);
    }
    if (nonfinite) sl_count(counters, SL_COUNT_NONFINITE, nonfinite);
}
