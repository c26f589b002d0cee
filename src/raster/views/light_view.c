/* The pyramid around an area light (light_view.h), in four steps: the light's outline relative to the eye,
 * cut at the horizon; an axis within all its directions; the roll around the axis; the rectangle, padded for
 * rounding. */
#include "raster/views/light_view.h"

#include <float.h>
#include <math.h>

enum { OUTLINE_MAX = 4 * SL_LIGHT_TRIANGLES }; /* a triangle cut by one plane has at most four corners */

/* Directions more than 88.9 degrees off the axis would need tangents of more than 50. */
static const double least_cosine = 0.02;

/* Corners relative to the eye; those of one piece follow each other, so that its edges are known. */
typedef struct {
    size_t count;
    sl_vec3d d[OUTLINE_MAX];
    double length[OUTLINE_MAX];
    size_t next[OUTLINE_MAX]; /* the other end of the edge that starts here */
} outline;

/* ---- 1. outline ---- */

static bool finite_triangle(const sl_vec3 *corner) {
    return sl_is_finite(corner[0]) && sl_is_finite(corner[1]) && sl_is_finite(corner[2]);
}

/* The eye is on the side to which the triangle shines. In its plane counts as not: irradiance is 0 there. */
static bool turned_to_eye(const sl_vec3d d[3]) {
    sl_vec3d normal = sl_crossd(sl_subd(d[1], d[0]), sl_subd(d[2], d[0]));
    return sl_dotd(normal, d[0]) < 0.0;
}

/* Appends the part of the triangle with n . d > 0 (Sutherland and Hodgman's step for one plane). */
static void add_above_horizon(outline *o, const sl_vec3d d[3], sl_vec3d n, bool horizon) {
    size_t first = o->count;
    double height[3];
    for (int k = 0; k < 3; k++) height[k] = horizon ? sl_dotd(n, d[k]) : 1.0;
    if (!(height[0] > 0.0) && !(height[1] > 0.0) && !(height[2] > 0.0)) return;
    for (int k = 0; k < 3; k++) {
        int m = (k + 1) % 3;
        if (height[k] >= 0.0) o->d[o->count++] = d[k];
        if ((height[k] < 0.0 && height[m] > 0.0) || (height[k] > 0.0 && height[m] < 0.0)) {
            double t = height[k] / (height[k] - height[m]);
            o->d[o->count++] = sl_addd(d[k], sl_scaled(sl_subd(d[m], d[k]), t));
        }
    }
    for (size_t i = first; i < o->count; i++) {
        o->next[i] = i + 1 < o->count ? i + 1 : first;
        o->length[i] = sl_lengthd(o->d[i]);
    }
}

static void add_triangle(outline *o, sl_vec3d eye, const sl_vec3 *corner, sl_vec3d normal, bool horizon,
                         bool two_sided) {
    if (!finite_triangle(corner)) return;
    sl_vec3d d[3];
    for (int k = 0; k < 3; k++) d[k] = sl_subd(sl_to_double(corner[k]), eye);
    if (two_sided || turned_to_eye(d)) add_above_horizon(o, d, normal, horizon);
}

/* Two triangles a side; which way they face does not matter. */
static void add_box(outline *o, sl_vec3d eye, sl_vec3 low, sl_vec3 high, sl_vec3d normal, bool horizon) {
    for (int axis = 0; axis < 3; axis++) {
        for (int side = 0; side < 2; side++) {
            sl_vec3 p[4];
            for (int c = 0; c < 4; c++) {
                int bits[3];
                bits[axis] = side;
                bits[(axis + 1) % 3] = c == 1 || c == 2;
                bits[(axis + 2) % 3] = c >= 2;
                p[c] = sl_v3(bits[0] ? high.x : low.x, bits[1] ? high.y : low.y, bits[2] ? high.z : low.z);
            }
            const sl_vec3 half[2][3] = {{p[0], p[1], p[2]}, {p[0], p[2], p[3]}};
            add_triangle(o, eye, half[0], normal, horizon, true);
            add_triangle(o, eye, half[1], normal, horizon, true);
        }
    }
}

