/* Views: the matrices of cameras, of pyramids above surface points, and of the faces of hemicubes. */
#include <math.h>
#include <string.h>

#include "base/math.h"
#include "raster/view.h"

static void set_row(float row[4], sl_vec3d a, double w) {
    row[0] = (float)a.x;
    row[1] = (float)a.y;
    row[2] = (float)a.z;
    row[3] = (float)w;
}

/* x/w runs from -1 at tangent `left` to 1 at tangent `right`. Row 2 is w - near: the near plane's distance.
 */
sl_view sl_view_pyramid(const sl_frame *frame, sl_vec3 eye, float left, float right, float bottom, float top,
                        int width, int height, float near) {
    sl_view view = {.kind = SL_VIEW_PYRAMID,
                    .origin = eye,
                    .width = width,
                    .height = height,
                    .depth = SL_DEPTH_INVERSE_W,
                    .skip_triangle = SL_NO_INDEX};
    double l = (double)left, r = (double)right, b = (double)bottom, t = (double)top;
    sl_vec3d x = sl_to_double(frame->x), y = sl_to_double(frame->y), z = sl_to_double(frame->z);
    set_row(view.clip[0], sl_subd(sl_scaled(x, 2.0 / (r - l)), sl_scaled(z, (r + l) / (r - l))), 0.0);
    set_row(view.clip[1], sl_subd(sl_scaled(y, 2.0 / (t - b)), sl_scaled(z, (t + b) / (t - b))), 0.0);
    set_row(view.clip[2], z, -(double)near);
    set_row(view.clip[3], z, 0.0);
    return view;
}

/* A face's axes in the hemicube's frame (x, y of the picture, and the way it looks), and the part of [-1,1]^2
 * that it shows. */
typedef struct {
    sl_vec3 x, y, outward;
    float left, right, bottom, top;
} hemicube_face;

sl_view sl_view_hemicube_face(const sl_frame *frame, sl_vec3 eye, int face, int size, float near) {
    static const hemicube_face faces[5] = {
        {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, -1, 1, -1, 1},  /* top */
        {{0, 0, -1}, {0, 1, 0}, {1, 0, 0}, -1, 0, -1, 1}, /* +x: its left edge is the top's right one */
        {{0, 0, 1}, {0, 1, 0}, {-1, 0, 0}, 0, 1, -1, 1},  /* -x */
        {{1, 0, 0}, {0, 0, -1}, {0, 1, 0}, -1, 1, -1, 0}, /* +y: its lower edge is the top's upper one */
        {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}, -1, 1, 0, 1},  /* -y */
    };
    const hemicube_face *f = &faces[face];
    int half = size / 2, width = f->right - f->left > 1.0f ? 2 * half : half,
        height = f->top - f->bottom > 1.0f ? 2 * half : half;
    sl_frame axes = {sl_frame_to_world(frame, f->x), sl_frame_to_world(frame, f->y),
                     sl_frame_to_world(frame, f->outward)};
    sl_view view = sl_view_pyramid(&axes, eye, f->left, f->right, f->bottom, f->top, width, height, near);
    view.kind = SL_VIEW_HEMICUBE_FACE;
    return view;
}

/* In double, where squares neither vanish nor overflow. A plane so short that a float hardly holds its length
 * is given none: then culling goes by the box alone. */
static float plane_length(const float plane[4]) {
    double x = (double)plane[0], y = (double)plane[1], z = (double)plane[2],
           length = sqrt((x * x + y * y) + z * z);
    return length > 1e-30 ? (float)length : INFINITY;
}

static sl_view view_of(const sl_scene *scene, const sl_camera *camera, sl_sub_frame at, int width,
                       int height) {
    sl_frame frame = {camera->right, camera->up, sl_neg(camera->back)};
    float top = (float)sl_tan(0.5 * (double)camera->vertical_fov), right = top * (float)width / (float)height,
          x = 2.0f * right * at.right / (float)width, y = 2.0f * top * at.up / (float)height;
    sl_view view = sl_view_pyramid(&frame, camera->eye, x - right, x + right, y - top, y + top, width, height,
                                   1e-5f * scene->scale);
    view.kind = SL_VIEW_CAMERA;
    return view;
}

sl_view sl_view_of_camera(const sl_scene *scene, const sl_camera *camera, int width, int height) {
    return view_of(scene, camera, (sl_sub_frame){0}, width, height);
}

sl_view sl_view_scene(const sl_scene *scene, int width, int height) {
    sl_view view = view_of(scene, &scene->camera, scene->sub_frame, width, height);
    view.stencil = scene->sub_frame.wanted;
    return view;
}

