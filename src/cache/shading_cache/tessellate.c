/* Curved surfaces as triangles for a view (section on curved surfaces): cut so finely that no chord is
 * further than half a pixel from the surface. A surface's inside is a grid; between that and its edges runs a
 * strip of triangles, as edges are cut as finely as the finer one of the surfaces that meet there wants them,
 * and at the same points: so nothing can tear. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/shading_cache/display_parts.h"
#include "scene/bicubic.h"

/* Pieces along a side: at least two, so that there is an inside. */
enum { RATE_MIN = 2, RATE_OUTSIDE = 8 /* at most, where it is not in the picture */, RATE_MAX = 64 };

/* ---- edges that are one ---------------------------------------------------------------------- */

/* By 4 surface + edge; an edge runs from corner i to i + 1. */
struct sl_curved_edges {
    size_t count;              /* surfaces */
    uint32_t *primitive;
    uint32_t *same;            /* the lowest of the edges that have the same control points */
    /* its control points, from u or v = 0 to 1, run against the way that all of those agree on */
    bool *backwards;
};

typedef struct edge_points {
    sl_vec3 p[4];
    uint32_t edge;
} edge_points;

static sl_vec3 edge_control(const sl_bicubic *b, int edge, int i) {
    return edge == 0   ? b->point[0][i]
           : edge == 1 ? b->point[i][3]
           : edge == 2 ? b->point[3][i]
                       : b->point[i][0];
}

static int compare_points(const sl_vec3 *a, const sl_vec3 *b) {
    const float x[3] = {a->x, a->y, a->z}, y[3] = {b->x, b->y, b->z};
    for (int k = 0; k < 3; k++) {
        if (x[k] != y[k]) return x[k] < y[k] ? -1 : 1;
    }
    return 0;
}

static int compare_edges(const void *a, const void *b) {
    const edge_points *x = a, *y = b;
    for (int i = 0; i < 4; i++) {
        int order = compare_points(&x->p[i], &y->p[i]);
        if (order) return order;
    }
    return x->edge < y->edge ? -1 : x->edge > y->edge;
}

static bool same_points(const edge_points *a, const edge_points *b) {
    bool same = true;
    for (int i = 0; i < 4; i++) same = same && compare_points(&a->p[i], &b->p[i]) == 0;
    return same;
}

/* Both ways to run are told apart by their points; the smaller one is agreed on. */
static edge_points agreed_points(const sl_bicubic *b, uint32_t edge, bool *backwards) {
    edge_points forth = {.edge = edge}, back = {.edge = edge};
    for (int i = 0; i < 4; i++) forth.p[i] = back.p[3 - i] = edge_control(b, (int)(edge % 4), i);
    *backwards = compare_edges(&back, &forth) < 0;
    return *backwards ? back : forth;
}

sl_status sl_curved_edges_find(const sl_primitives *p, sl_curved_edges **curved, sl_error *error) {
    sl_curved_edges *c = sl_allocate(1, sizeof *c);
    size_t count = p->curved;
    edge_points *points = sl_allocate(4 * count, sizeof *points);
    bool ok = c && points && (c->primitive = sl_allocate(count, sizeof *c->primitive)) &&
              (c->same = sl_allocate(4 * count, sizeof *c->same)) &&
              (c->backwards = sl_allocate(4 * count, sizeof *c->backwards));
    for (uint32_t i = 0; ok && i < p->count; i++) {
        if (p->kind[i] == SL_PRIMITIVE_BICUBIC) c->primitive[c->count++] = i;
    }
    for (uint32_t e = 0; ok && e < 4 * count; e++) {
        points[e] = agreed_points(&p->scene->bicubics[p->bicubic[c->primitive[e / 4]]], e, &c->backwards[e]);
    }
    if (ok) qsort(points, 4 * count, sizeof *points, compare_edges);
    for (size_t i = 0; ok && i < 4 * count; i++) {
        bool same = i > 0 && same_points(&points[i], &points[i - 1]);
        c->same[points[i].edge] = same ? c->same[points[i - 1].edge] : points[i].edge;
    }
    sl_free(points);
    if (ok) *curved = c;
    else sl_curved_edges_destroy(c);
    return ok ? SL_OK : sl_fail_memory(error, "curved surfaces");
}

void sl_curved_edges_destroy(sl_curved_edges *c) {
    if (!c) return;
    sl_free(c->primitive);
    sl_free(c->same);
    sl_free(c->backwards);
    sl_free(c);
}

