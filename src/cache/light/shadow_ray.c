/* Rays: one to a light without extent, n x n jittered ones to an area light (the estimator that the paper's
 * hardware competes with, and what is left where no picture can be taken). */
#include <float.h>
#include <math.h>

#include "base/math.h"
#include "base/random.h"
#include "cache/light/light_sample_internal.h"

/* ---- lights without extent ---- */

double sl_light_point_form(const sl_sampled_light *light, const sl_lit_point *point, sl_vec3d *to_light,
                           double *distance) {
    sl_vec3d axis = sl_to_double(light->direction);
    double strength = 1.0;
    *distance = INFINITY;
    *to_light = sl_scaled(axis, -1.0);
    if (light->kind != SL_SOURCE_DIRECTIONAL) {
        sl_vec3d d = sl_subd(sl_to_double(light->position), sl_to_double(point->position));
        double squared = sl_dotd(d, d);
        if (!(squared > 0.0) || !isfinite(squared)) return 0.0;
        *distance = sqrt(squared);
        *to_light = sl_scaled(d, 1.0 / *distance);
        strength = 1.0 / squared;
        if (light->kind == SL_SOURCE_SPOT)
            strength *= (double)sl_spot_falloff((float)-sl_dotd(*to_light, axis), light->cos_inner,
                                                light->cos_outer);
    }
    double cosine = sl_dotd(sl_to_double(point->normal), *to_light);
    if (!(cosine > 0.0) || !(sl_dotd(sl_to_double(point->geometric_normal), *to_light) > 0.0)) return 0.0;
    return fmin(cosine * strength, (double)FLT_MAX);
}

/* ---- packets ---- */

typedef struct {
    const sl_light_sampling *sampling;
    sl_counters *counters;
    sl_vec3 eye;
    uint32_t skip;
    unsigned count;
    sl_ray16 rays;
    double weight[SL_PACKET], lobe[SL_PACKET];
    sl_light_sums sums;
} packet;

static void flush(packet *p) {
    uint32_t hidden =
        p->count ? sl_trace_occluded(p->sampling->tracer, &p->rays, p->count, true, p->counters) : 0;
    for (unsigned i = 0; i < p->count; i++) {
        if (hidden >> i & 1) continue;
        p->sums.seen += p->weight[i];
        p->sums.seen_squares += p->weight[i] * p->weight[i];
        p->sums.lobe += p->lobe[i];
    }
    p->count = 0;
}

/* d: of any length, the place aimed at being at far = 1. */
static void add_ray(packet *p, sl_vec3 d, float far, double weight, double lobe) {
    unsigned i = p->count++;
    sl_ray16_set(&p->rays, i, p->eye, d, 0.0f, far, p->skip);
    p->weight[i] = weight;
    p->lobe[i] = lobe;
    p->sums.all += weight;
    p->sums.all_squares += weight * weight;
    if (p->count == SL_PACKET) flush(p);
}

sl_vec3 sl_light_lifted(const sl_light_sampling *sampling, const sl_lit_point *point) {
    bool scattered = sl_scene_is_scattered(sampling->scene);
    float lift = scattered ? SL_LIGHT_LIFT * sl_scene_coordinate_near(sampling->scene, point->position)
                           : sampling->lift;
    return sl_mad(point->position, lift, point->geometric_normal);
}

sl_vec3 sl_light_eye(const sl_light_sampling *sampling, sl_vec3 lifted, sl_vec3d to_light) {
    double length = sl_lengthd(to_light),
           step = length > 0.0 ? fmin((double)sampling->step / length, 0.25) : 0.0;
    return sl_to_float(sl_addd(sl_to_double(lifted), sl_scaled(to_light, step)));
}

static packet packet_at(const sl_light_sampling *sampling, const sl_lit_point *point, sl_vec3 eye,
                        sl_counters *counters) {
    return (packet){.sampling = sampling, .counters = counters, .eye = eye, .skip = point->triangle};
}

/* From the eye to a place, but for the last of the way; or, far being infinite, as far as it goes. */
static bool is_hidden(const sl_light_sampling *sampling, const sl_lit_point *point, sl_vec3 eye, sl_vec3d d,
                      double far, sl_counters *counters) {
    packet p = packet_at(sampling, point, eye, counters);
    if (!(sl_lengthd(d) > 0.0) || !sl_is_finite(sl_to_float(d))) return false;
    add_ray(&p, sl_to_float(d), (float)far, 1.0, 0.0);
    flush(&p);
    return !(p.sums.seen > 0.0);
}

