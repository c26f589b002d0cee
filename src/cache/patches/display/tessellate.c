/* Curved surfaces as triangles for a view (section on curved surfaces): grids so fine that no chord is
 * further than half a pixel from its surface. All surfaces are cut alike, as finely as the one that needs it
 * most, and points of an edge are those of its own curve, rounded once: so nothing tears where surfaces meet.
 */
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/patches/display/display.h"
#include "scene/bicubic.h"

/* Pieces along a side. */
enum { RATE_MIN = 2, RATE_MAX = 64 };

static const sl_bicubic *surface_of(const sl_display *d, const sl_scene *scene, size_t surface) {
    return &scene->bicubics[d->primitives->bicubic[d->curved[surface]]];
}

/* ---- rates ----------------------------------------------------------------------------------- */

static sl_vec3d control(const sl_bicubic *b, int j, int i) { return sl_to_double(b->point[j][i]); }

static double second_difference(sl_vec3d a, sl_vec3d b, sl_vec3d c) {
    return sl_lengthd(sl_subd(sl_addd(a, c), sl_scaled(b, 2.0)));
}

/* Returns a bound of the second derivatives of a Bezier surface, from differences of control points: 6
 * |second differences|, 9 |mixed ones|. */
static double curvature_of(const sl_bicubic *b) {
    double most = 0.0;
    for (int j = 0; j < 4; j++) {
        for (int i = 0; i < 2; i++) {
            double uu = second_difference(control(b, j, i), control(b, j, i + 1), control(b, j, i + 2)),
                   vv = second_difference(control(b, i, j), control(b, i + 1, j), control(b, i + 2, j));
            most = fmax(most, 6.0 * fmax(uu, vv));
        }
    }
    for (int k = 0; k < 9; k++) {
        int j = k / 3, i = k % 3;
        sl_vec3d low = sl_subd(control(b, j, i + 1), control(b, j, i)),
                 high = sl_subd(control(b, j + 1, i + 1), control(b, j + 1, i));
        most = fmax(most, 9.0 * sl_lengthd(sl_subd(high, low)));
    }
    return most;
}

/* Pixels that a unit of length can cover where control points are nearest to the eye; infinite if they reach
 * behind it. *outside: all of them lie beyond one side of the picture. */
