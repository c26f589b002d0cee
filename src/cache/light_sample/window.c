/* A planar light as a window (the light-plane estimator): the picture's plane is the light's own, its frame the light's bounding rectangle,
 * turned by 18.4 degrees for the ratio, so that no edge of the scene runs along the pixels for long.
 *
 *              +--------/\--------+            Seen from wherever, a pixel is the same piece of the light. So whether its centre is on the light
 *              |      /    \      |            at all is found once, and only tangents depend on the point:
 *              |    /  light \    |
 *              |     \      /     |                x_i = (place of column i - point) . frame.x / h,
 *              +------- \/ -------+
 *                       :                      h being the point's distance to the plane. Between near and h an occluder hides; at h,
 *            h          :                      and beyond, nothing does: that is the far plane, and whatever is drawn at all hides the light.
 *                       o point
 */
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/light_sample/light_sample_internal.h"

/* ---- once a light ---- */

typedef struct {
    double left, right, bottom, top;
} rectangle;

static sl_vec3d corner_from(const sl_sampled_light *light, size_t k, sl_vec3d origin) {
    return sl_subd(sl_to_double(light->corner[k]), origin);
}

static rectangle bounds(const sl_sampled_light *light, sl_vec3d origin, sl_vec3d x, sl_vec3d y) {
    rectangle r = {INFINITY, -INFINITY, INFINITY, -INFINITY};
    for (size_t k = 0; k < 3 * light->triangles; k++) {
        sl_vec3d d = corner_from(light, k, origin);
        double u = sl_dotd(d, x), v = sl_dotd(d, y);
        r = (rectangle){fmin(r.left, u), fmax(r.right, u), fmin(r.bottom, v), fmax(r.top, v)};
    }
    return r;
}

/* The direction in the plane along which a rectangle around the light is smallest, of those of its first edges. */
static sl_vec3d best_direction(const sl_sampled_light *light, sl_vec3d origin, sl_vec3d normal) {
    enum { EDGES_TRIED = 96 };
    sl_frame any = sl_frame_from_normal(light->normal);
    sl_vec3d best = sl_to_double(any.x);
    double least = INFINITY;
    size_t edges = 3 * light->triangles < EDGES_TRIED ? 3 * light->triangles : EDGES_TRIED;
    for (size_t k = 0; k < edges; k++) {
        size_t next = k % 3 == 2 ? k - 2 : k + 1;
        sl_vec3d edge = sl_subd(sl_to_double(light->corner[next]), sl_to_double(light->corner[k]));
        edge = sl_subd(edge, sl_scaled(normal, sl_dotd(edge, normal)));
        double length = sl_lengthd(edge);
        if (!(length > 0.0)) continue;
        edge = sl_scaled(edge, 1.0 / length);
        rectangle r = bounds(light, origin, edge, sl_crossd(normal, edge));
        double area = (r.right - r.left) * (r.top - r.bottom);
        if (!(area < least * (1.0 - 1e-9))) continue;
        least = area;
        best = edge;
    }
    return best;
}

/* Sets the bits of the pixel centres in a triangle; edges belong to it. */
static void mark_triangle(const double u[3], const double v[3], const rectangle *r, int size, uint32_t *inside) {
    double step_u = (r->right - r->left) / (double)size, step_v = (r->top - r->bottom) / (double)size;
    double area = (u[1] - u[0]) * (v[2] - v[0]) - (u[2] - u[0]) * (v[1] - v[0]), sign = area < 0.0 ? -1.0 : 1.0;
    int i0 = (int)fmax((fmin(u[0], fmin(u[1], u[2])) - r->left) / step_u - 1.0, 0.0);
    int i1 = (int)fmin((fmax(u[0], fmax(u[1], u[2])) - r->left) / step_u + 1.0, (double)size);
    int j0 = (int)fmax((fmin(v[0], fmin(v[1], v[2])) - r->bottom) / step_v - 1.0, 0.0);
    int j1 = (int)fmin((fmax(v[0], fmax(v[1], v[2])) - r->bottom) / step_v + 1.0, (double)size);
    for (int j = j0; j < j1; j++) {
        double y = r->bottom + ((double)j + 0.5) * step_v;
        for (int i = i0; i < i1; i++) {
            double x = r->left + ((double)i + 0.5) * step_u;
            bool in = true;
            for (int k = 0; k < 3 && in; k++) {
                int m = (k + 1) % 3;
                in = sign * ((u[m] - u[k]) * (y - v[k]) - (v[m] - v[k]) * (x - u[k])) >= 0.0;
            }
            if (in) inside[(size_t)j * sl_window_words(size) + (size_t)(i / 32)] |= UINT32_C(1) << (i % 32);
        }
    }
}

static sl_status mark_light(const sl_sampled_light *light, const rectangle *r, int size, sl_light_window *w, uint32_t **inside,
                            sl_error *error) {
    sl_vec3d x = sl_to_double(w->frame.x), y = sl_to_double(w->frame.y);
    *inside = sl_allocate(sl_window_words(size) * (size_t)size, sizeof **inside);
    if (!*inside) return sl_fail_memory(error, "a lamp's window");
    for (size_t t = 0; t < light->triangles; t++) {
        double u[3], v[3];
        for (size_t k = 0; k < 3; k++) {
            sl_vec3d d = corner_from(light, 3 * t + k, w->origin);
            u[k] = sl_dotd(d, x);
            v[k] = sl_dotd(d, y);
        }
        mark_triangle(u, v, r, size, *inside);
    }
    return SL_OK;
}

