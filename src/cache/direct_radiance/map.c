#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/direct_radiance/map.h"

#include <math.h>

/* ---- which pictures are taken ---- */

typedef struct {
    const sl_scene *scene;
    const sl_raster *raster;
    sl_radiance_map *map;
    sl_face_shape shape;
    sl_counters *counters;
    double flux, held; /* W, of all lights, and of what leaves inside faces */
} planning;

static void skip(const planning *p, int passes) {
    sl_count(p->counters, SL_COUNT_RASTER_PASSES_SKIPPED, (uint64_t)passes);
}

static size_t texels_of(const sl_map_face *f) { return (size_t)f->width * (size_t)f->height; }

/* Returns where the paper aims its light. */
static sl_vec3 aim_of(const sl_scene *s, const sl_map_light *light) {
    return sl_normalize_or(sl_sub(sl_mad(s->box_min, 0.5f, sl_sub(s->box_max, s->box_min)), light->position),
                           sl_v3(0, -1, 0));
}

static bool is_dark(const sl_map_light *light) {
    sl_rgb flux = sl_map_light_flux(light);
    return !(sl_rgb_max(flux) > 0.0f) || !sl_rgb_is_finite(flux) || !sl_is_finite(light->position);
}

/* Intensity at the middles of a face's parts, times their solid angles. */
static double flux_through(const sl_map_light *light, const sl_map_face *f) {
    enum { PARTS = 24 };
    const double wide = (f->right - f->left) / PARTS, high = (f->top - f->bottom) / PARTS;
    double sum = 0.0;
    for (int i = 0; i < PARTS * PARTS; i++) {
        const double x = f->left + wide * (i % PARTS), y = f->bottom + high * (i / PARTS);
        const sl_vec3 along = sl_v3((float)(x + 0.5 * wide), (float)(y + 0.5 * high), 1.0f);
        const sl_vec3 d = sl_normalize_or(sl_frame_to_world(&f->frame, along), f->frame.z);
        sum += (double)sl_rgb_mean(sl_map_light_intensity(light, d)) *
               sl_rectangle_solid_angle(x, y, x + wide, y + high);
    }
    return sum;
}

/* Adds a light to what is told of its map. The faces that are chosen by the kind of the light hold all of it.
 */
static void measure_light(planning *p, const sl_map_light *light, const sl_map_face *face, int count) {
    const double flux = (double)sl_rgb_mean(sl_map_light_flux(light));
    const bool own = p->shape.shape == SL_MAP_FRUSTUM && light->kind == SL_SOURCE_SPOT && p->shape.fov == 0.0;
    double held = 0.0;
    if (light->kind == SL_SOURCE_DIRECTIONAL || is_dark(light)) return;
    if (p->shape.shape == SL_MAP_AUTO || p->shape.shape == SL_MAP_CUBE || own) held = flux;
    else
        for (int f = 0; f < count; f++) held += flux_through(light, &face[f]);
    p->flux += flux;
    p->held += fmin(held, flux);
}

static void plan_light(planning *p, uint32_t index) {
    sl_radiance_map *map = p->map;
    const sl_map_light *light = &map->lights->light[index];
    sl_map_face face[SL_LIGHT_FACES_MAX];
    const sl_light_eye eye = sl_map_light_eye(map->lights, index);
    int dark = 0,
        count = sl_light_faces(p->scene, &eye, &p->shape, aim_of(p->scene, light), face, &dark);
    measure_light(p, light, face, count);
    skip(p, is_dark(light) ? dark + count : dark);
    for (int f = 0; f < count && !is_dark(light); f++) {
        face[f].light = index;
        face[f].view = sl_map_face_view(p->scene, &eye, &face[f]);
        face[f].first = map->texels;
        if (!sl_raster_meets(p->raster, &face[f].view)) {
            skip(p, 1);
            continue;
        }
        map->face[map->face_count++] = face[f];
        map->texels += texels_of(&face[f]);
    }
}

/* ---- the map ---- */

static bool allocate_vectors(float *plane[3], size_t texels) {
    for (int k = 0; k < 3; k++) plane[k] = sl_allocate(texels, sizeof *plane[k]);
    return plane[0] && plane[1] && plane[2];
}