static sl_vec3d row_of(const sl_view *view, int row) {
    return sl_v3d((double)view->clip[row][0], (double)view->clip[row][1], (double)view->clip[row][2]);
}

/* The d for which rows 0, 1 and 3 give (u, v, 1): by the rows' cross products. Their order of corners tells
 * mirrored views. */
sl_vec3 sl_view_direction(const sl_view *view, double x, double y) {
    sl_vec3d rx = row_of(view, 0), ry = row_of(view, 1), rw = row_of(view, 3);
    double u = 2.0 * x / (double)view->width - 1.0, v = 2.0 * y / (double)view->height - 1.0;
    sl_vec3d d =
        sl_addd(sl_addd(sl_scaled(sl_crossd(ry, rw), u), sl_scaled(sl_crossd(rw, rx), v)), sl_crossd(rx, ry));
    double turn = sl_dotd(rx, sl_crossd(ry, rw)) < 0.0 ? -1.0 : 1.0;
    return sl_normalize_or(sl_to_float(sl_scaled(d, turn)), sl_v3(0.0f, 0.0f, -1.0f));
}

sl_rgb sl_view_emission(const sl_view *view, const sl_scene *s, uint32_t triangle, size_t x, size_t y) {
    if (triangle != SL_NO_INDEX)
        return sl_scene_emission(s, triangle,
                                 sl_sub(view->origin, sl_scene_position(s, s->vertex[0][triangle])));
    if (!s->environment.present) return sl_grey(0.0f);
    return sl_environment_radiance(&s->environment,
                                   sl_view_direction(view, (double)x + 0.5, (double)y + 0.5));
}

/* Planes in the order of the clip codes: w -+ x, w -+ y, then near and far. */
static void make_planes(const sl_view *view, sl_pass_view *pass) {
    const float(*m)[4] = view->clip;
    for (int k = 0; k < 4; k++) {
        pass->plane[0][k] = m[3][k] - m[0][k];
        pass->plane[1][k] = m[3][k] + m[0][k];
        pass->plane[2][k] = m[3][k] - m[1][k];
        pass->plane[3][k] = m[3][k] + m[1][k];
        pass->plane[4][k] = pass->inverse_w ? m[2][k] : m[3][k] + m[2][k];
        pass->plane[5][k] = pass->inverse_w ? 0.0f : m[3][k] - m[2][k];
    }
    pass->planes = pass->inverse_w ? 5 : 6;
    for (int k = 0; k < 6; k++) pass->plane_length[k] = plane_length(pass->plane[k]);
}

/* Leaves an empty region at the viewport's corner for what lies outside. */
static void cut_by_scissor(const sl_scissor *s, sl_pass_view *pass) {
    if (s->x0 == 0 && s->x1 == 0) return;
    sl_scissor cut = {sl_larger(s->x0, pass->x0), sl_larger(s->y0, pass->y0), sl_smaller(s->x1, pass->x1),
                      sl_smaller(s->y1, pass->y1)};
    bool empty = cut.x0 >= cut.x1 || cut.y0 >= cut.y1;
    pass->x1 = empty ? pass->x0 : cut.x1;
    pass->y1 = empty ? pass->y0 : cut.y1;
    pass->x0 = empty ? pass->x0 : cut.x0;
    pass->y0 = empty ? pass->y0 : cut.y0;
}

sl_pass_view sl_pass_view_make(const sl_view *view, int width, int height) {
    float half_width = 0.5f * (float)view->width, half_height = 0.5f * (float)view->height;
    sl_pass_view pass = {.origin = {view->origin.x, view->origin.y, view->origin.z},
                         .half_width = half_width,
                         .half_height = half_height,
                         .offset_x = half_width + (float)view->x,
                         .offset_y = half_height + (float)view->y,
                         .width = width,
                         .height = height,
                         .x0 = view->x,
                         .y0 = view->y,
                         .x1 = view->x + view->width,
                         .y1 = view->y + view->height,
                         .inverse_w = view->depth == SL_DEPTH_INVERSE_W,
                         .skip = view->skip_triangle,
                         .left_out = view->left_out};
    pass.rule = pass.inverse_w        ? SL_NEARER_IS_LARGER
                : view->corner_planes ? SL_OPENGL_PLANE
                                      : SL_NEARER_IS_SMALLER;
    cut_by_scissor(&view->scissor, &pass);
    memcpy(pass.clip, view->clip, sizeof pass.clip);
    make_planes(view, &pass);
    return pass;
}