double sl_light_without_extent(const sl_light_sampling *sampling, const sl_sampled_light *light,
                               const sl_lit_point *point, sl_counters *counters) {
    sl_vec3d to;
    double distance, value = sl_light_point_form(light, point, &to, &distance);
    if (!(value > 0.0)) {
        sl_count(counters, SL_COUNT_LIGHT_SAMPLES_SKIPPED, 1);
        return 0.0;
    }
    bool sun = light->kind == SL_SOURCE_DIRECTIONAL;
    sl_vec3 eye = sl_light_eye(sampling, sl_light_lifted(sampling, point),
                               sl_scaled(to, sun ? (double)sampling->scene->scale : distance));
    sl_vec3d d = sun ? to : sl_subd(sl_to_double(light->position), sl_to_double(eye));
    return is_hidden(sampling, point, eye, d, sun ? INFINITY : 1.0 - SL_LIGHT_MARGIN, counters) ? 0.0 : value;
}

/* ---- area lights ---- */

static sl_vec3 normal_of(const sl_sampled_light *light, size_t triangle) {
    return sl_normalize_or(sl_to_float(sl_light_cross(light, triangle)), sl_v3(0, 0, 0));
}

/* The strata of packet k: 4 x 4 neighbours where n allows it, else a row's. Returns how many. */
static unsigned strata_of(int n, int k, int32_t column[SL_AIMED], int32_t row[SL_AIMED]) {
    unsigned count = 0;
    for (int i = 0; i < SL_AIMED; i++) {
        int at = k * SL_AIMED + i, tiles = n / 4;
        bool tiled = n % 4 == 0;
        column[i] = tiled ? 4 * (k % tiles) + i % 4 : at % n;
        row[i] = tiled ? 4 * (k / tiles) + i / 4 : at / n;
        count += at < n * n;
    }
    return count;
}

/* By the position's bits alone: a point asked again gets the same answer. */
static uint64_t jitter_key(const sl_lit_point *point, size_t light) {
    uint64_t hash = sl_hash64(sl_float_bits(point->position.x));
    hash = sl_hash64(hash ^ sl_float_bits(point->position.y));
    hash = sl_hash64(hash ^ sl_float_bits(point->position.z));
    return sl_random_key(hash, light);
}

bool sl_light_middle_hidden(const sl_light_query *q) {
    sl_vec3d d = sl_subd(sl_addd(sl_to_double(q->point->position), q->middle), sl_to_double(q->eye));
    return is_hidden(q->sampling, q->point, q->eye, d, 1.0 - SL_LIGHT_MARGIN, q->counters);
}

/* Places and normals on a light, relative to the point. */
static void aim(const sl_light_query *query, const float *u, const float *v, sl_aimed_rays *rays) {
    const sl_sampled_light *light = &query->sampling->lights->light[query->light];
    const sl_light_surface *surface = &query->sampling->shape[query->light].surface;
    const sl_vec3d position = sl_to_double(query->point->position);
    const sl_vec3 corner = sl_to_float(sl_subd(surface->corner, position)), e1 = sl_to_float(surface->e1),
                  e2 = sl_to_float(surface->e2);
    for (unsigned i = 0; i < SL_AIMED; i++) {
        sl_vec3 d = sl_mad(sl_mad(corner, u[i], e1), v[i], e2), normal = light->normal;
        if (!surface->parallelogram) {
            size_t triangle;
            double weight[2];
            const double at[2] = {(double)u[i], (double)v[i]};
            const sl_vec3d place = sl_light_surface_point(light, surface, at, &triangle, weight);
            d = sl_to_float(sl_subd(place, position));
            normal = light->kind == SL_SOURCE_AREA ? normal : normal_of(light, triangle);
        }
        sl_put(rays->x, rays->y, rays->z, i, d);
        sl_put(rays->normal_x, rays->normal_y, rays->normal_z, i, normal);
    }
}

/* Makes the numbers of packet k; returns how many. */
static unsigned numbers_of(const sl_light_query *query, uint64_t jitter, int k, float u[SL_AIMED],
                           float v[SL_AIMED]) {
    const sl_light_numbers *numbers = query->numbers;
    unsigned count = 0;
    if (!numbers) {
        int32_t column[SL_AIMED], row[SL_AIMED];
        count = strata_of(query->rays, k, column, row);
        SL_KERNEL_OF(query->sampling->isa, sl_ray_jitter)(jitter, query->rays, column, row, u, v);
        return count;
    }
    for (uint32_t i = 0; i < SL_AIMED; i++) {
        float at[3];
        uint32_t index = (uint32_t)(k * SL_AIMED) + i;
        sl_sequence_point(numbers->sequence, numbers->key, 0, numbers->first + index, at);
        u[i] = at[0], v[i] = at[1];
        count += index < numbers->count;
    }
    return count;
}

/* Returns what the lobe reflects from a place `d` away on a light of radiance 1, normal m and that area, by
 * the balance heuristic: f cos / density. */
