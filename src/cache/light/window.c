/* A planar light as a window (the light-plane estimator): the picture's plane is the light's own, and seen
 * from wherever, a pixel is the same piece of the light. So whether its centre is on the light at all is
 * found once, and only tangents and weights depend on the point. Between the eye and the plane an occluder
 * hides; there, and beyond, nothing does. That is the far plane, and so whatever is drawn at all hides the
 * light.
 *
 *           B  /\          The raster is turned against the light. Edges of a scene run along its lamps more
 *            /  . `\        often than not, and an edge along the pixels hides whole columns at a time: an
 *          / .light.  `\    error of up to 1/2N of the light, which shows as bands. Its slope is 0.382 (20.9
 *          `\ .     .   / A degrees), of all numbers one of those that fractions come near the least, so that
 *             `\ .   /      an edge cuts pixels evenly; at 1/3 (18.4 degrees) it repeats itself every third
 *                `\/ origin row, and errors are five times as large. It is turned as if the light were a
 *                 :         square, for of a tube's rectangle, turned, next to nothing would be light: A and
 *                 : h       B, along which the picture's rows and columns run, need not be square to each
 *                 o point   other. */
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/light/light_sample_internal.h"

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

/* The direction in the plane along which a rectangle around the light is smallest, of those of its first
 * edges. */
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

/* Sets the bits of the pixel centres in a triangle, whose corners are told in pixels; edges belong to it. */
static void mark_triangle(const double u[3], const double v[3], int size, uint32_t *inside) {
    double area = (u[1] - u[0]) * (v[2] - v[0]) - (u[2] - u[0]) * (v[1] - v[0]),
           sign = area < 0.0 ? -1.0 : 1.0;
    int i0 = (int)fmax(fmin(u[0], fmin(u[1], u[2])) - 1.0, 0.0),
        i1 = (int)fmin(fmax(u[0], fmax(u[1], u[2])) + 1.0, (double)size);
    int j0 = (int)fmax(fmin(v[0], fmin(v[1], v[2])) - 1.0, 0.0),
        j1 = (int)fmin(fmax(v[0], fmax(v[1], v[2])) + 1.0, (double)size);
    for (int j = j0; j < j1; j++) {
        for (int i = i0; i < i1; i++) {
            double x = (double)i + 0.5, y = (double)j + 0.5;
            bool in = true;
            for (int k = 0; k < 3 && in; k++) {
                int m = (k + 1) % 3;
                in = sign * ((u[m] - u[k]) * (y - v[k]) - (v[m] - v[k]) * (x - u[k])) >= 0.0;
            }
            if (in) inside[(size_t)j * sl_window_words(size) + (size_t)(i / 32)] |= UINT32_C(1) << (i % 32);
        }
    }
}

static sl_status mark_light(const sl_sampled_light *light, int size, const sl_light_window *w,
                            uint32_t **inside, sl_error *error) {
    *inside = sl_allocate(sl_window_words(size) * (size_t)size, sizeof **inside);
    if (!*inside) return sl_fail_memory(error, "a lamp's window");
    for (size_t t = 0; t < light->triangles; t++) {
        double u[3], v[3];
        for (size_t k = 0; k < 3; k++) {
            sl_vec3d d = corner_from(light, 3 * t + k, w->origin);
            u[k] = sl_dotd(d, w->over_a) * (double)size;
            v[k] = sl_dotd(d, w->over_b) * (double)size;
        }
        mark_triangle(u, v, size, *inside);
    }
    return SL_OK;
}

static sl_vec3d combine(sl_vec3d a, double s, sl_vec3d b, double t) {
    return sl_addd(sl_scaled(a, s), sl_scaled(b, t));
}

/* A, B and the origin so that origin + s A + t B, s and t in [0,1], is the smallest parallelogram around the
 * light with sides along a and b. */
