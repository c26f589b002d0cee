#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/direct_radiance/lights.h"

#include <math.h>

/* ---- what a light gives ---- */

sl_rgb sl_map_light_intensity(const sl_map_light *light, sl_vec3 direction) {
    const sl_light_source *s = &light->source;
    float cosine = sl_dot(s->direction, direction), share = 1.0f;
    if (s->kind == SL_SOURCE_SPOT) share = sl_spot_falloff(cosine, s->cos_inner, s->cos_outer);
    if (s->kind == SL_SOURCE_AREA) share = cosine > 0.0f ? cosine : s->two_sided ? -cosine : 0.0f;
    return sl_rgb_scale(s->colour, share);
}

/* Flux over intensity. The smoothstep's mean over its range of cosines is 1/2. */
static double directions_of(const sl_light_source *s) {
    switch (s->kind) {
    case SL_SOURCE_POINT: return 4.0 * SL_PI;
    case SL_SOURCE_SPOT: return 2.0 * SL_PI * (1.0 - 0.5 * ((double)s->cos_inner + (double)s->cos_outer));
    case SL_SOURCE_AREA: return s->two_sided ? 2.0 * SL_PI : SL_PI;
    default: return 1.0;
    }
}

sl_rgb sl_map_light_flux(const sl_map_light *light) {
    return sl_rgb_scale(light->source.colour, (float)directions_of(&light->source));
}

/* ---- points of the scene's lights ---- */

typedef struct {
    const sl_sampled_lights *lamps;
    size_t side, solid; /* side x side points of a planar lamp, so many times solid of a bulb */
    sl_map_light *light;
    size_t count;
} finding;

enum { POINTS_OF_SOLIDS = 24 };

static size_t points_of(const finding *f, const sl_sampled_light *lamp) {
    return lamp->kind == SL_SOURCE_AREA    ? f->side * f->side
           : lamp->kind == SL_SOURCE_SOLID ? f->solid * f->side * f->side
                                            : 1;
}

static size_t points_of_all(const finding *f) {
    size_t points = 0;
    for (size_t i = 0; i < f->lamps->count; i++) points += points_of(f, &f->lamps->light[i]);
    return points;
}

static sl_map_light light_of(const sl_sampled_light *lamp) {
    return (sl_map_light){
        .source = {.kind = lamp->kind == SL_SOURCE_SOLID ? SL_SOURCE_AREA : lamp->kind,
                   .position = lamp->position,
                   .direction = lamp->kind == SL_SOURCE_AREA ? lamp->normal : lamp->direction,
                   .colour = lamp->colour,
                   .cos_inner = lamp->cos_inner,
                   .cos_outer = lamp->cos_outer,
                   .two_sided = lamp->two_sided}};
}

/* Returns point `index` of n x n in a planar light, evenly over a parallelogram; of other lights the points
 * are spread over their triangles in turn. */
static sl_vec3 point_of(const finding *f, const sl_sampled_light *lamp, const sl_light_surface *surface,
                        size_t index, sl_vec3 *normal) {
    const size_t count = points_of(f, lamp), side = f->side;
    const double n = (double)side;
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
    if (lamp->kind == SL_SOURCE_SOLID) *normal = sl_normalize_or(across, *normal);
    return p;
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

static sl_status add_area(finding *f, const sl_sampled_light *lamp, sl_error *error) {
    sl_light_surface surface;
    sl_status status = sl_light_surface_make(lamp, &surface, error);
    if (status != SL_OK) return status;
    const size_t count = points_of(f, lamp);
    const double area = surface.area / (double)count;
    for (size_t i = 0; i < count && surface.area > 0.0; i++) {
        sl_map_light *l = &f->light[f->count++];
        *l = light_of(lamp);
        if (count > 1) l->source.position = point_of(f, lamp, &surface, i, &l->source.direction);
        l->source.clearance[0] = clearance_of(lamp, l->source.position, l->source.direction);
        if (lamp->two_sided)
            l->source.clearance[1] = clearance_of(lamp, l->source.position, sl_neg(l->source.direction));
        l->area = (float)area;
        l->source.colour = sl_rgb_scale(lamp->radiance, (float)(area * (double)lamp->opaque));
        l->lamp = (uint32_t)(lamp - f->lamps->light);
        l->siblings = (uint32_t)count;
    }
    sl_light_surface_release(&surface);
    return SL_OK;
}

static sl_status add_all(finding *f, sl_error *error) {
    sl_status status = SL_OK;
    for (size_t i = 0; i < f->lamps->count && status == SL_OK; i++) {
        const sl_sampled_light *lamp = &f->lamps->light[i];
        if (sl_light_has_extent(lamp)) {
            status = add_area(f, lamp, error);
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
    const double power = (double)sl_rgb_mean(l->source.colour) * directions_of(&l->source);
    return power > 0.0 && isfinite(power) ? power : 0.0;
}

/* Keeps the strongest, which shine for all. */
static void keep_strongest(finding *f, size_t most) {
    double all = 0.0, kept = 0.0;
    for (size_t i = 0; i < f->count; i++) all += power_of(&f->light[i]);
    for (size_t k = 0; k < most; k++) { /* the first k are the strongest */
        size_t best = k;
        for (size_t i = k + 1; i < f->count; i++)
            if (power_of(&f->light[i]) > power_of(&f->light[best])) best = i;
        const sl_map_light stronger = f->light[best];
        f->light[best] = f->light[k];
        f->light[k] = stronger;
        kept += power_of(&stronger);
    }
    f->count = most;
    for (size_t k = 0; k < most && kept > 0.0; k++)
        f->light[k].source.colour = sl_rgb_scale(f->light[k].source.colour, (float)(all / kept));
}

/* ---- all ---- */

sl_status sl_map_lights_find(const sl_scene *scene, int subdivision, sl_map_lights **lights,
                             sl_error *error) {
    *lights = NULL;
    sl_map_lights *out = sl_allocate(1, sizeof *out);
    if (!out) return sl_fail_memory(error, "the lights");
    sl_status status = sl_sampled_lights_find(scene, &out->lamps, error);
    if (status == SL_OK) {
        finding f = {out->lamps, subdivision > 1 ? (size_t)subdivision : 1, POINTS_OF_SOLIDS, NULL, 0};
        for (; f.side > 1 && points_of_all(&f) > SL_MAP_LIGHTS_MAX;) f.side--;
        for (; f.solid > 1 && points_of_all(&f) > SL_MAP_LIGHTS_MAX;) f.solid--;
        f.light = out->light = sl_allocate(points_of_all(&f), sizeof *out->light);
        status = out->light ? add_all(&f, error) : sl_fail_memory(error, "the lights");
        if (status == SL_OK && f.count > SL_MAP_LIGHTS_MAX) keep_strongest(&f, SL_MAP_LIGHTS_MAX);
        out->count = f.count;
    }
    if (status != SL_OK) sl_map_lights_destroy(out);
    else *lights = out;
    return status;
}

void sl_map_lights_destroy(sl_map_lights *lights) {
    if (!lights) return;
    for (size_t i = 0; lights->cube && i < lights->count; i++) sl_depth_cube_release(&lights->cube[i]);
    sl_sampled_lights_destroy(lights->lamps);
    SL_FREE_ALL(lights->cube, lights->light, lights);
}

size_t sl_map_lights_bytes(const sl_map_lights *lights) {
    size_t bytes = sizeof *lights;
    for (size_t i = 0; lights->cube && i < lights->count; i++) bytes += sl_depth_cube_bytes(&lights->cube[i]);
    return bytes;
}