static const sl_bicubic *surface_of(const sl_display *d, const sl_scene *scene, size_t surface) {
    return &scene->bicubics[d->primitives->bicubic[d->curved->primitive[surface]]];
}

/* ---- rates ----------------------------------------------------------------------------------- */

/* Bounds of second derivatives of a Bezier surface, from differences of control points: 6 |second
 * differences|, 9 |mixed ones|. */
typedef struct curvature {
    double uu, uv, vv;
} curvature;

static sl_vec3d control(const sl_bicubic *b, int j, int i) { return sl_to_double(b->point[j][i]); }

static double second_difference(sl_vec3d a, sl_vec3d b, sl_vec3d c) {
    return sl_lengthd(sl_subd(sl_addd(a, c), sl_scaled(b, 2.0)));
}

static curvature curvature_of(const sl_bicubic *b) {
    curvature c = {0, 0, 0};
    for (int j = 0; j < 4; j++) {
        for (int i = 0; i < 2; i++) {
            c.uu = fmax(
                c.uu, 6.0 * second_difference(control(b, j, i), control(b, j, i + 1), control(b, j, i + 2)));
            c.vv = fmax(
                c.vv, 6.0 * second_difference(control(b, i, j), control(b, i + 1, j), control(b, i + 2, j)));
        }
    }
    for (int j = 0; j < 3; j++) {
        for (int i = 0; i < 3; i++) {
            sl_vec3d low = sl_subd(control(b, j, i + 1), control(b, j, i)),
                     high = sl_subd(control(b, j + 1, i + 1), control(b, j + 1, i));
            c.uv = fmax(c.uv, 9.0 * sl_lengthd(sl_subd(high, low)));
        }
    }
    return c;
}

/* Pixels that a unit of length can cover where control points are nearest to the eye; infinite if they reach
 * behind it. *outside: all of them lie beyond one side of the picture. */
static double pixels_per_unit(const sl_bicubic *b, const sl_view *view, const sl_camera *camera,
                              bool *outside) {
    double nearest = INFINITY;
    int beyond[5] = {0, 0, 0, 0, 0};
    for (int k = 0; k < 16; k++) {
        double q[3] = {(double)b->point[k / 4][k % 4].x - (double)view->origin.x,
                       (double)b->point[k / 4][k % 4].y - (double)view->origin.y,
                       (double)b->point[k / 4][k % 4].z - (double)view->origin.z},
               clip[4];
        for (int i = 0; i < 4; i++) {
            const float *row = view->clip[i];
            clip[i] = (double)row[0] * q[0] + (double)row[1] * q[1] + (double)row[2] * q[2] + (double)row[3];
        }
        const bool out[5] = {clip[0] > clip[3], clip[0]<-clip[3], clip[1]> clip[3], clip[1] < -clip[3],
                             clip[3] <= 0.0};
        for (int i = 0; i < 5; i++) beyond[i] += out[i];
        nearest = fmin(nearest, clip[3]);
    }
    *outside = false;
    for (int i = 0; i < 5; i++) *outside = *outside || beyond[i] == 16;
    /* A step by one across the line of sight is seen under an angle that is larger towards the picture's
     * corners. */
    double up = sl_tan(0.5 * (double)camera->vertical_fov),
           right = up * (double)view->width / (double)view->height;
    double over_focal = 0.5 * (double)view->height / up * sqrt(1.0 + up * up + right * right);
    return nearest > 0.0 ? over_focal / nearest : INFINITY;
}

static int rate_for(double pixels, bool outside) {
    double most = outside ? RATE_OUTSIDE : RATE_MAX, pieces = ceil(sqrt(pixels));
    /* the last for NaN */
    return pieces >= RATE_MIN ? (int)fmin(pieces, most) : pieces < RATE_MIN ? RATE_MIN : (int)most;
}

/* A triangle with legs h_u, h_v is off by at most (h_u^2 |B_uu| + 2 h_u h_v |B_uv| + h_v^2 |B_vv|) / 8: half
 * a pixel if no term is above one. */
