/* The pictures that lights take: which directions they cover, before anything is drawn. */
#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/direct_radiance/map.h"

/* Two hemicubes. */
enum { FACES_MAX = 10 };

/* A light's faces, in the making; those that are dark all over (behind, outside a cone) are only counted. */
typedef struct {
    const sl_map_drawing *drawing;
    const sl_map_light *light;
    int samples, texels; /* m, and texels a side of a block: w / m */
    sl_map_face face[FACES_MAX];
    int count, dark;
} face_list;

/* ---- pyramids ---- */

static void add(face_list *list, const sl_frame *frame, double tangent, int rows, bool back) {
    int m = list->samples, k = list->texels;
    list->face[list->count++] =
        (sl_map_face){.eye = list->light->source.position,
                      .frame = *frame,
                      .left = -tangent,
                      .right = tangent,
                      .bottom = tangent - 2.0 * tangent * (double)rows / (double)m,
                      .top = tangent,
                      .width = m * k,
                      .height = rows * k,
                      .columns = m,
                      .rows = rows,
                      .back = back};
}

static void add_side(face_list *list, const sl_frame *frame, int side, int rows, bool back) {
    sl_frame turned = sl_light_side(frame, side);
    if (sl_light_shines_on(&list->light->source, side)) add(list, &turned, 1.0, rows, back);
    else list->dark++;
}

/* One whole face ahead and the upper halves of four; where m is odd their middle blocks reach below the
 * horizon. */
static void add_hemicube(face_list *list, const sl_frame *frame, bool back) {
    int m = list->samples;
    for (int side = SL_LIGHT_AHEAD; side < SL_LIGHT_BACK; side++)
        add_side(list, frame, side, side ? (m + 1) / 2 : m, back);
}

static void add_cube(face_list *list, const sl_frame *frame) {
    for (int side = 0; side < SL_LIGHT_SIDES; side++) add_side(list, frame, side, list->samples, false);
}

/* ---- shapes ---- */

/* A cone that one picture holds without stretching it too far. */
static const float WIDEST_CONE = 0.5f;

static sl_map_shape shape_for(const sl_map_light *light, sl_map_shape asked) {
    switch (asked) {
    case SL_MAP_AUTO:
        if (light->source.kind == SL_SOURCE_AREA) return SL_MAP_HEMICUBE;
        if (light->source.kind != SL_SOURCE_SPOT) return SL_MAP_CUBE;
        return light->source.cos_outer >= WIDEST_CONE ? SL_MAP_FRUSTUM
               : light->source.cos_outer >= 0.0f      ? SL_MAP_HEMICUBE
                                               : SL_MAP_CUBE;
    case SL_MAP_CUBE: /* what an area light lights is one hemisphere, or two */
        return light->source.kind == SL_SOURCE_AREA ? SL_MAP_HEMICUBE : SL_MAP_CUBE;
    default: return asked;
    }
}

/* tan(fov / 2), from 1e-3 to that of 170 degrees. */
static double frustum_tangent(const sl_map_light *light, double fov) {
    double c = (double)light->source.cos_outer, tangent = 1.0;
    if (fov > 0.0) tangent = sl_tan(0.5 * (fov < 2.96706 ? fov : 2.96706));
    else if (light->source.kind == SL_SOURCE_SPOT) tangent = c > 0.0 ? sqrt(1.0 - c * c) / c : 1e30;
    return tangent > 11.43 ? 11.43 : tangent > 1e-3 ? tangent : 1e-3;
}

/* The paper aims its light, at the middle of the scene here. */
static sl_frame frame_of(const face_list *list, sl_map_shape shape) {
    const sl_scene *s = list->drawing->scene;
    if (list->light->source.kind != SL_SOURCE_POINT || shape == SL_MAP_CUBE)
        return sl_light_frame(&list->light->source);
    const sl_vec3 middle = sl_mad(s->box_min, 0.5f, sl_sub(s->box_max, s->box_min));
    return sl_frame_from_normal(
        sl_normalize_or(sl_sub(middle, list->light->source.position), sl_v3(0, -1, 0)));
}

static void add_form(face_list *list, const sl_frame *frame, sl_map_shape form, bool back) {
    const double tangent = frustum_tangent(list->light, list->drawing->settings->map_fov);
    if (form == SL_MAP_CUBE) add_cube(list, frame);
    else if (form == SL_MAP_HEMICUBE) add_hemicube(list, frame, back);
    else add(list, frame, tangent, list->samples, back);
}

/* ---- parallel ---- */

int sl_parallel_texels(int samples, int texels) {
    const int finer = 8 * texels, most = 512 / samples;
    return finer <= most ? finer : texels > most ? texels : most;
}

