#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/direct_radiance/lights.h"
#include "cache/direct_radiance/map.h"

sl_face_shape sl_face_shape_of(const sl_radiance_map_settings *settings) {
    int m = settings->samples > 1 ? settings->samples : 1;
    /* w is rounded up to a multiple of m */
    int texels = settings->map_size > m ? (settings->map_size + m - 1) / m : 1;
    return (sl_face_shape){settings->shape, settings->map_fov, m, texels};
}

/* ---- pyramids ---- */

typedef struct {
    const sl_light_eye *light;
    const sl_face_shape *shape;
    sl_map_face *face;
    int count, dark;
} face_list;

static void add(face_list *list, const sl_frame *frame, double tangent, int rows, bool back) {
    int m = list->shape->samples, k = list->shape->texels;
    list->face[list->count++] =
        (sl_map_face){.eye = list->light->position,
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
    if (sl_light_shines_on(list->light, side)) add(list, &turned, 1.0, rows, back);
    else list->dark++;
}

/* One whole face ahead and the upper halves of four; where m is odd their middle blocks reach below the
 * horizon. */
static void add_hemicube(face_list *list, const sl_frame *frame, bool back) {
    int m = list->shape->samples;
    for (int side = SL_LIGHT_AHEAD; side < SL_LIGHT_BACK; side++)
        add_side(list, frame, side, side ? (m + 1) / 2 : m, back);
}

static void add_cube(face_list *list, const sl_frame *frame) {
    for (int side = 0; side < SL_LIGHT_SIDES; side++)
        add_side(list, frame, side, list->shape->samples, false);
}

/* ---- shapes ---- */

/* A cone that one picture holds without stretching it too far. */
static const float WIDEST_CONE = 0.5f;

static sl_map_shape shape_for(const sl_light_eye *light, sl_map_shape asked) {
    switch (asked) {
    case SL_MAP_AUTO:
        if (light->kind == SL_SOURCE_AREA) return SL_MAP_HEMICUBE;
        if (light->kind != SL_SOURCE_SPOT) return SL_MAP_CUBE;
        return light->cos_outer >= WIDEST_CONE ? SL_MAP_FRUSTUM
               : light->cos_outer >= 0.0f      ? SL_MAP_HEMICUBE
                                               : SL_MAP_CUBE;
    case SL_MAP_CUBE: /* what an area light lights is one hemisphere, or two */
        return light->kind == SL_SOURCE_AREA ? SL_MAP_HEMICUBE : SL_MAP_CUBE;
    default: return asked;
    }
}

/* tan(fov / 2), from 1e-3 to that of 170 degrees. */
static double frustum_tangent(const sl_light_eye *light, double fov) {
    double c = (double)light->cos_outer, tangent = 1.0;
    if (fov > 0.0) tangent = sl_tan(0.5 * (fov < 2.96706 ? fov : 2.96706));
    else if (light->kind == SL_SOURCE_SPOT) tangent = c > 0.0 ? sqrt(1.0 - c * c) / c : 1e30;
    return tangent > 11.43 ? 11.43 : tangent > 1e-3 ? tangent : 1e-3;
}

static sl_frame frame_of(const sl_light_eye *light, sl_map_shape shape, sl_vec3 aim) {
    bool aimed = light->kind == SL_SOURCE_POINT && shape != SL_MAP_CUBE;
    return aimed ? sl_frame_from_normal(aim) : sl_light_frame(light);
}

/* ---- parallel ---- */

int sl_parallel_texels(int samples, int texels) {
    const int finer = 8 * texels, most = 512 / samples;
    return finer <= most ? finer : texels > most ? texels : most;
}

/* The picture lies as far before the box's middle as the box is deep. */
static void add_parallel(face_list *list, const sl_scene *scene) {
    sl_parallel_picture p = sl_parallel_picture_of(scene, list->light->direction);
    sl_face_shape finer = *list->shape;
    finer.texels = sl_parallel_texels(finer.samples, finer.texels);
    list->shape = &finer;
    add(list, &p.frame, 1.0, finer.samples, false);
    sl_map_face *f = &list->face[list->count - 1];
    f->eye = sl_mad(p.centre, -2.0f * p.extent_z, p.frame.z);
    f->left = -(double)p.extent_x;
    f->right = (double)p.extent_x;
    f->bottom = -(double)p.extent_y;
    f->top = (double)p.extent_y;
}

int sl_light_faces(const sl_scene *scene, const sl_light_eye *light, const sl_face_shape *shape, sl_vec3 aim,
                   sl_map_face *face, int *dark) {
    face_list list = {light, shape, face, 0, 0};
    sl_map_shape form = shape_for(light, shape->shape);
    sl_frame frame = frame_of(light, form, aim);
    if (light->kind == SL_SOURCE_DIRECTIONAL) add_parallel(&list, scene);
    else if (form == SL_MAP_CUBE) add_cube(&list, &frame);
    else if (form == SL_MAP_HEMICUBE) add_hemicube(&list, &frame, false);
    else add(&list, &frame, frustum_tangent(light, shape->fov), shape->samples, false);
    if (light->kind == SL_SOURCE_AREA && light->two_sided) {
        frame.z = sl_neg(frame.z);
        if (form == SL_MAP_HEMICUBE) add_hemicube(&list, &frame, true);
        else add(&list, &frame, frustum_tangent(light, shape->fov), shape->samples, true);
    }
    *dark = list.dark;
    return list.count;
}

/* ---- views ---- */

static void set_row(float row[4], sl_vec3 axis, double low, double high) {
    float scale = (float)(2.0 / (high - low));
    row[0] = axis.x * scale;
    row[1] = axis.y * scale;
    row[2] = axis.z * scale;
    row[3] = (float)(-(high + low) / (high - low));
}

static sl_view parallel_view(const sl_scene *scene, const sl_map_face *f) {
    double depth = (double)sl_parallel_picture_of(scene, f->frame.z).extent_z;
    sl_view view = {.origin = f->eye,
                    .width = f->width,
                    .height = f->height,
                    .depth = SL_DEPTH_WINDOW,
                    .skip_triangle = SL_NO_INDEX};
    set_row(view.clip[0], f->frame.x, f->left, f->right);
    set_row(view.clip[1], f->frame.y, f->bottom, f->top);
    set_row(view.clip[2], f->frame.z, depth, 3.0 * depth);
    view.clip[3][3] = 1.0f;
    return view;
}

sl_view sl_map_face_view(const sl_scene *scene, const sl_light_eye *light, const sl_map_face *f) {
    if (light->kind == SL_SOURCE_DIRECTIONAL) return parallel_view(scene, f);
    const sl_pyramid_picture picture = {f->frame, f->left,  f->right,  f->bottom,
                                        f->top,   f->width, f->height, f->back};
    return sl_pyramid_view(scene, light, &picture);
}