static void find_rates(const sl_display *d, const sl_scene *scene, sl_curved_rates *rates) {
    const sl_curved_edges *c = d->curved;
    sl_view view = sl_view_scene(scene, d->settings.width, d->settings.height);
    for (size_t s = 0; s < c->count; s++) {
        bool outside;
        double scale = pixels_per_unit(surface_of(d, scene, s), &view, &scene->camera, &outside);
        curvature bend = curvature_of(surface_of(d, scene, s));
        double u = fmax(bend.uu, bend.uv), v = fmax(bend.vv, bend.uv);
        rates[s].u = rate_for(u > 0.0 ? u * scale : 0.0, outside);
        rates[s].v = rate_for(v > 0.0 ? v * scale : 0.0, outside);
        for (int e = 0; e < 4; e++) rates[s].edge[e] = 0;
    }
    /* the lowest of those that are one gathers what they want ... */
    for (size_t e = 0; e < 4 * c->count; e++) {
        int *shared = &rates[c->same[e] / 4].edge[c->same[e] % 4],
            wanted = e % 2 ? rates[e / 4].v : rates[e / 4].u;
        if (wanted > *shared) *shared = wanted;
    }
    for (size_t e = 0; e < 4 * c->count; e++)
        rates[e / 4].edge[e % 4] = rates[c->same[e] / 4].edge[c->same[e] % 4];
}

/* ---- vertices -------------------------------------------------------------------------------- */

/* Of a surface: first those around it, edge by edge, each without its end; then the inside, row by row. */
static int ring_of(const sl_curved_rates *r) { return r->edge[0] + r->edge[1] + r->edge[2] + r->edge[3]; }
static int vertices_of(const sl_curved_rates *r) { return ring_of(r) + (r->u - 1) * (r->v - 1); }
/* The strip has a triangle for each piece of an edge and of the inside's boundary. */
static int triangles_of(const sl_curved_rates *r) {
    return ring_of(r) + 2 * (r->u - 2 + r->v - 2) + 2 * (r->u - 2) * (r->v - 2);
}

static sl_vec3 curve_at(const sl_vec3 p[4], double t) {
    double s = 1.0 - t, weight[4] = {s * s * s, 3.0 * t * s * s, 3.0 * t * t * s, t * t * t};
    sl_vec3d sum = {0, 0, 0};
    for (int i = 0; i < 4; i++) sum = sl_addd(sum, sl_scaled(sl_to_double(p[i]), weight[i]));
    return sl_to_float(sum);
}

static void put_vertex(sl_tessellation *t, size_t at, sl_vec3 position, double u, double v) {
    t->x[at] = position.x;
    t->y[at] = position.y;
    t->z[at] = position.z;
    t->u[at] = (float)u;
    t->v[at] = (float)v;
}

/* Points of an edge come from its own curve, run through the agreed way: the same bits for all that share it.
 */
static void put_edge(const sl_display *d, const sl_scene *scene, sl_tessellation *t, size_t surface, int edge,
                     size_t at) {
    const sl_bicubic *b = surface_of(d, scene, surface);
    bool backwards = d->curved->backwards[4 * surface + (size_t)edge], downwards = edge >= 2;
    int rate = t->rates[surface].edge[edge];
    sl_vec3 p[4];
    for (int i = 0; i < 4; i++) p[i] = edge_control(b, edge, backwards ? 3 - i : i);
    for (int k = 0; k < rate; k++) {
        int natural = downwards ? rate - k : k, agreed = backwards ? rate - natural : natural;
        double along = (double)natural / rate, u = edge % 2 ? (edge == 1 ? 1.0 : 0.0) : along,
               v = edge % 2    ? along
                   : edge == 2 ? 1.0
                               : 0.0;
        put_vertex(t, at + (size_t)k, curve_at(p, (double)agreed / rate), u, v);
    }
}

static void put_vertices(const sl_display *d, const sl_scene *scene, sl_tessellation *t) {
    size_t at = 0;
    for (size_t s = 0; s < d->curved->count; s++) {
        const sl_curved_rates *r = &t->rates[s];
        for (int e = 0; e < 4; e++) {
            put_edge(d, scene, t, s, e, at);
            at += (size_t)r->edge[e];
        }
        for (int j = 1; j < r->v; j++) {
            for (int i = 1; i < r->u; i++) {
                double u = (double)i / r->u, v = (double)j / r->v;
                sl_vec3 position;
                sl_bicubic_at(surface_of(d, scene, s), u, v, &position, NULL);
                put_vertex(t, at++, position, u, v);
            }
        }
        memcpy(t->point + 16 * s, surface_of(d, scene, s)->point, sizeof surface_of(d, scene, s)->point);
    }
}