static void place(const sl_sampled_light *light, sl_vec3d a, sl_vec3d b, sl_light_window *w) {
    sl_vec3d corner = sl_to_double(light->corner[0]);
    /* . d: the coordinates of d along a and b */
    sl_vec3d normal = sl_crossd(a, b), over_a = sl_crossd(b, normal), over_b = sl_crossd(normal, a);
    over_a = sl_scaled(over_a, 1.0 / sl_dotd(over_a, a));
    over_b = sl_scaled(over_b, 1.0 / sl_dotd(over_b, b));
    rectangle r = bounds(light, corner, over_a, over_b);
    w->a = sl_scaled(a, r.right - r.left);
    w->b = sl_scaled(b, r.top - r.bottom);
    w->over_a = sl_scaled(over_a, 1.0 / (r.right - r.left));
    w->over_b = sl_scaled(over_b, 1.0 / (r.top - r.bottom));
    w->origin = sl_addd(corner, combine(a, r.left, b, r.bottom));
}

sl_status sl_light_window_make(const sl_sampled_light *light, const sl_light_sample_settings *settings,
                               sl_light_window *w, sl_error *error) {
    sl_vec3d normal = sl_to_double(light->normal), corner = sl_to_double(light->corner[0]);
    sl_vec3d x = best_direction(light, corner, normal), y = sl_crossd(normal, x);
    rectangle r = bounds(light, corner, x, y);
    /* of lights thin as a line */
    double width = r.right - r.left, height = r.top - r.bottom, least = 1e-9 * fmax(width, height) + 1e-30;
    x = sl_scaled(x, fmax(width, least));
    y = sl_scaled(y, fmax(height, least));
    const double slope = 0.38196601125010515; /* (3 - sqrt 5) / 2 = 1/(2 + 1/(1 + 1/(1 + 1/(1 + ...)))) */
    if (settings->estimator == SL_LIGHT_RATIO)
        place(light, combine(x, 1.0, y, slope), combine(y, 1.0, x, -slope), w);
    else place(light, x, y, w);
    w->frame.z = sl_neg(light->normal);
    w->frame.x = sl_normalize_or(sl_to_float(x), sl_v3(1, 0, 0));
    w->frame.y = sl_normalize_or(sl_cross(w->frame.z, w->frame.x), sl_v3(0, 1, 0));
    w->side = fmax(sl_lengthd(w->a), sl_lengthd(w->b));
    for (int level = 0; level < SL_WINDOW_LEVELS; level++) {
        if (1 << level < settings->size || 1 << level > settings->largest) continue;
        sl_status status = mark_light(light, 1 << level, w, &w->inside[level], error);
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

static void set_row(float row[4], sl_vec3d a, double constant) {
    row[0] = (float)a.x;
    row[1] = (float)a.y;
    row[2] = (float)a.z;
    row[3] = (float)constant;
}

/* Along d the plane is met at point + h d / w, w = z . d, whose coordinate s along A is over_a . (point -
 * origin + h d / w); clip space wants (2 s - 1) w. With 1/w for depth, row 2 holds a plane that cuts and
 * nothing else: here the far one. */
static sl_view view_of(const sl_light_window *w, sl_vec3 eye, sl_vec3d z, double h, double far, int size) {
    sl_view view = {.kind = SL_VIEW_LIGHT,
                    .origin = eye,
                    .width = size,
                    .height = size,
                    .depth = SL_DEPTH_INVERSE_W,
                    .skip_triangle = SL_NO_INDEX};
    sl_vec3d from = sl_subd(sl_to_double(eye), w->origin);
    set_row(view.clip[0], combine(w->over_a, 2.0 * h, z, 2.0 * sl_dotd(w->over_a, from) - 1.0), 0.0);
    set_row(view.clip[1], combine(w->over_b, 2.0 * h, z, 2.0 * sl_dotd(w->over_b, from) - 1.0), 0.0);
    set_row(view.clip[2], sl_scaled(z, -1.0), far);
    set_row(view.clip[3], z, 0.0);
    return view;
}

/* Tangents along one axis of the frame: of pixel (i, j) column[i] + row[j]. */
static void set_tangents(float *column, float *row, int size, double a, double b, double first) {
    for (int i = 0; i < size; i++) {
        double middle = ((double)i + 0.5) / (double)size;
        column[i] = (float)(middle * a);
        row[i] = (float)(first + middle * b);
    }
}

sl_light_sums sl_light_reduce(const sl_light_query *query, int size) {
    sl_light_sample_scratch *scratch = query->scratch;
    int final = size < SL_REDUCED ? size : SL_REDUCED;
    size_t left = (size_t)final * (size_t)final;
    sl_light_sums sums = {.all = 0.0};
    sl_raster_reduce(scratch->planes, size, 2, final, scratch->halves, scratch->sums, query->counters);
    for (size_t i = 0; i < left; i++) {
        sums.seen += (double)scratch->sums[i];
        sums.all += (double)scratch->sums[left + i];
    }
    return sums;
}

static bool hides_all(const uint32_t *id, size_t pixels) {
    enum { BLOCK = 512 };
    for (size_t i = 0; i < pixels; i += BLOCK) {
        int seen = 0;
        size_t end = i + BLOCK < pixels ? i + BLOCK : pixels;
        for (size_t k = i; k < end; k++) seen |= id[k] == SL_NO_INDEX;
        if (seen) return false;
    }
    return true;
}

sl_light_shot sl_window_shoot(const sl_light_query *query, int size, sl_light_sums *sums) {
    const sl_light_sampling *sampling = query->sampling;
    const sl_light_shape_info *shape = &sampling->shape[query->light];
    const sl_light_window *w = &shape->window;
    const sl_lit_point *point = query->point;
    sl_light_sample_scratch *scratch = query->scratch;
    sl_frame frame = w->frame;
    sl_vec3d to = sl_subd(w->origin, sl_to_double(point->position)), x = sl_to_double(frame.x),
             y = sl_to_double(frame.y);
    /* of a two-sided light: its back */
    if (sl_dotd(to, sl_to_double(frame.z)) < 0.0) frame.z = sl_neg(frame.z);
    double h = sl_dotd(to, sl_to_double(frame.z)),
           eye_h = sl_dotd(sl_subd(w->origin, sl_to_double(query->eye)), sl_to_double(frame.z));
    double far = eye_h - fmax(SL_LIGHT_MARGIN * eye_h, 2.0 * shape->flatness);
    if (!(far > 0.0)) return SL_SHOT_IMPOSSIBLE;
    sl_view view = view_of(w, query->eye, sl_to_double(frame.z), eye_h, far, size);
    view.skip_triangle = point->triangle;
    bool cull = !sampling->settings.all_triangles && sampling->settings.estimator == SL_LIGHT_RATIO;
    if (cull && !sl_raster_meets(sampling->raster, &view)) return SL_SHOT_NOTHING_BETWEEN;
    sl_raster_id_small(sampling->raster, &view, &(sl_target){size, size, scratch->id, NULL}, scratch->raster,
                       query->counters);
    if (hides_all(scratch->id, (size_t)size * (size_t)size)) {
        memset(scratch->planes, 0, (size_t)size * (size_t)size * sizeof *scratch->planes);
        scratch->picture_size = size;
        return SL_SHOT_HIDDEN;
    }
    set_tangents(scratch->column_x, scratch->row_x, size, sl_dotd(w->a, x) / h, sl_dotd(w->b, x) / h,
                 sl_dotd(to, x) / h);
    set_tangents(scratch->column_y, scratch->row_y, size, sl_dotd(w->a, y) / h, sl_dotd(w->b, y) / h,
                 sl_dotd(to, y) / h);
    double pixel = sl_lengthd(sl_crossd(w->a, w->b)) / (h * h * (double)size * (double)size);
    sl_light_pixels pixels = {.size = size,
                              .column_x = scratch->column_x,
                              .column_y = scratch->column_y,
                              .row_x = scratch->row_x,
                              .row_y = scratch->row_y,
                              .normal = sl_frame_to_local(&frame, point->normal),
                              .geometric = sl_frame_to_local(&frame, point->geometric_normal),
                              .scale = (float)(pixel / SL_PI),
                              .seen = scratch->planes,
                              .all = scratch->planes + (size_t)size * (size_t)size};
    sampling->kernels.window(&pixels, w->inside[level_of(size)], scratch->id);
    scratch->picture_size = size;
    *sums = sl_light_reduce(query, size);
    return SL_SHOT_TAKEN;
}
