/* The mirrored view (mirror.h) and the scene's planar mirrors. */
#include "raster/views/mirror.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"

/* ---- planes ---- */

bool sl_plane_through(sl_vec3 a, sl_vec3 b, sl_vec3 c, sl_plane *plane) {
    sl_vec3d p = sl_to_double(a);
    sl_vec3d n = sl_crossd(sl_subd(sl_to_double(b), p), sl_subd(sl_to_double(c), p));
    double length = sl_lengthd(n);
    if (!(length > 0.0) || !isfinite(length)) return false;
    plane->normal = sl_scaled(n, 1.0 / length);
    plane->distance = sl_dotd(plane->normal, p);
    return true;
}

sl_vec3d sl_plane_reflect(const sl_plane *plane, sl_vec3d p) {
    return sl_subd(p, sl_scaled(plane->normal, 2.0 * (sl_dotd(plane->normal, p) - plane->distance)));
}

/* ---- view ---- */

/* With e' the eye's image and R the reflection's linear part, reflect(p) - e = R (p - e'), so row . R is the
 * mirrored row. The view's origin is e' in float; the constant makes good for the rounding. */
static void mirror_row(const float row[4], const sl_plane *mirror, sl_vec3d rounding, float out[4]) {
    sl_vec3d a = sl_v3d((double)row[0], (double)row[1], (double)row[2]);
    sl_vec3d r = sl_subd(a, sl_scaled(mirror->normal, 2.0 * sl_dotd(a, mirror->normal)));
    out[0] = (float)r.x;
    out[1] = (float)r.y;
    out[2] = (float)r.z;
    out[3] = (float)((double)row[3] + sl_dotd(r, rounding));
}

bool sl_view_mirrored(const sl_view *view, const sl_plane *mirror, double offset, sl_view *mirrored) {
    sl_vec3d eye = sl_to_double(view->origin), image = sl_plane_reflect(mirror, eye);
    double height = sl_dotd(mirror->normal, eye) - mirror->distance, length = sl_lengthd(mirror->normal);
    if (!(fabs(length - 1.0) < 1e-6) || !(fabs(height) > offset) || !isfinite(height)) return false;
    sl_vec3d n = sl_scaled(mirror->normal, height > 0.0 ? 1.0 : -1.0); /* towards the eye */
    *mirrored = *view;
    mirrored->kind = SL_VIEW_MIRRORED;
    mirrored->depth = SL_DEPTH_INVERSE_W;
    mirrored->left_out = NULL;
    mirrored->origin = sl_to_float(image);
    sl_vec3d rounding = sl_subd(sl_to_double(mirrored->origin), image);
    for (int k = 0; k < 4; k++) mirror_row(view->clip[k], mirror, rounding, mirrored->clip[k]);
    /* Row 2: the height above the mirror, p . n - d, less the offset. Seen from e' the plane is |height|
     * away. */
    float *near = mirrored->clip[2];
    near[0] = (float)n.x;
    near[1] = (float)n.y;
    near[2] = (float)n.z;
    near[3] = (float)(sl_dotd(n, rounding) - fabs(height) - offset);
    return true;
}

/* ---- finding ---- */

typedef struct {
    double area;
    uint32_t triangle;
} sized_triangle;

static int larger_first(const void *a, const void *b) {
    const sized_triangle *x = a, *y = b;
    if (x->area != y->area) return x->area > y->area ? -1 : 1;
    return x->triangle < y->triangle ? -1 : x->triangle > y->triangle;
}

static size_t count_mirror_triangles(const sl_scene *s) {
    size_t count = 0, mirrors = 0;
    for (size_t m = 0; m < s->material_count; m++) mirrors += sl_material_is_mirror(&s->materials[m]);
    if (mirrors == 0) return 0;
    for (size_t t = 0; t < s->triangle_count; t++)
        count += sl_material_is_mirror(&s->materials[s->material_index[t]]);
    return count;
}

/* Shading normals within a degree of the plane's. */
static bool is_flat(const sl_scene *s, uint32_t t, const sl_plane *plane) {
    for (int k = 0; k < 3; k++) {
        double cosine = sl_dotd(sl_to_double(sl_scene_normal(s, s->vertex[k][t])), plane->normal);
        if (!(fabs(cosine) > 0.99985)) return false;
    }
    return true;
}

static bool plane_of(const sl_scene *s, uint32_t t, sl_plane *plane) {
    sl_vec3 p[3];
    for (int k = 0; k < 3; k++) p[k] = sl_scene_position(s, s->vertex[k][t]);
    return sl_plane_through(p[0], p[1], p[2], plane);
}