/* ---- triangles ------------------------------------------------------------------------------- */

static bool same_place(const sl_tessellation *t, uint32_t a, uint32_t b) {
    return t->x[a] == t->x[b] && t->y[a] == t->y[b] && t->z[a] == t->z[b];
}

/* Where an edge is one point, triangles that have two corners there are none. */
static void put_triangle(sl_tessellation *t, uint32_t primitive, size_t a, size_t b, size_t c) {
    const uint32_t corner[3] = {(uint32_t)a, (uint32_t)b, (uint32_t)c};
    if (same_place(t, corner[0], corner[1]) || same_place(t, corner[1], corner[2]) ||
        same_place(t, corner[2], corner[0]))
        return;
    for (int k = 0; k < 3; k++) t->vertex[k][t->triangle_count] = corner[k];
    t->primitive[t->triangle_count++] = primitive;
}

/* Vertex n of the inside's boundary beside an edge, in the direction of the edge. */
static size_t inside_vertex(const sl_curved_rates *r, size_t first, int edge, int n) {
    int column = edge == 0 ? n : edge == 1 ? r->u - 2 : edge == 2 ? r->u - 2 - n : 0;
    int row = edge == 0 ? 0 : edge == 1 ? n : edge == 2 ? r->v - 2 : r->v - 2 - n;
    return first + (size_t)ring_of(r) + (size_t)row * (size_t)(r->u - 1) + (size_t)column;
}

/* Between an edge in `rate` pieces and the inside's boundary: always on from the side whose next piece has
 * its middle first. */
static void put_strip(sl_tessellation *t, uint32_t primitive, const sl_curved_rates *r, size_t first,
                      int edge) {
    int rate = r->edge[edge], pieces = edge % 2 ? r->v : r->u, begin = 0;
    for (int e = 0; e < edge; e++) begin += r->edge[e];
    int ring = ring_of(r), outer = 0, inner = 0;
    while (outer < rate || inner < pieces - 2) {
        size_t here = first + (size_t)(begin + outer), beside = inside_vertex(r, first, edge, inner);
        bool out =
            inner == pieces - 2 || (outer < rate && (2 * outer + 1) * pieces <= (2 * inner + 3) * rate);
        if (out) put_triangle(t, primitive, here, first + (size_t)((begin + ++outer) % ring), beside);
        else
            put_triangle(t, primitive, first + (size_t)((begin + outer) % ring),
                         inside_vertex(r, first, edge, ++inner), beside);
    }
}

static void put_triangles(const sl_display *d, sl_tessellation *t) {
    size_t first = 0;
    t->triangle_count = 0;
    for (size_t s = 0; s < d->curved->count; s++) {
        const sl_curved_rates *r = &t->rates[s];
        uint32_t primitive = d->curved->primitive[s];
        for (int e = 0; e < 4; e++) put_strip(t, primitive, r, first, e);
        size_t width = (size_t)(r->u - 1), inside = first + (size_t)ring_of(r);
        for (int j = 0; j < r->v - 2; j++) {
            for (int i = 0; i < r->u - 2; i++) {
                size_t at = inside + (size_t)j * width + (size_t)i;
                put_triangle(t, primitive, at, at + 1, at + width + 1);
                put_triangle(t, primitive, at, at + width + 1, at + width);
            }
        }
        first += (size_t)vertices_of(r);
    }
}

/* ---- the whole ------------------------------------------------------------------------------- */

void sl_tessellation_release(sl_tessellation *t) {
    if (t->masked) sl_free(t->masked->material_index);
    sl_free(t->masked);
    void *all[] = {t->x,         t->y,         t->z,         t->u,     t->v,    t->vertex[0],
                   t->vertex[1], t->vertex[2], t->primitive, t->rates, t->point};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) sl_free(all[i]);
    sl_raster_destroy(t->raster);
    memset(t, 0, sizeof *t);
}

static bool has_moved(const sl_display *d, const sl_scene *scene, const sl_tessellation *t) {
    for (size_t s = 0; s < d->curved->count; s++) {
        const sl_bicubic *b = surface_of(d, scene, s);
        if (memcmp(t->point + 16 * s, b->point, sizeof b->point) != 0) return true;
    }
    return false;
}