static double pixels_per_unit(const sl_bicubic *b, const sl_view *view, const sl_camera *camera,
                              bool *outside) {
    double nearest = INFINITY;
    int beyond[5] = {0, 0, 0, 0, 0};
    for (int k = 0; k < 16; k++) {
        sl_clip_point p = sl_clip_point_of(view, b->point[k / 4][k % 4]);
        float x = p.at[0], y = p.at[1], w = p.at[3];
        const bool out[5] = {x > w, x < -w, y > w, y < -w, w <= 0.0f};
        for (int i = 0; i < 5; i++) beyond[i] += out[i];
        nearest = fmin(nearest, (double)w);
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

/* A triangle with legs of 1/n is off by at most (|B_uu| + 2 |B_uv| + |B_vv|) / (8 n^2): half a pixel if no
 * term is above n^2. */
static int find_rate(const sl_display *d, const sl_scene *scene) {
    sl_view view = sl_view_scene(scene, d->settings.width, d->settings.height);
    double pixels = 0.0;
    for (size_t s = 0; s < d->curved_count; s++) {
        bool outside;
        double scale = pixels_per_unit(surface_of(d, scene, s), &view, &scene->camera, &outside);
        double most = curvature_of(surface_of(d, scene, s));
        if (!outside && most > 0.0) pixels = fmax(pixels, most * scale);
    }
    double pieces = ceil(sqrt(pixels));
    return pieces >= RATE_MIN ? (int)fmin(pieces, RATE_MAX) : RATE_MIN;
}

/* ---- vertices -------------------------------------------------------------------------------- */

static void put_vertices(const sl_display *d, const sl_scene *scene, sl_tessellation *t) {
    sl_scene *m = t->scene;
    size_t at = 0, row = (size_t)t->rate + 1;
    for (size_t s = 0; s < d->curved_count; s++) {
        const sl_bicubic *b = surface_of(d, scene, s);
        for (size_t k = 0; k < row * row; k++, at++) {
            double u = (double)(k % row) / t->rate, v = (double)(k / row) / t->rate;
            sl_vec3 p;
            sl_bicubic_at(b, u, v, &p, NULL);
            sl_put(m->position_x, m->position_y, m->position_z, at, p);
            m->texture_u[at] = (float)u;
            m->texture_v[at] = (float)v;
        }
        memcpy(t->point + 16 * s, b->point, sizeof b->point);
    }
}

/* ---- triangles ------------------------------------------------------------------------------- */

static bool same_place(const sl_scene *m, uint32_t a, uint32_t b) {
    sl_vec3 p = sl_scene_position(m, a), q = sl_scene_position(m, b);
    return p.x == q.x && p.y == q.y && p.z == q.z;
}

/* Where an edge is one point, triangles that have two corners there are none. */
static void put_triangle(sl_tessellation *t, uint32_t primitive, uint32_t material, size_t a, size_t b,
                         size_t c) {
    sl_scene *m = t->scene;
    const uint32_t corner[3] = {(uint32_t)a, (uint32_t)b, (uint32_t)c};
    if (same_place(m, corner[0], corner[1]) || same_place(m, corner[1], corner[2]) ||
        same_place(m, corner[2], corner[0]))
        return;
    for (int k = 0; k < 3; k++) m->vertex[k][m->triangle_count] = corner[k];
    m->material_index[m->triangle_count] = material;
    t->primitive[m->triangle_count++] = primitive;
}

static void put_triangles(const sl_display *d, const sl_scene *scene, sl_tessellation *t) {
    size_t row = (size_t)t->rate + 1;
    for (size_t s = 0; s < d->curved_count; s++) {
        uint32_t material = scene->material_index[d->primitives->first_triangle[d->curved[s]]];
        for (size_t k = 0; k < (row - 1) * (row - 1); k++) {
            size_t at = s * row * row + k / (row - 1) * row + k % (row - 1);
            put_triangle(t, d->curved[s], material, at, at + 1, at + row + 1);
            put_triangle(t, d->curved[s], material, at, at + row + 1, at + row);
        }
    }
}

/* ---- the whole ------------------------------------------------------------------------------- */

void sl_tessellation_release(sl_tessellation *t) {
    sl_scene *m = t->scene;
    if (m)
        SL_FREE_ALL(m->position_x, m->position_y, m->position_z, m->texture_u, m->texture_v, m->vertex[0],
                    m->vertex[1], m->vertex[2], m->material_index);
    SL_FREE_ALL(m, t->primitive, t->point);
    sl_raster_destroy(t->raster);
    memset(t, 0, sizeof *t);
}

static bool has_moved(const sl_display *d, const sl_scene *scene, const sl_tessellation *t) {
    for (size_t s = 0; s < d->curved_count; s++) {
        const sl_bicubic *b = surface_of(d, scene, s);
        if (memcmp(t->point + 16 * s, b->point, sizeof b->point) != 0) return true;
    }
    return false;
}

static bool allocate(sl_tessellation *t, size_t vertices, size_t triangles, size_t surfaces) {
    sl_scene *m = t->scene = sl_allocate(1, sizeof *m);
    if (!m) return false;
    float **by_vertex[5] = {&m->position_x, &m->position_y, &m->position_z, &m->texture_u, &m->texture_v};
    uint32_t **by_triangle[5] = {&m->vertex[0], &m->vertex[1], &m->vertex[2], &m->material_index,
                                 &t->primitive};
    bool ok = (t->point = sl_allocate(16 * surfaces, sizeof *t->point)) != NULL;
    for (int k = 0; k < 5; k++) {
        ok = (*by_vertex[k] = sl_allocate(vertices, sizeof(float))) && ok;
        ok = (*by_triangle[k] = sl_allocate(triangles, sizeof(uint32_t))) && ok;
    }
    return ok;
}

static sl_status make(const sl_display *d, const sl_window *w, sl_tessellation *t, sl_error *error) {
    const sl_scene *scene = w->scene;
    t->rate = find_rate(d, scene);
    size_t rate = (size_t)t->rate, vertices = d->curved_count * (rate + 1) * (rate + 1);
    if (!allocate(t, vertices, 2 * d->curved_count * rate * rate, d->curved_count))
        return sl_fail_memory(error, "curved surfaces");
    sl_scene *m = t->scene;
    m->vertex_count = vertices;
    m->material_count = scene->material_count, m->materials = scene->materials;
    m->texture_count = scene->texture_count, m->textures = scene->textures;
    m->observer = scene->observer;
    put_vertices(d, scene, t);
    put_triangles(d, scene, t);
    t->camera = scene->camera;
    return sl_raster_create(m, w->threads, &t->raster, error);
}

sl_status sl_tessellate(sl_window *w, sl_error *error) {
    const sl_display *d = w->display;
    sl_tessellation *t = &w->tessellation, fresh = {.raster = NULL};
    if (t->raster && memcmp(&t->camera, &w->scene->camera, sizeof t->camera) == 0 &&
        !has_moved(d, w->scene, t))
        return SL_OK;
    sl_status status = make(d, w, &fresh, error);
    if (status != SL_OK) {
        sl_tessellation_release(&fresh);
        return status;
    }
    sl_tessellation_release(t);
    *t = fresh;
    return SL_OK;
}

sl_status sl_tessellation_move(sl_window *w, sl_error *error) {
    sl_tessellation *t = &w->tessellation;
    if (!has_moved(w->display, w->scene, t)) return SL_OK;
    put_vertices(w->display, w->scene, t);
    return sl_raster_move(t->raster, w->threads, error);
}
