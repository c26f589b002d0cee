#include "raster/views/outlines.h"

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "scene/edges.h"

#include <math.h>
#include <string.h>

/* A list of half-edges, by their numbers: one for each edge that counts from everywhere, two for one that is
 * a silhouette at times, the first of them marked. */
struct sl_outlines {
    const sl_scene *scene;
    uint32_t *list;
    size_t count, room;
};

#define TWO 0x80000000u

/* ---- which edges ---- */

static bool agree(sl_vec3 a, sl_vec3 b, float cosine) { return sl_dot(a, b) >= cosine; }

/* Does shading go on across the edge as if it were not there? */
static bool is_smooth(const sl_scene *s, const sl_half_edge *a, const sl_half_edge *b) {
    const float same = 0.9999f;
    const uint32_t turned = a->upwards != b->upwards;
    if (s->material_index[a->index / 3] != s->material_index[b->index / 3]) return false;
    for (uint32_t end = 0; end < 2; end++) {
        const sl_vec3 n = sl_scene_normal(s, sl_half_edge_vertex(s, a->index, end)),
                      m = sl_scene_normal(s, sl_half_edge_vertex(s, b->index, turned ? 1 - end : end));
        if (!agree(n, m, same)) return false;
    }
    return true;
}

static bool is_flat(const sl_scene *s, uint32_t t, uint32_t u) {
    return agree(sl_scene_geometric_normal(s, t), sl_scene_geometric_normal(s, u), 0.999999f);
}

/* Keeps the edge of `count` triangles, unless it is one of two that go on into each other in one plane. What
 * is kept takes the room of what has been looked at. */
static void keep(sl_outlines *o, const sl_half_edges *edges, size_t first, size_t count) {
    const sl_scene *s = o->scene;
    const sl_half_edge a = sl_half_edge_at(edges, first), b = sl_half_edge_at(edges, first + count - 1);
    const bool smooth = count == 2 && is_smooth(s, &a, &b);
    if (smooth && is_flat(s, a.index / 3, b.index / 3)) return;
    o->list[o->count++] = a.index | (smooth ? TWO : 0);
    if (smooth) o->list[o->count++] = b.index;
}

static bool find_edges(sl_outlines *o) {
    sl_half_edges edges = {0};
    if (3 * o->scene->triangle_count >= TWO || !sl_half_edges_list(o->scene, &edges)) {
        sl_half_edges_release(&edges);
        return false;
    }
    o->list = edges.index;
    for (size_t i = 0, end; i < edges.count; i = end) {
        end = sl_half_edges_of_one(&edges, i);
        keep(o, &edges, i, end - i);
    }
    edges.index = NULL;
    o->room = edges.count;
    sl_half_edges_release(&edges);
    if (o->count > o->room / 2) return true; /* a smaller copy would save little, and is one */
    o->room = o->count;
    return sl_regrow(&o->list, o->count, o->count, sizeof *o->list);
}

sl_status sl_outlines_create(const sl_scene *scene, sl_outlines **outlines, sl_error *error) {
    sl_outlines *o = *outlines = sl_allocate(1, sizeof *o);
    if (o) o->scene = scene;
    if (o && find_edges(o)) return SL_OK;
    sl_outlines_destroy(o);
    *outlines = NULL;
    return sl_fail_memory(error, "outlines");
}

void sl_outlines_destroy(sl_outlines *o) {
    if (o) sl_free(o->list);
    sl_free(o);
}

size_t sl_outlines_bytes(const sl_outlines *o) { return sizeof *o + o->room * sizeof *o->list; }

/* Half-edges, and places of vertices, of which there are no more than corners, with what sorting takes. */
double sl_outlines_need(double triangles) {
    return 3.0 * triangles * (double)(5 * sizeof(uint32_t) + sizeof(uint32_t));
}

/* ---- which pixels ---- */

typedef struct drawing {
    const sl_view *view;
    float *farthest; /* inverse w of the pixel and those around it */
    uint8_t *touched;
} drawing;

