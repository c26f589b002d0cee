#include "scene/reshape.h"

#include <string.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "scene/animation.h"
#include "scene/derive.h"

enum { BY_VERTEX = 8, BY_TRIANGLE = 9, SURFACE_ARRAYS = BY_VERTEX + BY_TRIANGLE };

void sl_reshaping_release(sl_reshaping *r) {
    for (size_t i = 0; i < r->mouldings; i++) {
        sl_free(r->moulding[i].positions);
        sl_free(r->moulding[i].normals);
    }
    sl_free(r->moulding);
    sl_free(r->gone);
    sl_model_clear(&r->more);
}

/* ---- vertices of an object ------------------------------------------------------------------- */

/* Steps through an object's vertices: those of triangles are numbered in the order in which triangles use
 * them first. */
typedef struct walk {
    const sl_scene *scene;
    uint32_t object, next;
    size_t corner;
} walk;

static bool step(walk *w, uint32_t *vertex) {
    const sl_scene *s = w->scene;
    while (w->corner < 3 * s->triangle_count) {
        const size_t corner = w->corner++;
        *vertex = s->vertex[corner % 3][corner / 3];
        if (*vertex < w->next) continue;
        w->next = *vertex + 1;
        if (s->object_index[corner / 3] == w->object) return true;
    }
    return false;
}

static void write_vector(float *to, sl_vec3 v) { memcpy(to, (float[3]){v.x, v.y, v.z}, 3 * sizeof *to); }

size_t sl_scene_vertices(const sl_scene *scene, uint32_t object, float *positions, float *normals) {
    const sl_animation *a = scene->animation;
    walk w = {.scene = scene, .object = object - 1};
    size_t count = 0;
    for (uint32_t v; step(&w, &v); count++) {
        if (positions)
            write_vector(positions + 3 * count, a ? a->rest_position[v] : sl_scene_position(scene, v));
        if (normals) write_vector(normals + 3 * count, a ? a->rest_normal[v] : sl_scene_normal(scene, v));
    }
    return count;
}

/* ---- what stays, and where it is numbered then ----------------------------------------------- */

typedef struct numbering {
    uint32_t *number; /* SL_NO_INDEX: it goes */
    size_t count, kept;
} numbering;

static bool make_numbering(numbering *n, size_t count) {
    *n = (numbering){sl_allocate(count, sizeof *n->number), count, 0};
    return n->number;
}

static void number_kept(numbering *n) {
    for (size_t i = 0; i < n->count; i++)
        if (n->number[i] != SL_NO_INDEX) n->number[i] = (uint32_t)n->kept++;
}

static void number_all(const sl_scene *s, const uint8_t *gone, numbering *vertices, numbering *triangles) {
    for (size_t t = 0; t < s->triangle_count && gone; t++) {
        if (!gone[s->object_index[t]]) continue;
        triangles->number[t] = SL_NO_INDEX;
        for (int c = 0; c < 3; c++) vertices->number[s->vertex[c][t]] = SL_NO_INDEX;
    }
    number_kept(vertices);
    number_kept(triangles);
}

/* Returns what stays of an array, and more behind it; NULL: memory ended. */
static void *renewed(const void *array, const numbering *n, const void *more, size_t more_count,
                     size_t size) {
    char *to = sl_allocate(n->kept + more_count, size);
    for (size_t i = 0; i < n->count && to; i++)
        if (n->number[i] != SL_NO_INDEX)
            memcpy(to + size * n->number[i], (const char *)array + size * i, size);
    if (to && more && more_count) memcpy(to + size * n->kept, more, size * more_count);
    return to;
}

/* ---- surfaces -------------------------------------------------------------------------------- */

static sl_surfaces surfaces_of(const sl_scene *s) {
    const sl_animation *a = s->animation;
    return (sl_surfaces){*s, a ? a->track_of_vertex : NULL, a ? a->rest_position : NULL,
                         a ? a->rest_normal : NULL};
}

static sl_surfaces without_surfaces(const sl_scene *s) {
    sl_surfaces none = {.scene = *s};
    sl_scene_array list[SL_SCENE_ARRAYS];
    sl_scene_arrays(&none.scene, list);
    for (int k = 0; k < SURFACE_ARRAYS; k++) sl_scene_array_put(&list[k], NULL);
    none.scene.bicubics = NULL;
    none.scene.object_names = NULL;
    return none;
}