static void make_outline(outline *o, sl_vec3 eye, sl_vec3 normal, const sl_light_shape *light) {
    sl_vec3d e = sl_to_double(eye), n = sl_to_double(normal);
    bool horizon = sl_lengthd(n) > 0.0;
    o->count = 0;
    if (light->triangles <= SL_LIGHT_TRIANGLES) {
        for (size_t t = 0; t < light->triangles; t++) {
            add_triangle(o, e, light->corner + 3 * t, n, horizon, light->two_sided);
        }
        return;
    }
    sl_box box = sl_box_empty();
    for (size_t t = 0; t < light->triangles; t++) {
        if (!finite_triangle(light->corner + 3 * t)) continue;
        for (size_t k = 0; k < 3; k++) sl_box_add(&box, light->corner[3 * t + k]);
    }
    if (box.low.x <= box.high.x) add_box(o, e, box.low, box.high, n, horizon);
}

/* ---- 2. axis ---- */

static sl_vec3d unit_or_zero(sl_vec3d d) {
    double length = sl_lengthd(d);
    return length > 0.0 && isfinite(length) ? sl_scaled(d, 1.0 / length) : sl_v3d(0, 0, 0);
}

/* The middle of the smallest cap around the directions, by Badoiu and Clarkson's iteration for the smallest
 * enclosing ball (2003): step towards the farthest by ever less. A corner at the eye itself has no direction
 * and needs none: its edges are held by their other ends. */
static sl_vec3d middle_direction(const outline *o) {
    sl_vec3d u[OUTLINE_MAX], centre = {0, 0, 0};
    size_t count = 0;
    for (size_t i = 0; i < o->count; i++) {
        u[count] = unit_or_zero(o->d[i]);
        if (sl_lengthd(u[count]) > 0.5) centre = sl_addd(centre, u[count++]);
    }
    if (count == 0) return centre;
    centre = sl_scaled(centre, 1.0 / (double)count);
    for (int step = 2; step < 34; step++) {
        size_t farthest = 0;
        double largest = -1.0;
        for (size_t i = 0; i < count; i++) {
            double distance = sl_lengthd(sl_subd(u[i], centre));
            if (distance > largest) farthest = i;
            if (distance > largest) largest = distance;
        }
        centre = sl_addd(centre, sl_scaled(sl_subd(u[farthest], centre), 1.0 / (double)step));
    }
    return unit_or_zero(centre);
}

/* ---- 3. roll, 4. rectangle ---- */

typedef struct {
    double left, right, bottom, top; /* tangents */
    double nearest, farthest;        /* along z */
    double least_cosine;
} extent;

static inline double lesser(double a, double b) { return b < a ? b : a; } /* NaN in b: a */
static inline double greater(double a, double b) { return b > a ? b : a; }

static extent measure(const outline *o, sl_vec3d x, sl_vec3d y, sl_vec3d z) {
    extent e = {INFINITY, -INFINITY, INFINITY, -INFINITY, INFINITY, 0.0, 1.0};
    for (size_t i = 0; i < o->count; i++) {
        double w = sl_dotd(o->d[i], z), length = o->length[i];
        e.nearest = lesser(e.nearest, w);
        e.farthest = greater(e.farthest, w);
        if (!(length > 0.0)) continue;
        e.least_cosine = lesser(e.least_cosine, w / length);
        if (!(w > 0.0)) continue;
        double u = sl_dotd(o->d[i], x) / w, v = sl_dotd(o->d[i], y) / w;
        e.left = lesser(e.left, u);
        e.right = greater(e.right, u);
        e.bottom = lesser(e.bottom, v);
        e.top = greater(e.top, v);
    }
    return e;
}

static double area_of(const extent *e) {
    const double thin = 1e-6; /* so that of the rectangles around a line the shortest wins */
    return (e->right - e->left + thin) * (e->top - e->bottom + thin);
}