sl_status sl_light_window_make(const sl_sampled_light *light, const sl_light_sample_settings *settings, sl_light_window *w,
                               sl_error *error) {
    sl_vec3d normal = sl_to_double(light->normal);
    w->origin = sl_to_double(light->corner[0]);
    sl_vec3d x = best_direction(light, w->origin, normal);
    if (settings->estimator == SL_LIGHT_RATIO) { /* by atan 1/3, about as far from all simple slopes as an angle can be */
        sl_vec3d across = sl_crossd(normal, x);
        x = sl_scaled(sl_addd(sl_scaled(x, 3.0), across), 1.0 / sqrt(10.0));
    }
    w->frame.z = sl_neg(light->normal);
    w->frame.x = sl_normalize_or(sl_to_float(x), sl_v3(1, 0, 0));
    w->frame.y = sl_normalize_or(sl_cross(w->frame.z, w->frame.x), sl_v3(0, 1, 0));
    rectangle r = bounds(light, w->origin, sl_to_double(w->frame.x), sl_to_double(w->frame.y));
    double least = 1e-9 * fmax(r.right - r.left, r.top - r.bottom) + 1e-30; /* of lights as thin as a line */
    r = (rectangle){r.left, fmax(r.right, r.left + least), r.bottom, fmax(r.top, r.bottom + least)};
    w->left = r.left, w->right = r.right, w->bottom = r.bottom, w->top = r.top;
    for (int level = 0; level < SL_WINDOW_LEVELS; level++) {
        if (1 << level < settings->size || 1 << level > settings->largest) continue;
        sl_status status = mark_light(light, &r, 1 << level, w, &w->inside[level], error);
        if (status != SL_OK) return status;
    }
    return SL_OK;
}

/* ---- once a sample ---- */

static int level_of(int size) {
    int level = 0;
    while (1 << level < size) level++;
    return level;
}

/* Window depth, for it has a far plane: near at `near`, far just before the light. */
static void set_depth_range(sl_view *view, sl_vec3 axis, double near, double far) {
    sl_vec3d a = sl_scaled(sl_to_double(axis), (far + near) / (far - near));
    view->clip[2][0] = (float)a.x;
    view->clip[2][1] = (float)a.y;
    view->clip[2][2] = (float)a.z;
    view->clip[2][3] = (float)(-2.0 * far * near / (far - near));
    view->depth = SL_DEPTH_WINDOW;
}

static void set_tangents(float *tangent, int size, double first, double last) {
    double step = (last - first) / (double)size;
    for (int i = 0; i < size; i++) tangent[i] = (float)(first + ((double)i + 0.5) * step);
}

sl_light_sums sl_light_reduce(const sl_light_sampling *sampling, int size, sl_light_sample_scratch *scratch, sl_counters *counters) {
    int final = sampling->settings.reduced;
    size_t left = (size_t)final * (size_t)final;
    sl_light_sums sums = {0.0, 0.0};
    sl_raster_reduce(scratch->planes, size, 2, final, scratch->halves, scratch->sums, counters);
    for (size_t i = 0; i < left; i++) {
        sums.seen += (double)scratch->sums[i];
        sums.all += (double)scratch->sums[left + i];
    }
    return sums;
}

sl_light_shot sl_window_shoot(const sl_light_sampling *sampling, size_t light, const sl_lit_point *point, int size,
                              sl_light_sample_scratch *scratch, sl_light_sums *sums, sl_counters *counters) {
    const sl_light_shape_info *shape = &sampling->shape[light];
    const sl_light_window *w = &shape->window;
    sl_vec3 eye = sl_light_eye(sampling, point);
    sl_frame frame = w->frame;
    sl_vec3d to = sl_subd(w->origin, sl_to_double(eye));
    double h = sl_dotd(to, sl_to_double(frame.z));
    if (h < 0.0) { /* of a two-sided light: its back */
        frame.z = sl_neg(frame.z);
        h = -h;
    }
    double far = h - fmax(SL_LIGHT_MARGIN * h, 2.0 * shape->flatness), near = fmin((double)sampling->near, 0.25 * h);
    if (!(far > near)) return SL_SHOT_IMPOSSIBLE;
    double x = sl_dotd(to, sl_to_double(frame.x)), y = sl_dotd(to, sl_to_double(frame.y));
    float left = (float)((w->left + x) / h), right = (float)((w->right + x) / h);
    float bottom = (float)((w->bottom + y) / h), top = (float)((w->top + y) / h);
    if (!(left < right) || !(bottom < top) || !isfinite(left + right + bottom + top)) return SL_SHOT_IMPOSSIBLE;
    sl_view view = sl_view_pyramid(&frame, eye, left, right, bottom, top, size, size, (float)near);
    set_depth_range(&view, frame.z, near, far);
    view.skip_triangle = point->triangle;
    if (!sampling->settings.all_triangles && sampling->settings.estimator == SL_LIGHT_RATIO && !sl_raster_meets(sampling->raster, &view)) return SL_SHOT_NOTHING_BETWEEN;
    sl_raster_id_small(sampling->raster, &view, &(sl_target){size, size, scratch->id, NULL}, scratch->raster, counters);
    set_tangents(scratch->column, size, (double)left, (double)right);
    set_tangents(scratch->row, size, (double)bottom, (double)top);
    sl_light_pixels pixels = {.size = size, .x = scratch->column, .y = scratch->row,
                              .step_x = (right - left) / (float)size, .step_y = (top - bottom) / (float)size,
                              .normal = sl_frame_to_local(&frame, point->normal),
                              .geometric = sl_frame_to_local(&frame, point->geometric_normal), .scale = (float)(1.0 / SL_PI),
                              .seen = scratch->planes, .all = scratch->planes + (size_t)size * (size_t)size};
    sampling->kernels.window(&pixels, w->inside[level_of(size)], scratch->id);
    scratch->picture_size = size;
    *sums = sl_light_reduce(sampling, size, scratch, counters);
    return SL_SHOT_TAKEN;
}