static double lobe_term(const sl_lit_lobe *lobe, const sl_lit_point *point, sl_vec3 d, sl_vec3 m,
                        double area) {
    sl_vec3d way = sl_to_double(d);
    double squared = sl_dotd(way, way), distance = sqrt(squared);
    sl_vec3 to_light = sl_to_float(sl_scaled(way, 1.0 / distance));
    double facing = fabs((double)sl_dot(m, to_light)), arriving = (double)sl_dot(point->normal, to_light);
    if (!(facing > 0.0 && arriving > 0.0 && squared > 0.0)) return 0.0;
    double density =
        lobe->points * squared / (area * facing) + lobe->draws * (double)sl_bsdf_pdf(&lobe->bsdf, to_light);
    return (double)sl_bsdf_value(&lobe->bsdf, to_light, SL_LOBE_GLOSSY).r * arriving / density;
}

sl_light_sums sl_light_rays(const sl_light_query *query) {
    const sl_light_sampling *sampling = query->sampling;
    const sl_light_shape_info *shape = &sampling->shape[query->light];
    const sl_light_surface *surface = &shape->surface;
    const sl_sampled_light *light = &sampling->lights->light[query->light];
    const sl_lit_point *point = query->point;
    const int n = query->rays, rays_in_all = query->numbers ? (int)query->numbers->count : n * n;
    const uint64_t key = jitter_key(point, query->light);
    const sl_vec3d position = sl_to_double(point->position),
                   back = sl_subd(position, sl_to_double(query->eye));
    const double each = query->numbers ? 1.0 : (double)n * (double)n;
    const sl_ray_receiver receiver = {.normal = point->normal,
                                      .geometric = point->geometric_normal,
                                      .two_sided = light->two_sided,
                                      .scale = (float)(surface->area / (each * SL_PI)),
                                      .flatness = (float)(2.0 * shape->flatness),
                                      .margin = (float)SL_LIGHT_MARGIN};
    packet p = packet_at(sampling, point, query->eye, query->counters);
    for (int k = 0; k * SL_AIMED < rays_in_all; k++) {
        float u[SL_AIMED], v[SL_AIMED];
        sl_aimed_rays rays;
        unsigned count = numbers_of(query, key, k, u, v);
        aim(query, u, v, &rays);
        SL_KERNEL_OF(sampling->isa, sl_ray_weights)(&receiver, &rays);
        for (unsigned i = 0; i < count; i++) {
            if (!(rays.weight[i] > 0.0f)) continue;
            sl_vec3 d = sl_v3(rays.x[i], rays.y[i], rays.z[i]),
                    m = sl_v3(rays.normal_x[i], rays.normal_y[i], rays.normal_z[i]);
            double lobe = query->lobe ? lobe_term(query->lobe, point, d, m, surface->area) : 0.0;
            add_ray(&p,
                    sl_v3((float)((double)d.x + back.x), (float)((double)d.y + back.y),
                          (float)((double)d.z + back.z)),
                    rays.far[i], (double)rays.weight[i], lobe);
        }
    }
    flush(&p);
    return p.sums;
}

/* ---- what a glossy lobe reflects of area lights ---- */

/* Returns L of the area light that a ray meets on a side that shines, times what the lobe reflects of it. */
static sl_rgb met_light(const sl_light_sampling *s, const sl_lit_point *point, const sl_lit_lobe *lobe,
                        sl_vec3 direction, uint32_t triangle, float distance) {
    uint32_t l = triangle != SL_NO_INDEX ? s->lights->light_of_triangle[triangle] : SL_NO_INDEX;
    if (l == SL_NO_INDEX) return sl_grey(0.0f);
    const sl_sampled_light *light = &s->lights->light[l];
    sl_vec3 normal = sl_scene_geometric_normal(s->scene, triangle);
    if (!light->two_sided && !(sl_dot(normal, direction) < 0.0f)) return sl_grey(0.0f);
    double term =
        lobe_term(lobe, point, sl_scale(direction, distance), normal, s->shape[l].surface.area);
    return sl_rgb_scale(light->radiance, (float)term);
}

sl_rgb sl_lobe_draws(const sl_light_sampling *s, const sl_lit_point *point, const sl_lit_lobe *lobe,
                     const sl_light_numbers *numbers, sl_counters *counters) {
    sl_rgb sum = sl_grey(0.0f);
    sl_vec3 eye = sl_light_lifted(s, point);
    for (uint32_t i = 0; i < numbers->count;) {
        sl_ray16 rays;
        sl_hit16 hits;
        sl_vec3 direction[SL_PACKET];
        unsigned count = 0;
        for (; i < numbers->count && count < SL_PACKET; i++) {
            float u[3];
            sl_sequence_point(numbers->sequence, numbers->key, 0, numbers->first + i, u);
            if (!sl_bsdf_sample(&lobe->bsdf, 0.0f, u[0], u[1], &direction[count])) continue;
            sl_ray16_set(&rays, count, eye, direction[count], 0.0f, INFINITY, point->triangle);
            count++;
        }
        if (count > 0) sl_trace(s->tracer, &rays, count, true, &hits, counters);
        for (unsigned k = 0; k < count; k++)
            sum = sl_rgb_add(sum, met_light(s, point, lobe, direction[k], hits.triangle[k], hits.t[k]));
    }
    return sum;
}