/* Of the rectangles with a side along some edge the smallest: the smallest of all has a side along an edge of
 * the convex hull (Freeman and Shapira 1975), and those of one convex light are among the edges. */
static void roll_tight(const outline *o, sl_vec3d z, sl_vec3d *x, sl_vec3d *y) {
    sl_vec3d x0 = *x, y0 = *y;
    extent first = measure(o, x0, y0, z);
    double best = area_of(&first);
    for (size_t i = 0; i < o->count; i++) {
        sl_vec3d p = o->d[i], q = o->d[o->next[i]];
        double wp = sl_dotd(p, z), wq = sl_dotd(q, z);
        if (!(wp > 0.0) || !(wq > 0.0)) continue;
        double eu = sl_dotd(q, x0) / wq - sl_dotd(p, x0) / wp, ev = sl_dotd(q, y0) / wq - sl_dotd(p, y0) / wp;
        double length = sqrt(eu * eu + ev * ev);
        if (!(length > 1e-12)) continue;
        sl_vec3d along = sl_addd(sl_scaled(x0, eu / length), sl_scaled(y0, ev / length)),
                 across = sl_crossd(z, along);
        extent e = measure(o, along, across, z);
        double area = area_of(&e);
        if (!(area < best)) continue;
        best = area;
        *x = along;
        *y = across;
    }
}

/* A clip coordinate row . q is off by at most 5 roundings of |row| |q| (the row's, q's, the product's, two
 * sums'). In tangents at distance 1 that is |q| / w = 1 / cosine times sqrt(1 + middle^2) for x or y, and
 * half the width for w. */
static double padding(double low, double high, double cosine) {
    double middle = 0.5 * (low + high), half = 0.5 * (high - low);
    return 8.0 * 0x1p-24 * (sqrt(1.0 + middle * middle) + half) / cosine;
}

static sl_light_sight hold(const outline *o, sl_vec3 eye, const sl_frame *frame, int width, int height,
                           float near, sl_light_view *out) {
    extent e = measure(o, sl_to_double(frame->x), sl_to_double(frame->y), sl_to_double(frame->z));
    if (!(e.least_cosine >= least_cosine) || !(e.left <= e.right)) return SL_LIGHT_TOO_WIDE;
    double pad_x = padding(e.left, e.right, e.least_cosine), pad_y = padding(e.bottom, e.top, e.least_cosine);
    out->frame = *frame;
    out->left = (float)(e.left - pad_x);
    out->right = (float)(e.right + pad_x);
    out->bottom = (float)(e.bottom - pad_y);
    out->top = (float)(e.top + pad_y);
    out->nearest = (float)e.nearest;
    out->farthest = (float)e.farthest;
    float half_way = 0.5f * out->nearest;
    float clip = half_way >= FLT_MIN && half_way < near ? half_way : near;
    out->view =
        sl_view_pyramid(frame, eye, out->left, out->right, out->bottom, out->top, width, height, clip);
    out->view.kind = SL_VIEW_LIGHT;
    return SL_LIGHT_IN_VIEW;
}

sl_light_sight sl_view_light(sl_vec3 eye, sl_vec3 normal, const sl_light_shape *light, int width, int height,
                             float near, sl_light_view *out) {
    outline o;
    if (!sl_is_finite(eye) || !sl_is_finite(normal)) return SL_LIGHT_HIDDEN;
    make_outline(&o, eye, normal, light);
    if (o.count == 0) return SL_LIGHT_HIDDEN;
    sl_vec3 axis = sl_normalize_or(sl_to_float(middle_direction(&o)), sl_v3(0, 0, 0));
    if (!(sl_length(axis) > 0.5f)) return SL_LIGHT_TOO_WIDE;
    sl_frame frame = sl_frame_from_normal(axis);
    sl_vec3d x = sl_to_double(frame.x), y = sl_to_double(frame.y);
    roll_tight(&o, sl_to_double(axis), &x, &y);
    frame.x = sl_to_float(x);
    frame.y = sl_to_float(y);
    return hold(&o, eye, &frame, width, height, near, out);
}