static sl_status allocate_planes(sl_radiance_map *map, const sl_radiance_map_options *options,
                                 sl_error *error) {
    size_t n = map->texels;
    map->triangle = sl_allocate(n, sizeof *map->triangle);
    map->block_angle = sl_allocate(n, sizeof *map->block_angle);
    map->path = sl_allocate(n, sizeof *map->path);
    bool ok = map->triangle && map->block_angle && map->path && allocate_vectors(map->position, n) &&
              allocate_vectors(map->color, n) && allocate_vectors(map->geometric, n);
    if (options->normals) ok = ok && allocate_vectors(map->normal, n);
    if (options->tracer) ok = ok && allocate_vectors(map->arrival, n) && allocate_vectors(map->carried, n);
    return ok ? SL_OK : sl_fail_memory(error, "a radiance map's pictures");
}

static void measure_texels(sl_radiance_map *map, const sl_map_face *f, bool parallel) {
    double wide = (f->right - f->left) / (double)f->width, high = (f->top - f->bottom) / (double)f->height;
    for (int y = 0; y < f->height; y++) {
        for (int x = 0; x < f->width; x++) {
            double x0 = f->left + wide * (double)x, y0 = f->bottom + high * (double)y;
            double size = parallel ? wide * high : sl_rectangle_solid_angle(x0, y0, x0 + wide, y0 + high);
            map->block_angle[f->first + (size_t)y * (size_t)f->width + (size_t)x] = (float)size;
        }
    }
}

static sl_status render(planning *p, const sl_radiance_map_settings *settings,
                        const sl_radiance_map_options *options, sl_error *error) {
    sl_radiance_map *map = p->map;
    map->face = sl_allocate(SL_LIGHT_FACES_MAX * map->lights->count, sizeof *map->face);
    if (!map->face) return sl_fail_memory(error, "a radiance map's faces");
    for (uint32_t i = 0; i < map->lights->count; i++) plan_light(p, i);
    map->captured = p->flux > 0.0 ? p->held / p->flux : 1.0;
    sl_status status = allocate_planes(map, options, error);
    if (status != SL_OK) return status;
    for (size_t f = 0; f < map->face_count; f++)
        measure_texels(map, &map->face[f],
                       map->lights->light[map->face[f].light].kind == SL_SOURCE_DIRECTIONAL);
    const sl_map_drawing drawing = {p->scene, p->raster, settings, options, map, p->counters};
    return sl_map_pictures_draw(&drawing, error);
}

sl_status sl_radiance_map_render(const sl_scene *scene, const sl_raster *raster, const sl_map_lights *lights,
                                 const sl_radiance_map_settings *settings,
                                 const sl_radiance_map_options *options, sl_radiance_map **out,
                                 sl_counters *counters, sl_error *error) {
    *out = NULL;
    sl_radiance_map *map = sl_allocate(1, sizeof *map);
    if (!map) return sl_fail_memory(error, "a radiance map");
    *map = (sl_radiance_map){.lights = lights, .lambertian = options->lambertian};
    planning p = {scene, raster, map, sl_face_shape_of(settings), counters, 0.0, 0.0};
    const sl_status status = render(&p, settings, options, error);
    if (status != SL_OK) sl_radiance_map_destroy(map);
    else *out = map;
    return status;
}

void sl_radiance_map_destroy(sl_radiance_map *map) {
    if (!map) return;
    float *const *planes[] = {map->position,  map->color,   map->normal,
                              map->geometric, map->arrival, map->carried};
    for (size_t i = 0; i < sizeof planes / sizeof *planes; i++) {
        for (int k = 0; k < 3; k++) sl_free(planes[i][k]);
    }
    sl_free(map->face);
    sl_free(map->triangle);
    sl_free(map->block_angle);
    sl_free(map->path);
    sl_free(map);
}

size_t sl_radiance_map_bytes(const sl_radiance_map *map) {
    if (!map) return 0;
    size_t planes = 12 + (map->normal[0] ? 3u : 0u) + (map->arrival[0] ? 6u : 0u);
    return sizeof *map + map->face_count * sizeof *map->face + planes * map->texels * sizeof(float);
}

/* Solid angle of [0,x] x [0,y]; odd in both. The product stands over a root that never vanishes. */
static double corner_angle(double x, double y) { return sl_atan(x * y / sqrt(1.0 + x * x + y * y)); }

double sl_rectangle_solid_angle(double x0, double y0, double x1, double y1) {
    return (corner_angle(x1, y1) - corner_angle(x0, y1)) - (corner_angle(x1, y0) - corner_angle(x0, y0));
}

double sl_printed_footprint(double b, double fov, int m) {
    double side = 2.0 * b * sl_tan(fov / (2.0 * (double)m));
    return side * side;
}

double sl_printed_tilted_footprint(double footprint, double cos_alpha) {
    if (!(cos_alpha >= 0.0)) return 0.0;
    return cos_alpha > 0.0 ? footprint / cos_alpha : footprint > 0.0 ? INFINITY : 0.0;
}
