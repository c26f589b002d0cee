/* Shared by the ways to light a gather's hits by rays. */
#pragma once

#include "cache/hemisphere/gather_internal.h"

/* Shadow rays wait here until there are sixteen. */
typedef struct sl_shadow_queue {
    const sl_gather_view *view;
    sl_counters *counters;
    unsigned count;
    bool coherent;
    sl_ray16 rays;
    uint32_t slot[SL_PACKET];
    sl_rgb light[SL_PACKET], glossy[SL_PACKET];
} sl_shadow_queue;

/* Irradiance arrives at slot k from a light `to_light` away, or from far away in that direction, unless
 * something is in the way. */
void sl_push_shadow_ray(sl_shadow_queue *q, size_t k, sl_vec3 to_light, bool far_away, sl_rgb irradiance);
void sl_flush_shadow_rays(sl_shadow_queue *q);

static inline const sl_material *sl_hit_material(const sl_gather_view *view, size_t k) {
    return sl_triangle_material(view->gather->scene, view->scratch->hits.triangle[k]);
}

/* Returns the sum of kd over the channels, of ks too where lobes count; 0 where nothing is seen. */
static inline float sl_hit_reflectance(const sl_gather_view *view, size_t k) {
    const sl_gather_hits *h = &view->scratch->hits;
    if (h->triangle[k] == SL_NO_INDEX) return 0.0f;
    const float diffuse = h->diffuse_r[k] + h->diffuse_g[k] + h->diffuse_b[k];
    return view->gather->glossy ? diffuse + 3.0f * sl_rgb_mean(sl_hit_material(view, k)->specular) : diffuse;
}
static inline bool sl_hit_reflects(const sl_gather_view *view, size_t k) {
    return sl_hit_reflectance(view, k) > 0.0f;
}

static inline sl_vec3 sl_hit_position(const sl_gather_hits *h, size_t k) {
    return sl_v3(h->position_x[k], h->position_y[k], h->position_z[k]);
}

static inline sl_vec3 sl_hit_normal(const sl_gather_hits *h, size_t k) {
    return sl_v3(h->normal_x[k], h->normal_y[k], h->normal_z[k]);
}

static inline sl_vec3 sl_hit_true_normal(const sl_gather_hits *h, size_t k) {
    return sl_v3(h->geometric_x[k], h->geometric_y[k], h->geometric_z[k]);
}

static inline sl_vec3 sl_hit_direction(const sl_gather_hits *h, size_t k) {
    return sl_v3(h->direction_x[k], h->direction_y[k], h->direction_z[k]);
}

static inline sl_rgb sl_hit_diffuse(const sl_gather_hits *h, size_t k) {
    return (sl_rgb){h->diffuse_r[k], h->diffuse_g[k], h->diffuse_b[k]};
}

static inline sl_light_points sl_hit_points(const sl_gather_hits *h, size_t first, size_t count) {
    return (sl_light_points){count,
                             h->position_x + first,  h->position_y + first,  h->position_z + first,
                             h->geometric_x + first, h->geometric_y + first, h->geometric_z + first,
                             h->normal_x + first,    h->normal_y + first,    h->normal_z + first};
}

/* Of a unit direction at slot k with the shading normal; 0 if it is below either horizon. */
static inline float sl_hit_cosine(const sl_gather_hits *h, size_t k, sl_vec3 d) {
    float cosine = h->normal_x[k] * d.x + h->normal_y[k] * d.y + h->normal_z[k] * d.z;
    float above = h->geometric_x[k] * d.x + h->geometric_y[k] * d.y + h->geometric_z[k] * d.z;
    return cosine > 0.0f && above > 0.0f ? cosine : 0.0f;
}

/* A way from slot k to a point of an emitter, uniform in area, or, of what is near, by solid angle
 * (near_light.h); returns the irradiance of radiance 1 that it stands for. */
float sl_hit_aim(const sl_gather_hits *h, const sl_polygon_light *light, size_t k, float u1, float u2,
                 sl_vec3 *to_light);

/* Direct light by shadow rays (hit_light.c): from the lights that light every hit, on slots first to first +
 * count, and what is expected of the others there; then samples of these on all slots. */
void sl_gather_light_first(const sl_gather_view *view, size_t first, size_t count, sl_counters *counters);
void sl_gather_light_sampled(const sl_gather_view *view, sl_counters *counters);
/* The samples' part of it, where the sources are few enough to be weighed at every hit (hit_samples.c). */
enum { SL_HIT_SIDES_MAX = 64 };
sl_status sl_hit_sources_make(sl_gather *gather, sl_error *error);
void sl_gather_expect_light(const sl_gather_view *view, size_t first, size_t count);
void sl_gather_light_by_samples(const sl_gather_view *view, sl_shadow_queue *q);

/* For up to `slots` hits. */
sl_status sl_light_scratch_create(const sl_gather *gather, size_t slots, sl_light_scratch **scratch,
                                  sl_error *error);
void sl_light_scratch_destroy(sl_light_scratch *scratch);