/* Window x and y in pixels, and inverse w. */
typedef struct window_point {
    double x, y, inverse_w;
} window_point;

typedef struct clip_point {
    double x, y, near, w;
} clip_point;

static double along(const float row[4], sl_vec3d q) {
    return (double)row[0] * q.x + (double)row[1] * q.y + (double)row[2] * q.z + (double)row[3];
}

static clip_point clip_of(const sl_view *view, sl_vec3 p) {
    const sl_vec3d q = sl_subd(sl_to_double(p), sl_to_double(view->origin));
    return (clip_point){along(view->clip[0], q), along(view->clip[1], q), along(view->clip[2], q),
                        along(view->clip[3], q)};
}

static clip_point between(clip_point a, clip_point b, double t) {
    return (clip_point){a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.near + t * (b.near - a.near),
                        a.w + t * (b.w - a.w)};
}

static window_point window_of(const sl_view *view, clip_point c) {
    return (window_point){(c.x / c.w + 1.0) * 0.5 * (double)view->width,
                          (c.y / c.w + 1.0) * 0.5 * (double)view->height, 1.0 / c.w};
}

static double at(double a, double b, double t) { return a + t * (b - a); }

/* Cuts [*from, *to] of a to b down to where lo <= value <= hi. False: nothing is left, or no number. */
static bool cut(double a, double b, double lo, double hi, double *from, double *to) {
    const double d = b - a;
    if (d == 0.0) return a >= lo && a <= hi;
    double enter = (lo - a) / d, leave = (hi - a) / d;
    if (enter > leave) {
        double t = enter;
        enter = leave, leave = t;
    }
    if (enter > *from) *from = enter;
    if (leave < *to) *to = leave;
    return *from <= *to;
}

static void touch(const drawing *d, int x, int y, double inverse_w) {
    if (x < 0 || y < 0 || x >= d->view->width || y >= d->view->height) return;
    const size_t i = (size_t)y * (size_t)d->view->width + (size_t)x;
    if (inverse_w * 1.0001 >= (double)d->farthest[i]) d->touched[i] = 1;
}

/* Touches the squares of one column (or row, where steep) that the segment meets within it. */
static void touch_column(const drawing *d, const window_point p[2], bool steep, int column) {
    const double slack = 1e-3;
    const double a[2] = {steep ? p[0].y : p[0].x, steep ? p[1].y : p[1].x},
                 b[2] = {steep ? p[0].x : p[0].y, steep ? p[1].x : p[1].y};
    double from = 0.0, to = 1.0;
    if (!cut(a[0], a[1], (double)column - slack, (double)column + 1.0 + slack, &from, &to)) return;
    const double b0 = at(b[0], b[1], from), b1 = at(b[0], b[1], to),
                 w0 = at(p[0].inverse_w, p[1].inverse_w, from), w1 = at(p[0].inverse_w, p[1].inverse_w, to);
    const int low = (int)floor(fmin(b0, b1) - slack), high = (int)floor(fmax(b0, b1) + slack);
    for (int k = low; k <= high; k++) touch(d, steep ? k : column, steep ? column : k, fmax(w0, w1));
}

static void draw_segment(const drawing *d, window_point a, window_point b) {
    double from = 0.0, to = 1.0;
    if (!cut(a.x, b.x, -1.0, (double)d->view->width + 1.0, &from, &to) ||
        !cut(a.y, b.y, -1.0, (double)d->view->height + 1.0, &from, &to))
        return;
    const window_point p[2] = {
        {at(a.x, b.x, from), at(a.y, b.y, from), at(a.inverse_w, b.inverse_w, from)},
        {at(a.x, b.x, to), at(a.y, b.y, to), at(a.inverse_w, b.inverse_w, to)}};
    const bool steep = fabs(p[1].y - p[0].y) > fabs(p[1].x - p[0].x);
    const double first = steep ? fmin(p[0].y, p[1].y) : fmin(p[0].x, p[1].x),
                 last = steep ? fmax(p[0].y, p[1].y) : fmax(p[0].x, p[1].x);
    for (int k = (int)floor(first - 1e-3); k <= (int)floor(last + 1e-3); k++) touch_column(d, p, steep, k);
}

