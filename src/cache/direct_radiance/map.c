#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/direct_radiance/map.h"

#include <math.h>
#include <string.h>

/* ---- planning ---- */

typedef struct {
    const sl_scene *scene;
    const sl_raster *raster;
    const sl_map_lights *lights;
    const sl_radiance_map_options *options;
    sl_face_shape shape;
    sl_map_face *face;
    size_t count, room;
    uint32_t *seen; /* the triangles in the lights' own faces */
    sl_counters *counters;
} planning;

static sl_map_face *next_face(planning *p, sl_error *error) {
    if (p->count == p->room) {
        size_t room = 2 * p->room + 16;
        sl_map_face *more = sl_allocate(room, sizeof *more);
        if (!more) {
            sl_fail_memory(error, "a radiance map's faces");
            return NULL;
        }
        if (p->count) memcpy(more, p->face, p->count * sizeof *more);
        sl_free(p->face);
        p->face = more;
        p->room = room;
    }
    return &p->face[p->count];
}

static void skip(planning *p, int passes) {
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

static sl_status plan_light(planning *p, uint32_t index, sl_error *error) {
    const sl_map_light *light = &p->lights->light[index];
    sl_map_face face[SL_LIGHT_FACES_MAX];
    const sl_light_eye eye = sl_map_light_eye(p->lights, index);
    int dark = 0,
        count = sl_light_faces(p->scene, &eye, &p->shape, aim_of(p->scene, light), face, &dark);
    skip(p, is_dark(light) ? dark + count : dark);
    if (is_dark(light)) return SL_OK;
    for (int f = 0; f < count; f++) {
        sl_map_face *next = next_face(p, error);
        if (!next) return SL_ERROR_RESOURCES;
        face[f].light = index;
        face[f].view = sl_map_face_view(p->scene, &eye, &face[f]);
        if (sl_raster_meets(p->raster, &face[f].view)) {
            *next = face[f];
            p->count++;
        } else {
            skip(p, 1);
        }
    }
    return SL_OK;
}

/* ---- what the lights themselves see, and see in mirrors ---- */

static sl_status draw_seen(planning *p, sl_error *error) {
    sl_view *views = sl_allocate(p->count, sizeof *views);
    sl_target *targets = sl_allocate(p->count, sizeof *targets);
    size_t texels = 0;
    for (size_t f = 0; f < p->count; f++) {
        p->face[f].seen = texels;
        texels += texels_of(&p->face[f]);
    }
    p->seen = sl_allocate(texels, sizeof *p->seen);
    sl_status status = views && targets && p->seen ? SL_OK : sl_fail_memory(error, "a radiance map's faces");
    for (size_t f = 0; f < p->count && status == SL_OK; f++) {
        const sl_map_face *face = &p->face[f];
        views[f] = face->view;
        targets[f] = (sl_target){face->width, face->height, p->seen + face->seen, NULL};
    }
    if (status == SL_OK)
        status = sl_map_triangles_draw(p->raster, p->count, views, targets, p->options->threads, p->counters,
                                       error);
    sl_free(views);
    sl_free(targets);
    return status;
}

static bool mirror_is_seen(const planning *p, const sl_map_face *f, uint32_t mirror) {
    const uint32_t *seen = p->seen + f->seen;
    for (size_t i = 0; i < texels_of(f); i++) {
        if (seen[i] != SL_NO_INDEX && p->options->mirrors->of_triangle[seen[i]] == mirror) return true;
    }
    return false;
}

static sl_status add_mirrored(planning *p, const sl_map_face *of, uint32_t mirror, sl_error *error) {
    sl_map_face *next = next_face(p, error);
    if (!next) return SL_ERROR_RESOURCES;
    const sl_map_light *light = &p->lights->light[of->light];
    if (!sl_map_face_in_mirror(p->scene, p->options->mirrors, mirror, light, of, next)) return SL_OK;
    if (sl_raster_meets(p->raster, &next->view)) p->count++;
    else skip(p, 1);
    return SL_OK;
}

/* Lists the faces anew, each light's own ones followed by what they show in mirrors. */
static sl_status add_mirrors(planning *p, sl_error *error) {
    sl_map_face *own = p->face;
    const size_t count = p->count;
    sl_status status = SL_OK;
    p->face = NULL;
    p->count = p->room = 0;
    for (size_t first = 0, end; first < count && status == SL_OK; first = end) {
        for (end = first; end < count && own[end].light == own[first].light; end++) {
            sl_map_face *next = next_face(p, error);
            if (!next) status = SL_ERROR_RESOURCES;
            if (!next) break;
            *next = own[end];
            p->count++;
        }
        for (uint32_t m = 0; m < p->options->mirrors->count; m++) {
            for (size_t f = first; f < end && status == SL_OK; f++)
                if (mirror_is_seen(p, &own[f], m)) status = add_mirrored(p, &own[f], m, error);
        }
    }
    sl_free(own);
    return status;
}

static sl_status plan(planning *p, sl_error *error) {
    sl_status status = SL_OK;
    for (uint32_t i = 0; i < p->lights->count && status == SL_OK; i++) status = plan_light(p, i, error);
    if (status == SL_OK) status = draw_seen(p, error);
    if (status == SL_OK && p->options->mirrors) status = add_mirrors(p, error);
    return status;
}

/* ---- the map ---- */

static bool allocate_vectors(float *plane[3], size_t texels) {
    for (int k = 0; k < 3; k++) plane[k] = sl_allocate(texels, sizeof *plane[k]);
    return plane[0] && plane[1] && plane[2];
}

static sl_status allocate_planes(sl_radiance_map *map, const sl_radiance_map_options *options, bool traced,
                                 sl_error *error) {
    size_t n = map->texels;
    map->triangle = sl_allocate(n, sizeof *map->triangle);
    map->block_angle = sl_allocate(n, sizeof *map->block_angle);
    map->path = sl_allocate(n, sizeof *map->path);
    bool ok = map->triangle && map->block_angle && map->path && allocate_vectors(map->position, n) &&
              allocate_vectors(map->color, n) && allocate_vectors(map->geometric, n);
    if (options->normals) ok = ok && allocate_vectors(map->normal, n);
    if (traced) {
        map->spread = sl_allocate(n, sizeof *map->spread);
        ok = ok && map->spread && allocate_vectors(map->arrival, n) && allocate_vectors(map->carried, n);
    }
    return ok ? SL_OK : sl_fail_memory(error, "a radiance map's pictures");
}

static bool same_texels(const sl_map_face *a, const sl_map_face *b) {
    return a->left == b->left && a->right == b->right && a->bottom == b->bottom && a->top == b->top &&
           a->width == b->width && a->height == b->height;
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

/* Measures solid angles; most faces are cut alike. */
static void measure_faces(sl_radiance_map *map) {
    for (size_t f = 0; f < map->face_count; f++) {
        const sl_map_face *face = &map->face[f];
        bool parallel = map->lights->light[face->light].kind == SL_SOURCE_DIRECTIONAL;
        size_t like = f > SL_LIGHT_FACES_MAX ? f - SL_LIGHT_FACES_MAX : 0;
        while (like < f &&
               (parallel || map->lights->light[map->face[like].light].kind == SL_SOURCE_DIRECTIONAL ||
                !same_texels(&map->face[like], face)))
            like++;
        if (like == f) measure_texels(map, face, parallel);
        else
            memcpy(map->block_angle + face->first, map->block_angle + map->face[like].first,
                   texels_of(face) * sizeof *map->block_angle);
    }
}

/* Makes the planned faces the map's own. */
static sl_status make_map(planning *p, sl_radiance_map *map, bool traced, sl_error *error) {
    map->face_count = p->count;
    map->face = p->face;
    p->face = NULL;
    for (size_t f = 0; f < map->face_count; f++) {
        map->face[f].first = map->texels;
        map->texels += texels_of(&map->face[f]);
    }
    sl_status status = allocate_planes(map, p->options, traced, error);
    if (status == SL_OK) measure_faces(map);
    return status;
}

static sl_status render(planning *p, const sl_radiance_map_settings *settings, sl_radiance_map *map,
                        sl_error *error) {
    bool traced = settings->traced_light_mirrors && p->options->tracer;
    sl_status status = plan(p, error);
    if (status == SL_OK) status = make_map(p, map, traced, error);
    const sl_map_drawing drawing = {p->scene, p->raster, settings, p->options, p->seen, map, p->counters};
    if (status == SL_OK) status = sl_map_pictures_draw(&drawing, error);
    if (status == SL_OK && traced) status = sl_map_trace_mirrors(&drawing, error);
    return status;
}

sl_status sl_radiance_map_render(const sl_scene *scene, const sl_raster *raster, const sl_map_lights *lights,
                                 const sl_radiance_map_settings *settings,
                                 const sl_radiance_map_options *options, sl_radiance_map **out,
                                 sl_counters *counters, sl_error *error) {
    *out = NULL;
    planning p = {.scene = scene,
                  .raster = raster,
                  .lights = lights,
                  .options = options,
                  .shape = sl_face_shape_of(settings),
                  .counters = counters};
    sl_radiance_map *map = sl_allocate(1, sizeof *map);
    if (!map) return sl_fail_memory(error, "a radiance map");
    *map = (sl_radiance_map){.lights = lights,
                             .lambertian = options->lambertian,
                             .shape = settings->shape,
                             .fov = settings->map_fov};
    const sl_status status = render(&p, settings, map, error);
    sl_free(p.face);
    sl_free(p.seen);
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
    sl_free(map->spread);
    sl_free(map);
}

size_t sl_radiance_map_bytes(const sl_radiance_map *map) {
    if (!map) return 0;
    size_t planes = 12 + (map->normal[0] ? 3u : 0u) + (map->spread ? 7u : 0u);
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