/* The picture lies as far before the box's middle as the box is deep. */
static void add_parallel(face_list *list) {
    sl_parallel_picture p = sl_parallel_picture_of(list->drawing->scene, list->light->source.direction);
    list->texels = sl_parallel_texels(list->samples, list->texels);
    add(list, &p.frame, 1.0, list->samples, false);
    sl_map_face *f = &list->face[list->count - 1];
    f->eye = sl_mad(p.centre, -2.0f * p.extent_z, p.frame.z);
    f->left = -(double)p.extent_x;
    f->right = (double)p.extent_x;
    f->bottom = -(double)p.extent_y;
    f->top = (double)p.extent_y;
}

static void add_faces(face_list *list) {
    const sl_map_shape form = shape_for(list->light, list->drawing->settings->shape);
    sl_frame frame = frame_of(list, form);
    if (list->light->source.kind == SL_SOURCE_DIRECTIONAL) {
        add_parallel(list);
        return;
    }
    add_form(list, &frame, form, false);
    if (list->light->source.kind != SL_SOURCE_AREA || !list->light->source.two_sided) return;
    frame.z = sl_neg(frame.z);
    add_form(list, &frame, form, true);
}

/* ---- views ---- */

static sl_view view_of(const face_list *list, const sl_map_face *f) {
    const sl_scene *scene = list->drawing->scene;
    if (list->light->source.kind == SL_SOURCE_DIRECTIONAL) {
        const sl_parallel_picture picture = sl_parallel_picture_of(scene, list->light->source.direction);
        return sl_parallel_view(&picture, f->width, f->height);
    }
    const sl_pyramid_picture picture = {f->frame, f->left,  f->right,  f->bottom,
                                        f->top,   f->width, f->height, f->back};
    return sl_pyramid_view(scene, &list->light->source, &picture);
}

/* ---- the share of the lights' flux that leaves inside ---- */

static bool is_dark(const sl_map_light *light) {
    sl_rgb flux = sl_map_light_flux(light);
    return sl_rgb_is_black(flux) || !sl_rgb_is_finite(flux) || !sl_is_finite(light->source.position);
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

/* Returns W that leave inside the faces. Those that are chosen by the kind of the light hold all. */
static double held_of(const face_list *list, double flux) {
    const sl_radiance_map_settings *s = list->drawing->settings;
    const bool spot = list->light->source.kind == SL_SOURCE_SPOT,
               own = s->shape == SL_MAP_FRUSTUM && spot && s->map_fov == 0.0;
    double held = 0.0;
    if (s->shape == SL_MAP_AUTO || s->shape == SL_MAP_CUBE || own) return flux;
    for (int f = 0; f < list->count; f++) held += flux_through(list->light, &list->face[f]);
    return fmin(held, flux);
}

/* ---- all lights ---- */

/* Puts those of a light's faces into the map that meet geometry; all of a dark light are skipped. */
static void keep_faces(face_list *list, uint32_t index) {
    sl_radiance_map *map = list->drawing->map;
    int skipped = list->dark;
    for (int f = 0; f < list->count; f++) {
        sl_map_face *face = &list->face[f];
        face->light = index;
        face->view = view_of(list, face);
        face->first = map->texels;
        if (is_dark(list->light) || !sl_raster_meets(list->drawing->raster, &face->view)) {
            skipped++;
            continue;
        }
        map->face[map->face_count++] = *face;
        map->texels += (size_t)face->width * (size_t)face->height;
    }
    sl_count(list->drawing->counters, SL_COUNT_RASTER_PASSES_SKIPPED, (uint64_t)skipped);
}

/* w is rounded up to a multiple of m. */
static face_list list_for(const sl_map_drawing *d, uint32_t index) {
    const int w = d->settings->map_size, m = d->settings->samples > 1 ? d->settings->samples : 1;
    return (face_list){.drawing = d,
                       .light = &d->map->lights->light[index],
                       .samples = m,
                       .texels = w > m ? (w + m - 1) / m : 1};
}

sl_status sl_map_faces_choose(const sl_map_drawing *d, sl_error *error) {
    sl_radiance_map *map = d->map;
    double all = 0.0, held = 0.0;
    map->face = sl_allocate(FACES_MAX * map->lights->count, sizeof *map->face);
    if (!map->face) return sl_fail_memory(error, "a radiance map's faces");
    for (uint32_t i = 0; i < map->lights->count; i++) {
        face_list list = list_for(d, i);
        const double flux = (double)sl_rgb_mean(sl_map_light_flux(list.light));
        add_faces(&list);
        keep_faces(&list, i);
        if (list.light->source.kind == SL_SOURCE_DIRECTIONAL || is_dark(list.light)) continue;
        all += flux;
        held += held_of(&list, flux);
    }
    map->captured = all > 0.0 ? held / all : 1.0;
    return SL_OK;
}