static void draw_edge(const drawing *d, const sl_scene *s, uint32_t half_edge) {
    clip_point c[2];
    for (uint32_t k = 0; k < 2; k++)
        c[k] = clip_of(d->view, sl_scene_position(s, sl_half_edge_vertex(s, half_edge, k)));
    if (!(c[0].near >= 0.0) && !(c[1].near >= 0.0)) return;
    for (int k = 0; k < 2; k++)
        if (c[k].near < 0.0) c[k] = between(c[k], c[1 - k], c[k].near / (c[k].near - c[1 - k].near));
    if (c[0].w > 0.0 && c[1].w > 0.0) draw_segment(d, window_of(d->view, c[0]), window_of(d->view, c[1]));
}

static bool faces(const sl_scene *s, uint32_t triangle, sl_vec3 to_eye) {
    return sl_dot(sl_scene_geometric_normal(s, triangle), to_eye) > 0.0f;
}

static bool is_silhouette(const sl_scene *s, uint32_t a, uint32_t b, sl_vec3 eye) {
    const sl_vec3 to_eye = sl_sub(eye, sl_scene_position(s, sl_half_edge_vertex(s, a, 0)));
    return faces(s, a / 3, to_eye) != faces(s, b / 3, to_eye);
}

static void draw_edges(const drawing *d, const sl_outlines *o) {
    for (size_t i = 0; i < o->count; i++) {
        const uint32_t half_edge = o->list[i] & ~TWO;
        const bool two = o->list[i] & TWO;
        if (!two || is_silhouette(o->scene, half_edge, o->list[i + 1], d->view->origin))
            draw_edge(d, o->scene, half_edge);
        i += two;
    }
}

/* ---- pixels and those around them ---- */

static float least(float a, float b) { return b < a ? b : a; }

static void least_of(size_t count, const float *restrict depth, float *restrict to) {
    for (size_t i = 0; i < count; i++) to[i] = least(to[i], depth[i]);
}

/* Takes the least of columns, then of rows. */
static void spread_farthest(const sl_view *view, const float *depth, float *to) {
    const size_t width = (size_t)view->width, height = (size_t)view->height;
    for (size_t y = 0; y < height; y++) {
        float *row = to + y * width;
        memcpy(row, depth + y * width, width * sizeof *row);
        if (y > 0) least_of(width, depth + (y - 1) * width, row);
        if (y + 1 < height) least_of(width, depth + (y + 1) * width, row);
        float before = row[0];
        for (size_t x = 0; x < width; x++) {
            const float here = row[x], behind = x + 1 < width ? row[x + 1] : here;
            row[x] = least(least(before, here), behind);
            before = here;
        }
    }
}

static void spread_touched(const sl_view *view, const uint8_t *from, uint8_t *to) {
    for (int y = 0; y < view->height; y++) {
        for (int x = 0; x < view->width; x++) {
            if (!from[(size_t)y * (size_t)view->width + (size_t)x]) continue;
            for (int v = y ? y - 1 : 0; v <= y + 1 && v < view->height; v++)
                for (int u = x ? x - 1 : 0; u <= x + 1 && u < view->width; u++)
                    to[(size_t)v * (size_t)view->width + (size_t)u] = 1;
        }
    }
}

sl_status sl_outlines_draw(const sl_outlines *o, const sl_view *view, const float *depth, uint8_t *touched,
                           sl_error *error) {
    const size_t pixels = (size_t)view->width * (size_t)view->height;
    drawing d = {view, sl_allocate_unset(pixels, sizeof(float)), sl_allocate(pixels, 1)};
    bool made = d.farthest && d.touched;
    if (made) {
        spread_farthest(view, depth, d.farthest);
        draw_edges(&d, o);
        spread_touched(view, d.touched, touched);
    }
    sl_free(d.farthest);
    sl_free(d.touched);
    return made ? SL_OK : sl_fail_memory(error, "outlines");
}
