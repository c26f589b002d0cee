#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/direct_radiance/lights.h"

#include <math.h>

#define FAR_APART 1e30

/* ---- what a light gives ---- */

/* 1 inside the inner cone, 0 outside the outer one, smoothstep of the cosine between; a step where they are
 * equal. */
static float falloff(const sl_map_light *light, float cosine) {
    if (cosine >= light->cos_inner) return 1.0f;
    if (!(cosine > light->cos_outer)) return 0.0f;
    float x = (cosine - light->cos_outer) / (light->cos_inner - light->cos_outer);
    return x * x * (3.0f - 2.0f * x);
}

sl_rgb sl_map_light_intensity(const sl_map_light *light, sl_vec3 direction) {
    float cosine = sl_dot(light->direction, direction);
    switch (light->kind) {
    case SL_SOURCE_SPOT: return sl_rgb_scale(light->intensity, falloff(light, cosine));
    case SL_SOURCE_AREA:
        return sl_rgb_scale(light->intensity, cosine > 0.0f ? cosine : light->two_sided ? -cosine : 0.0f);
    default: return light->intensity;
    }
}

/* Flux over intensity. The smoothstep's mean over its range of cosines is 1/2. */
static double directions_of(const sl_map_light *light) {
    switch (light->kind) {
    case SL_SOURCE_POINT: return 4.0 * SL_PI;
    case SL_SOURCE_SPOT:
        return 2.0 * SL_PI * (1.0 - 0.5 * ((double)light->cos_inner + (double)light->cos_outer));
    case SL_SOURCE_AREA: return light->two_sided ? 2.0 * SL_PI : SL_PI;
    default: return 1.0;
    }
}

sl_rgb sl_map_light_flux(const sl_map_light *light) {
    return sl_rgb_scale(light->intensity, (float)directions_of(light));
}

/* ---- points of the scene's lights ---- */

typedef struct {
    const sl_scene *scene;
    const sl_sampled_lights *lamps;
    sl_map_light *light;
    size_t count;
} finding;

enum { POINTS_OF_SOLIDS = 24 };

static size_t points_of(const sl_sampled_light *lamp, int n) {
    const size_t each = (size_t)n * (size_t)n;
    return lamp->kind == SL_SAMPLED_AREA    ? each
           : lamp->kind == SL_SAMPLED_SOLID ? POINTS_OF_SOLIDS * each
                                            : 1;
}

static size_t points_of_all(const sl_sampled_lights *lamps, int n) {
    size_t points = 0;
    for (size_t i = 0; i < lamps->count; i++) points += points_of(&lamps->light[i], n);
    return points;
}

static sl_map_light light_of(const sl_sampled_light *lamp) {
    static const sl_source_kind kinds[] = {[SL_SAMPLED_POINT] = SL_SOURCE_POINT,
                                              [SL_SAMPLED_SPOT] = SL_SOURCE_SPOT,
                                              [SL_SAMPLED_DIRECTIONAL] = SL_SOURCE_DIRECTIONAL,
                                              [SL_SAMPLED_AREA] = SL_SOURCE_AREA,
                                              [SL_SAMPLED_SOLID] = SL_SOURCE_AREA};
    return (sl_map_light){.kind = kinds[lamp->kind],
                          .position = lamp->position,
                          .direction = lamp->kind == SL_SAMPLED_AREA ? lamp->normal : lamp->direction,
                          .intensity = lamp->colour,
                          .cos_inner = lamp->cos_inner,
                          .cos_outer = lamp->cos_outer,
                          .two_sided = lamp->two_sided};
}

/* Returns point `index` of n x n in a planar light, evenly over a parallelogram; of other lights the points
 * are spread over their triangles in turn. */