static void put(sl_scene *s, const sl_surfaces *surfaces) {
    *s = surfaces->scene;
    if (!s->animation) return;
    s->animation->track_of_vertex = surfaces->track_of_vertex;
    s->animation->rest_position = surfaces->rest_position;
    s->animation->rest_normal = surfaces->rest_normal;
}

static void release(sl_surfaces *surfaces) {
    sl_scene_array list[SL_SCENE_ARRAYS];
    sl_scene_arrays(&surfaces->scene, list);
    for (int k = 0; k < SURFACE_ARRAYS; k++) sl_free(sl_scene_array_at(&list[k]));
    SL_FREE_ALL(surfaces->scene.bicubics, surfaces->scene.object_names, surfaces->track_of_vertex,
                surfaces->rest_position, surfaces->rest_normal);
}

static bool renew_arrays(sl_scene *s, const sl_scene *old, sl_scene *more, const numbering *vertices,
                         const numbering *triangles) {
    sl_scene_array to[SL_SCENE_ARRAYS], from[SL_SCENE_ARRAYS], extra[SL_SCENE_ARRAYS];
    sl_scene copy = *old;
    bool there = true;
    sl_scene_arrays(s, to);
    sl_scene_arrays(&copy, from);
    sl_scene_arrays(more, extra);
    for (int k = 0; k < SURFACE_ARRAYS; k++) {
        const bool by_vertex = k < BY_VERTEX;
        void *array =
            renewed(sl_scene_array_at(&from[k]), by_vertex ? vertices : triangles, sl_scene_array_at(&extra[k]),
                    by_vertex ? more->vertex_count : more->triangle_count, sizeof(float));
        sl_scene_array_put(&to[k], array);
        there &= array != NULL;
    }
    s->vertex_count = vertices->kept + more->vertex_count;
    s->triangle_count = triangles->kept + more->triangle_count;
    return there;
}

/* Triangles name their vertices, and surfaces their first ones, by the new numbers. */
static void name_vertices(sl_scene *s, const numbering *vertices, const numbering *triangles) {
    for (size_t k = 0; k < 3 * s->triangle_count; k++) {
        uint32_t *v = &s->vertex[k % 3][k / 3];
        *v = k / 3 < triangles->kept ? vertices->number[*v] : *v + (uint32_t)vertices->kept;
    }
    for (size_t i = 0; i < s->bicubic_count; i++) {
        s->bicubics[i].first_vertex = vertices->number[s->bicubics[i].first_vertex];
        s->bicubics[i].first_triangle = triangles->number[s->bicubics[i].first_triangle];
    }
}

static bool renew_animation(sl_surfaces *to, const sl_surfaces *from, const numbering *vertices) {
    const sl_scene *s = &to->scene;
    const size_t more = s->vertex_count - vertices->kept;
    if (!s->animation) return true;
    to->track_of_vertex = renewed(from->track_of_vertex, vertices, NULL, more, sizeof(uint32_t));
    to->rest_position = renewed(from->rest_position, vertices, NULL, more, sizeof(sl_vec3));
    to->rest_normal = renewed(from->rest_normal, vertices, NULL, more, sizeof(sl_vec3));
    if (!to->track_of_vertex || !to->rest_position || !to->rest_normal) return false;
    for (size_t v = vertices->kept; v < s->vertex_count; v++) {
        to->track_of_vertex[v] = SL_NO_INDEX;
        to->rest_position[v] = sl_scene_position(s, (uint32_t)v);
        to->rest_normal[v] = sl_scene_normal(s, (uint32_t)v);
    }
    return true;
}

static bool renew_lists(sl_scene *s, const sl_scene *old, const sl_scene *more) {
    s->object_count = old->object_count + more->object_count;
    s->bicubics = sl_copy_of(old->bicubics, old->bicubic_count, sizeof *s->bicubics);
    s->object_names = sl_allocate(s->object_count, sizeof *s->object_names);
    if (!s->bicubics || !s->object_names) return false;
    for (size_t i = 0; i < s->object_count; i++)
        s->object_names[i] =
            i < old->object_count ? old->object_names[i] : more->object_names[i - old->object_count];
    return true;
}

/* ---- vertices that are elsewhere ------------------------------------------------------------- */