static bool lies_in(const sl_scene *s, uint32_t t, const sl_plane *plane) {
    double tolerance = 2e-6 * (double)s->scale;
    for (int k = 0; k < 3; k++) {
        sl_vec3d p = sl_to_double(sl_scene_position(s, s->vertex[k][t]));
        if (!(fabs(sl_dotd(plane->normal, p) - plane->distance) <= tolerance)) return false;
    }
    return true;
}

static size_t list_flat_mirrors(const sl_scene *s, sized_triangle *list) {
    size_t count = 0;
    for (uint32_t t = 0; t < s->triangle_count; t++) {
        sl_plane plane;
        if (!sl_material_is_mirror(&s->materials[s->material_index[t]])) continue;
        if (!plane_of(s, t, &plane) || !is_flat(s, t, &plane)) continue;
        sl_vec3d a = sl_to_double(sl_scene_position(s, s->vertex[0][t]));
        sl_vec3d b = sl_subd(sl_to_double(sl_scene_position(s, s->vertex[1][t])), a);
        sl_vec3d c = sl_subd(sl_to_double(sl_scene_position(s, s->vertex[2][t])), a);
        list[count++] = (sized_triangle){0.5 * sl_lengthd(sl_crossd(b, c)), t};
    }
    return count;
}

static void enclose(const sl_scene *s, uint32_t t, sl_vec3 *low, sl_vec3 *high) {
    for (int k = 0; k < 3; k++) {
        sl_vec3 p = sl_scene_position(s, s->vertex[k][t]);
        *low = sl_v3(fminf(low->x, p.x), fminf(low->y, p.y), fminf(low->z, p.z));
        *high = sl_v3(fmaxf(high->x, p.x), fmaxf(high->y, p.y), fmaxf(high->z, p.z));
    }
}

/* Large triangles first: they tell their plane best. */
static void assign(const sl_scene *s, size_t limit, size_t mirror_triangles, sized_triangle *list,
                   sl_mirrors *m) {
    size_t count = mirror_triangles ? list_flat_mirrors(s, list) : 0;
    qsort(list, count, sizeof *list, larger_first);
    memset(m->of_triangle, 0xff, s->triangle_count * sizeof *m->of_triangle); /* SL_NO_INDEX */
    for (size_t i = 0; i < count; i++) {
        uint32_t t = list[i].triangle;
        size_t k = 0;
        while (k < m->count && !(m->material[k] == s->material_index[t] && lies_in(s, t, &m->plane[k]))) k++;
        if (k == limit) continue;
        if (k == m->count) {
            plane_of(s, t, &m->plane[k]);
            m->material[k] = s->material_index[t];
            m->low[k] = m->high[k] = sl_scene_position(s, s->vertex[0][t]);
            m->count++;
        }
        m->of_triangle[t] = (uint32_t)k;
        enclose(s, t, &m->low[k], &m->high[k]);
    }
}

sl_status sl_mirrors_find(const sl_scene *scene, size_t limit, sl_mirrors **mirrors, sl_error *error) {
    *mirrors = NULL;
    sl_mirrors *m = sl_allocate(1, sizeof *m);
    const size_t mirror_triangles = count_mirror_triangles(scene);
    sized_triangle *list = sl_allocate(mirror_triangles, sizeof *list);
    if (m) {
        m->plane = sl_allocate(limit, sizeof *m->plane);
        m->material = sl_allocate(limit, sizeof *m->material);
        m->low = sl_allocate(limit, sizeof *m->low);
        m->high = sl_allocate(limit, sizeof *m->high);
        m->of_triangle = sl_allocate_unset(scene->triangle_count, sizeof *m->of_triangle);
        m->offset = 4e-6 * (double)scene->scale;
    }
    bool ok = m && list && m->plane && m->material && m->low && m->high && m->of_triangle;
    if (ok) assign(scene, limit, mirror_triangles, list, m);
    sl_free(list);
    if (!ok) sl_mirrors_destroy(m);
    else *mirrors = m;
    return ok ? SL_OK : sl_fail_memory(error, "the scene's mirrors");
}

void sl_mirrors_destroy(sl_mirrors *m) {
    if (!m) return;
    sl_free(m->plane);
    sl_free(m->material);
    sl_free(m->low);
    sl_free(m->high);
    sl_free(m->of_triangle);
    sl_free(m);
}