static sl_vec3 point_of(const sl_sampled_light *lamp, const sl_light_surface *surface, size_t index, int n,
                        sl_vec3 *normal) {
    const size_t count = points_of(lamp, n), side = (size_t)n;
    if (surface->parallelogram) {
        const double u = ((double)(index % side) + 0.5) / n, v = ((double)(index / side) + 0.5) / n;
        const sl_vec3d along = sl_addd(sl_scaled(surface->e1, u), sl_scaled(surface->e2, v));
        return sl_to_float(sl_addd(surface->corner, along));
    }
    const double u[2] = {((double)index + 0.5) / (double)count,
                         ((double)(sl_van_der_corput((uint32_t)index) >> 8) + 0.5) * 0x1p-24};
    size_t triangle;
    double weight[2];
    const sl_vec3 p = sl_to_float(sl_light_surface_point(lamp, surface, u, &triangle, weight));
    const sl_vec3 *corner = &lamp->corner[3 * triangle];
    const sl_vec3 across = sl_cross(sl_sub(corner[1], corner[0]), sl_sub(corner[2], corner[0]));
    if (lamp->kind == SL_SAMPLED_SOLID) *normal = sl_normalize_or(across, *normal);
    return p;
}

static sl_status add_area(finding *f, const sl_sampled_light *lamp, int n, sl_error *error) {
    sl_light_surface surface;
    sl_status status = sl_light_surface_make(lamp, &surface, error);
    if (status != SL_OK) return status;
    const size_t count = points_of(lamp, n);
    const double area = surface.area / (double)count;
    for (size_t i = 0; i < count && surface.area > 0.0; i++) {
        sl_map_light *l = &f->light[f->count++];
        *l = light_of(lamp);
        if (count > 1) l->position = point_of(lamp, &surface, i, n, &l->direction);
        l->area = (float)area;
        l->intensity = sl_rgb_scale(lamp->radiance, (float)(area * (double)lamp->opaque));
        l->lamp = (uint32_t)(lamp - f->lamps->light);
        l->siblings = (uint32_t)count;
    }
    sl_light_surface_release(&surface);
    return SL_OK;
}

static sl_status add_all(finding *f, int n, sl_error *error) {
    sl_status status = SL_OK;
    for (size_t i = 0; i < f->lamps->count && status == SL_OK; i++) {
        const sl_sampled_light *lamp = &f->lamps->light[i];
        if (sl_light_has_extent(lamp)) {
            status = add_area(f, lamp, n, error);
            continue;
        }
        f->light[f->count] = light_of(lamp);
        f->light[f->count].lamp = (uint32_t)i;
        f->light[f->count++].siblings = 1;
    }
    return status;
}

/* ---- too many of them ---- */

static double power_of(const sl_map_light *l) {
    const double power = (double)sl_rgb_mean(l->intensity) * directions_of(l);
    return power > 0.0 && isfinite(power) ? power : 0.0;
}

/* Returns the squared distance in the scene's sizes: a turn by a right angle counts as much as a way of half
 * the scene. */
static double distance_of(const sl_map_light *a, const sl_map_light *b, double size) {
    const sl_vec3 way = sl_sub(a->position, b->position), turn = sl_sub(a->direction, b->direction);
    if (a->kind != b->kind || a->two_sided != b->two_sided) return FAR_APART;
    return (double)sl_dot(way, way) / (size * size) + 0.125 * (double)sl_dot(turn, turn);
}

/* Chooses lights one by one, the one that has most power times squared distance from those before; writes of
 * each light which of the chosen is nearest. */
static void choose(const finding *f, size_t most, uint32_t *nearest, double *distance) {
    const double size = (double)sl_scene_central_diagonal(f->scene);
    for (size_t i = 0; i < f->count; i++) distance[i] = FAR_APART;
    for (size_t k = 0; k < most; k++) {
        size_t best = 0;
        for (size_t i = 1; i < f->count; i++) {
            if (power_of(&f->light[i]) * distance[i] > power_of(&f->light[best]) * distance[best]) best = i;
        }
        for (size_t i = 0; i < f->count; i++) {
            const double d = i == best ? -1.0 : distance_of(&f->light[i], &f->light[best], size);
            if (!(d < distance[i])) continue;
            distance[i] = d;
            nearest[i] = (uint32_t)best;
        }
    }
}

/* Adds a light: the sum stands in the middle by flux, shines as widely as the wider of both, and has the flux
 * of both. */