static bool allocate(sl_tessellation *t, size_t vertices, size_t triangles, size_t surfaces) {
    float **by_vertex[5] = {&t->x, &t->y, &t->z, &t->u, &t->v};
    uint32_t **by_triangle[4] = {&t->vertex[0], &t->vertex[1], &t->vertex[2], &t->primitive};
    bool ok = (t->point = sl_allocate(16 * surfaces, sizeof *t->point)) != NULL;
    for (int k = 0; k < 5; k++) ok = (*by_vertex[k] = sl_allocate(vertices, sizeof(float))) && ok;
    for (int k = 0; k < 4; k++) ok = (*by_triangle[k] = sl_allocate(triangles, sizeof(uint32_t))) && ok;
    return ok;
}

static bool any_masked(const sl_display *d) {
    const sl_primitives *p = d->primitives;
    bool masked = false;
    for (size_t s = 0; s < d->curved->count; s++)
        masked |= sl_scene_has_alpha(p->scene, p->first_triangle[d->curved->primitive[s]]);
    return masked;
}

/* The hardware tests alpha masks by a scene's materials and texture coordinates, and those of a surface are
 * its (u, v). */
static sl_status make_masked(const sl_display *d, sl_tessellation *t, unsigned threads, sl_error *error) {
    const sl_primitives *p = d->primitives;
    const sl_scene *s = p->scene;
    sl_scene *m = t->masked = sl_allocate(1, sizeof *m);
    if (!m || !(m->material_index = sl_allocate(t->triangle_count, sizeof *m->material_index)))
        return sl_fail_memory(error, "curved surfaces");
    m->vertex_count = t->vertex_count;
    m->position_x = t->x, m->position_y = t->y, m->position_z = t->z;
    m->texture_u = t->u, m->texture_v = t->v;
    m->triangle_count = t->triangle_count;
    for (int c = 0; c < 3; c++) m->vertex[c] = t->vertex[c];
    for (size_t i = 0; i < t->triangle_count; i++)
        m->material_index[i] = s->material_index[p->first_triangle[t->primitive[i]]];
    m->material_count = s->material_count, m->materials = s->materials;
    m->texture_count = s->texture_count, m->textures = s->textures;
    return sl_raster_create(m, threads, &t->raster, error);
}

static sl_status make(const sl_display *d, const sl_scene *scene, unsigned threads, sl_tessellation *t,
                      sl_error *error) {
    size_t surfaces = d->curved->count, vertices = 0, triangles = 0;
    if (!(t->rates = sl_allocate(surfaces, sizeof *t->rates)))
        return sl_fail_memory(error, "curved surfaces");
    find_rates(d, scene, t->rates);
    for (size_t s = 0; s < surfaces; s++) {
        vertices += (size_t)vertices_of(&t->rates[s]);
        triangles += (size_t)triangles_of(&t->rates[s]);
    }
    if (!allocate(t, vertices, triangles, surfaces)) return sl_fail_memory(error, "curved surfaces");
    put_vertices(d, scene, t);
    put_triangles(d, t);
    t->vertex_count = vertices;
    t->camera = scene->camera;
    if (any_masked(d)) return make_masked(d, t, threads, error);
    t->mesh = (sl_raster_mesh){
        vertices, t->triangle_count, t->x, t->y, t->z, {t->vertex[0], t->vertex[1], t->vertex[2]}};
    sl_status status = sl_raster_create_mesh(&t->mesh, threads, &t->raster, error);
    if (status == SL_OK) sl_raster_observe(t->raster, scene->observer);
    return status;
}

sl_status sl_tessellate(const sl_display *d, sl_window *w, sl_error *error) {
    sl_tessellation *t = &w->tessellation, fresh = {.raster = NULL};
    if (t->raster && memcmp(&t->camera, &w->scene->camera, sizeof t->camera) == 0 &&
        !has_moved(d, w->scene, t))
        return SL_OK;
    sl_status status = make(d, w->scene, w->threads, &fresh, error);
    if (status != SL_OK) {
        sl_tessellation_release(&fresh);
        return status;
    }
    sl_tessellation_release(t);
    *t = fresh;
    return SL_OK;
}

sl_status sl_tessellation_move(const sl_display *d, sl_window *w, sl_error *error) {
    sl_tessellation *t = &w->tessellation;
    if (!has_moved(d, w->scene, t)) return SL_OK;
    put_vertices(d, w->scene, t);
    return sl_raster_move(t->raster, w->threads, error);
}