static void add_normals(const sl_scene *s, uint32_t object, sl_vec3d *sum) {
    for (size_t t = 0; t < s->triangle_count; t++) {
        sl_vec3d cross;
        if (s->object_index[t] != object ||
            !sl_triangle_cross(sl_scene_position(s, s->vertex[0][t]), sl_scene_position(s, s->vertex[1][t]),
                               sl_scene_position(s, s->vertex[2][t]), &cross))
            continue;
        for (int c = 0; c < 3; c++) sum[s->vertex[c][t]] = sl_addd(sum[s->vertex[c][t]], cross);
    }
}

static void mould(sl_surfaces *to, const sl_moulding *m, sl_vec3d *sum) {
    sl_scene *s = &to->scene;
    walk places = {.scene = s, .object = m->object}, normals = places;
    uint32_t v;
    for (size_t i = 0; step(&places, &v); i++)
        sl_put(s->position_x, s->position_y, s->position_z, v, sl_v3_of(m->positions + 3 * i));
    if (!m->normals) add_normals(s, m->object, sum);
    for (size_t i = 0; step(&normals, &v); i++) {
        const double length = sl_lengthd(sum[v]);
        const float *given = m->normals ? m->normals + 3 * i : (const float[3]){0};
        const sl_vec3 facet = length > 0.0 ? sl_to_float(sl_scaled(sum[v], 1.0 / length))
                                           : sl_scene_normal(s, v),
                      unit = sl_unit_or(sl_v3_of(given), facet);
        sl_put(s->normal_x, s->normal_y, s->normal_z, v, unit);
        if (to->rest_position) to->rest_position[v] = sl_scene_position(s, v);
        if (to->rest_normal) to->rest_normal[v] = unit;
    }
}

static bool mould_all(sl_surfaces *to, const sl_reshaping *r) {
    sl_vec3d *sum = r->mouldings ? sl_allocate(to->scene.vertex_count, sizeof *sum) : NULL;
    for (size_t i = 0; i < r->mouldings && sum; i++) mould(to, &r->moulding[i], sum);
    sl_free(sum);
    return sum || !r->mouldings;
}

/* ---- the whole ------------------------------------------------------------------------------- */

static bool renew(sl_surfaces *to, const sl_surfaces *from, sl_reshaping *r, numbering *vertices,
                  numbering *triangles) {
    sl_scene *more = &r->more.scene;
    if (!make_numbering(vertices, from->scene.vertex_count) ||
        !make_numbering(triangles, from->scene.triangle_count))
        return false;
    number_all(&from->scene, r->gone, vertices, triangles);
    if (!renew_lists(&to->scene, &from->scene, more) ||
        !renew_arrays(&to->scene, &from->scene, more, vertices, triangles))
        return false;
    name_vertices(&to->scene, vertices, triangles);
    return renew_animation(to, from, vertices) && mould_all(to, r);
}

sl_status sl_reshape(sl_scene *scene, sl_reshaping *r, sl_surfaces *before, sl_error *error) {
    numbering vertices = {0}, triangles = {0};
    sl_status status = SL_OK;
    *before = surfaces_of(scene);
    sl_surfaces after = without_surfaces(scene);
    if (r->more.scene.object_count)
        status = sl_model_add_geometry(&r->more, &r->more.scene, error);
    if (status != SL_OK) return status;
    if (!renew(&after, before, r, &vertices, &triangles))
        status = sl_fail_memory(error, "the scene's other surfaces");
    else if (after.scene.triangle_count == 0)
        status = sl_fail(error, SL_ERROR_INPUT, "expected an object to be left in the scene");
    sl_free(vertices.number);
    sl_free(triangles.number);
    if (status == SL_OK) put(scene, &after);
    else release(&after);
    return status;
}

void sl_reshape_undo(sl_scene *scene, sl_surfaces *before) {
    sl_surfaces now = surfaces_of(scene);
    put(scene, before);
    release(&now);
}

void sl_reshape_settle(sl_reshaping *r, sl_surfaces *before) {
    for (size_t i = 0; i < before->scene.object_count && r->gone; i++)
        if (r->gone[i]) *before->scene.object_names[i] = '\0'; /* its name is free */
    r->more.scene.object_count = 0;                           /* whose names are the scene's by now */
    release(before);
}
