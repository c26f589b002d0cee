#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/direct_radiance/map.h"

#include <math.h>

static bool allocate_vectors(float *plane[3], size_t texels) {
    for (int k = 0; k < 3; k++) plane[k] = sl_allocate(texels, sizeof *plane[k]);
    return plane[0] && plane[1] && plane[2];
}

static sl_status allocate_planes(sl_radiance_map *map, const sl_radiance_map_options *options,
                                 sl_error *error) {
    size_t n = map->texels;
    map->triangle = sl_allocate(n, sizeof *map->triangle);
    map->path = sl_allocate(n, sizeof *map->path);
    bool ok = map->triangle && map->path && allocate_vectors(map->position, n) &&
              allocate_vectors(map->color, n) && allocate_vectors(map->geometric, n);
    if (options->normals) ok = ok && allocate_vectors(map->normal, n);
    if (options->tracer) ok = ok && allocate_vectors(map->arrival, n) && allocate_vectors(map->carried, n);
    return ok ? SL_OK : sl_fail_memory(error, "a radiance map's pictures");
}

static sl_status render(const sl_map_drawing *drawing, sl_error *error) {
    sl_radiance_map *map = drawing->map;
    sl_status status = sl_map_faces_choose(drawing, error);
    if (status == SL_OK) status = allocate_planes(map, drawing->options, error);
    if (status != SL_OK) return status;
    return sl_map_pictures_draw(drawing, error);
}

sl_status sl_radiance_map_render(const sl_scene *scene, const sl_raster *raster, const sl_map_lights *lights,
                                 const sl_radiance_map_settings *settings,
                                 const sl_radiance_map_options *options, sl_radiance_map **out,
                                 sl_counters *counters, sl_error *error) {
    *out = NULL;
    sl_radiance_map *map = sl_allocate(1, sizeof *map);
    if (!map) return sl_fail_memory(error, "a radiance map");
    *map = (sl_radiance_map){.lights = lights, .lambertian = options->lambertian};
    const sl_map_drawing drawing = {scene, raster, settings, options, map, counters};
    const sl_status status = render(&drawing, error);
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
    SL_FREE_ALL(map->face, map->triangle, map->path, map);
}

size_t sl_radiance_map_bytes(const sl_radiance_map *map) {
    if (!map) return 0;
    size_t planes = 11 + (map->normal[0] ? 3u : 0u) + (map->arrival[0] ? 6u : 0u);
    return sizeof *map + map->face_count * sizeof *map->face + planes * map->texels * sizeof(float);
}

/* Solid angle of [0,x] x [0,y]; odd in both. The product stands over a root that never vanishes. */
static double corner_angle(double x, double y) { return sl_atan(x * y / sqrt(1.0 + x * x + y * y)); }

double sl_rectangle_solid_angle(double x0, double y0, double x1, double y1) {
    return (corner_angle(x1, y1) - corner_angle(x0, y1)) - (corner_angle(x1, y0) - corner_angle(x0, y0));
}

double sl_map_part(const sl_radiance_map *map, const sl_map_face *face, int column, int row, int texels) {
    const double wide = (face->right - face->left) / face->width * texels,
                 high = (face->top - face->bottom) / face->height * texels,
                 x = face->left + wide / texels * column, y = face->bottom + high / texels * row;
    return sl_face_is_directional(map, face) ? wide * high
                                             : sl_rectangle_solid_angle(x, y, x + wide, y + high);
}

double sl_printed_footprint(double b, double fov, int m) {
    double side = 2.0 * b * sl_tan(fov / (2.0 * (double)m));
    return side * side;
}

double sl_printed_tilted_footprint(double footprint, double cos_alpha) {
    if (!(cos_alpha >= 0.0)) return 0.0;
    return cos_alpha > 0.0 ? footprint / cos_alpha : footprint > 0.0 ? INFINITY : 0.0;
}