static void merge_light(sl_map_light *into, const sl_map_light *part) {
    const double power = power_of(into) + power_of(part);
    const float share = power > 0.0 ? (float)(power_of(part) / power) : 0.0f;
    const sl_rgb flux = sl_rgb_add(sl_map_light_flux(into), sl_map_light_flux(part));
    into->position = sl_mad(into->position, share, sl_sub(part->position, into->position));
    into->direction = sl_normalize_or(
        sl_mad(into->direction, share, sl_sub(part->direction, into->direction)), into->direction);
    into->cos_inner = fminf(into->cos_inner, part->cos_inner);
    into->cos_outer = fminf(into->cos_outer, part->cos_outer);
    into->area += part->area;
    into->lamp = into->lamp == part->lamp ? into->lamp : SL_NO_INDEX;
    into->siblings = 1;
    const double directions = directions_of(into);
    into->intensity = sl_rgb_scale(flux, directions > 0.0 ? (float)(1.0 / directions) : 0.0f);
}

static sl_status merge(finding *f, size_t most, sl_error *error) {
    uint32_t *nearest = sl_allocate(f->count, sizeof *nearest);
    double *distance = sl_allocate(f->count, sizeof *distance);
    size_t kept = 0;
    if (nearest && distance) {
        choose(f, most, nearest, distance);
        for (size_t i = 0; i < f->count; i++)
            if (distance[i] >= 0.0 && distance[i] < FAR_APART)
                merge_light(&f->light[nearest[i]], &f->light[i]);
        for (size_t i = 0; i < f->count; i++)
            if (distance[i] < 0.0) f->light[kept++] = f->light[i];
        f->count = kept;
    }
    sl_free(nearest);
    sl_free(distance);
    return kept ? SL_OK : sl_fail_memory(error, "the lights");
}

/* ---- all ---- */

sl_status sl_map_lights_find(const sl_scene *scene, int subdivision, sl_map_lights **lights,
                             sl_error *error) {
    *lights = NULL;
    sl_map_lights *out = sl_allocate(1, sizeof *out);
    if (!out) return sl_fail_memory(error, "the lights");
    sl_status status = sl_sampled_lights_find(scene, &out->lamps, error);
    if (status == SL_OK) {
        int n = subdivision;
        while (n > 1 && points_of_all(out->lamps, n) > SL_MAP_LIGHTS_MAX) n--;
        out->light = sl_allocate(points_of_all(out->lamps, n), sizeof *out->light);
        finding f = {scene, out->lamps, out->light, 0};
        status = out->light ? add_all(&f, n, error) : sl_fail_memory(error, "the lights");
        if (status == SL_OK && f.count > SL_MAP_LIGHTS_MAX) status = merge(&f, SL_MAP_LIGHTS_MAX, error);
        out->count = f.count;
    }
    if (status != SL_OK) sl_map_lights_destroy(out);
    else *lights = out;
    return status;
}

void sl_map_lights_destroy(sl_map_lights *lights) {
    if (!lights) return;
    sl_sampled_lights_destroy(lights->lamps);
    sl_free(lights->light);
    sl_free(lights);
}

/* Returns how far a lamp's triangles lie above the plane through a point of it. */
static float clearance_of(const sl_sampled_light *lamp, sl_vec3 point, sl_vec3 normal) {
    const sl_vec3d n = sl_to_double(normal), o = sl_to_double(point);
    double most = 0.0;
    for (size_t k = 0; k < 3 * lamp->triangles; k++) {
        const double height = sl_dotd(n, sl_subd(sl_to_double(lamp->corner[k]), o));
        most = height > most ? height : most;
    }
    return (float)most;
}

sl_light_eye sl_map_light_eye(const sl_map_lights *lights, size_t light) {
    const sl_map_light *l = &lights->light[light];
    sl_light_eye eye = {.kind = l->kind,
                        .position = l->position,
                        .direction = l->direction,
                        .cos_outer = l->cos_outer,
                        .two_sided = l->two_sided};
    if (l->kind != SL_SOURCE_AREA || !lights->lamps || l->lamp == SL_NO_INDEX) return eye;
    const sl_sampled_light *lamp = &lights->lamps->light[l->lamp];
    eye.clearance[0] = clearance_of(lamp, l->position, l->direction);
    if (l->two_sided) eye.clearance[1] = clearance_of(lamp, l->position, sl_neg(l->direction));
    return eye;
}
