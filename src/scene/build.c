/* From a model to a scene: check, repair, weld. Everything that loads or makes a scene ends here, so that
 * nothing behind this file ever meets a triangle without area, a vertex that is not finite or a normal
 * without direction. Indices are checked where they are added. */
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "base/random.h"
#include "scene/derive.h"
#include "scene/model.h"

enum { FILM_DEFAULT = 512 };

static sl_vec3 vector_at(const float *xyz, size_t i) {
    return sl_v3(xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]);
}

/* ---- vertices: equal corners become one, in the order of their first use ------------------------ */

enum { CORNER_VALUES = 8, SLOTS_LEAST = 64 };

typedef struct corner {
    float value[CORNER_VALUES]; /* position, normal, texture coordinates */
    /* the object, or, where vertices are kept, the model's vertex; SL_NO_INDEX: a surface, whose vertices are
     * no others' */
    uint32_t owner;
} corner;

/* Those that are found are the scene's vertices, whose arrays grow. */
typedef struct corners {
    float **value[CORNER_VALUES];
    size_t *count, room;
    uint32_t *owner;
    uint32_t *slot; /* of a hash table, open addressing: a vertex, or SL_NO_INDEX; half are never used */
    size_t slots;
} corners;

static corners corners_of(sl_scene *s) {
    return (corners){{&s->position_x, &s->position_y, &s->position_z, &s->normal_x, &s->normal_y,
                      &s->normal_z, &s->texture_u, &s->texture_v},
                     .count = &s->vertex_count};
}

static corner corner_at(const corners *all, size_t vertex) {
    corner c = {.owner = all->owner[vertex]};
    for (int i = 0; i < CORNER_VALUES; i++) c.value[i] = (*all->value[i])[vertex];
    return c;
}

static bool is_corner(const corners *all, size_t vertex, const corner *c) {
    for (int i = 0; i < CORNER_VALUES; i++) {
        if ((*all->value[i])[vertex] != c->value[i]) return false;
    }
    return all->owner[vertex] == c->owner;
}

/* Finds the slot of a corner, or the free one that it is to have. */
static uint32_t *slot_of(const corners *all, const corner *c) {
    uint64_t hash = c->owner, word;
    for (int i = 0; i < CORNER_VALUES; i += 2) {
        memcpy(&word, (float[2]){c->value[i] + 0.0f, c->value[i + 1] + 0.0f}, sizeof word); /* no -0 */
        hash = sl_hash64(hash ^ word);
    }
    size_t at = (size_t)hash & (all->slots - 1);
    while (all->slot[at] != SL_NO_INDEX && !is_corner(all, all->slot[at], c))
        at = (at + 1) & (all->slots - 1);
    return &all->slot[at];
}

static bool add_slots(corners *all) {
    const size_t slots = all->slots ? 2 * all->slots : SLOTS_LEAST;
    sl_free(all->slot);
    all->slots = slots;
    if (!(all->slot = sl_allocate_unset(slots, sizeof *all->slot))) return false;
    memset(all->slot, 0xff, slots * sizeof *all->slot); /* SL_NO_INDEX */
    for (size_t v = 0; v < *all->count; v++) {
        const corner c = corner_at(all, v);
        if (c.owner != SL_NO_INDEX) *slot_of(all, &c) = (uint32_t)v;
    }
    return true;
}

static bool set_room(corners *all, size_t room) {
    bool made = sl_regrow(&all->owner, *all->count, room, sizeof *all->owner);
    for (int i = 0; i < CORNER_VALUES && made; i++)
        made = sl_regrow(all->value[i], *all->count, room, sizeof **all->value[i]);
    if (made) all->room = room;
    return made;
}

static bool add_corner(corners *all, const corner *c, uint32_t *number) {
    if (*all->count == all->room && !set_room(all, sl_grown_capacity(all->room, all->room + SLOTS_LEAST)))
        return false;
    *number = (uint32_t)(*all->count)++;
    for (int i = 0; i < CORNER_VALUES; i++) (*all->value[i])[*number] = c->value[i];
    all->owner[*number] = c->owner;
    return true;
}

static bool find_corner(corners *all, const corner *c, uint32_t *number) {
    if (all->slots < 2 * (*all->count + 1) && !add_slots(all)) return false;
    uint32_t *slot = slot_of(all, c);
    if (*slot == SL_NO_INDEX && !add_corner(all, c, slot)) return false;
    *number = *slot;
    return true;
}

/* A corner without a normal has its facet's, so that facets stay facets. */
static corner corner_of(const sl_model *m, uint32_t vertex, uint32_t object, sl_vec3 facet) {
    const sl_vec3 p = vector_at(m->positions, vertex),
                  n = sl_unit_or(vector_at(m->normals, vertex), facet);
    const float u = m->uvs[2 * (size_t)vertex], v = m->uvs[2 * (size_t)vertex + 1];
    return (corner){{p.x, p.y, p.z, n.x, n.y, n.z, isfinite(u) ? u : 0.0f, isfinite(v) ? v : 0.0f},
                    m->keeps_vertices && object != SL_NO_INDEX ? vertex : object};
}

/* ---- triangles ------------------------------------------------------------------------------- */

typedef struct dropped {
    size_t nonfinite, without_area;
} dropped;

/* Tells whether a triangle can be kept; its geometric normal if so. */
static bool keep_triangle(const sl_model *m, size_t triangle, sl_vec3 *normal, dropped *lost) {
    const uint32_t *index = m->indices + 3 * triangle;
    sl_vec3 p[3];
    sl_vec3d cross;
    for (int i = 0; i < 3; i++) p[i] = vector_at(m->positions, index[i]);
    const bool finite = sl_is_finite(p[0]) && sl_is_finite(p[1]) && sl_is_finite(p[2]),
               has_area = finite && sl_triangle_cross(p[0], p[1], p[2], &cross);
    lost->nonfinite += !finite;
    lost->without_area += finite && !has_area;
    if (has_area) *normal = sl_to_float(sl_scaled(cross, 1.0 / sl_lengthd(cross)));
    return has_area;
}

/* `surface`: the one whose triangle it is, or NULL. Its vertices are there already, row by row. */
static bool add_triangle(const sl_model *m, size_t from, const sl_bicubic *given, const sl_bicubic *surface,
                         sl_vec3 normal, corners *all, sl_scene *s) {
    const size_t to = s->triangle_count++;
    for (int c = 0; c < 3; c++) {
        const uint32_t vertex = m->indices[3 * from + (size_t)c];
        const corner at = corner_of(m, vertex, m->object_index[from], normal);
        if (surface) s->vertex[c][to] = surface->first_vertex + (vertex - given->first_vertex);
        else if (!find_corner(all, &at, &s->vertex[c][to])) return false;
    }
    s->material_index[to] = m->material_index[from];
    s->object_index[to] = m->object_index[from];
    return true;
}

/* All vertices of a surface are kept, in order: their numbers say where on it they lie. Of its triangles
 * those without area, which poles are made of, go without a word. */
static sl_status add_surface(const sl_model *m, const sl_bicubic *given, corners *all, sl_scene *s,
                             sl_error *error) {
    sl_bicubic *surface = &s->bicubics[s->bicubic_count++];
    *surface = *given;
    surface->first_vertex = (uint32_t)s->vertex_count;
    surface->first_triangle = (uint32_t)s->triangle_count;
    const uint32_t side = (uint32_t)given->steps + 1;
    dropped lost = {0};
    sl_vec3 normal = sl_v3(0, 0, 0);
    uint32_t number;
    for (uint32_t v = given->first_vertex; v < given->first_vertex + side * side; v++) {
        const corner at = corner_of(m, v, SL_NO_INDEX, normal);
        if (!add_corner(all, &at, &number)) return sl_fail_memory(error, "the scene's vertices");
    }
    for (size_t t = given->first_triangle; t < (size_t)given->first_triangle + given->triangle_count; t++) {
        if (keep_triangle(m, t, &normal, &lost)) add_triangle(m, t, given, surface, normal, all, s);
    }
    surface->triangle_count = (uint32_t)s->triangle_count - surface->first_triangle;
    if (surface->triangle_count && lost.nonfinite == 0) return SL_OK;
    return sl_fail(error, SL_ERROR_INPUT, "a bicubic surface has no area or is not finite");
}

static sl_status tell_of_dropped(sl_scene *s, size_t given, const dropped *lost, sl_error *error) {
    if (lost->nonfinite)
        sl_scene_warn(s, "%zu triangles with NaN or infinite vertices dropped", lost->nonfinite);
    if (lost->without_area) sl_scene_warn(s, "%zu triangles without area dropped", lost->without_area);
    if (s->triangle_count) return SL_OK;
    if (!given)
        return sl_fail(
            error, SL_ERROR_INPUT,
            "no triangles: expected faces of three corners or more (points and lines are not drawn)");
    return sl_fail(error, SL_ERROR_INPUT,
                   "no triangles: expected one with an area; of %zu, %zu have NaN or infinite vertices, and "
                   "%zu no area",
                   given, lost->nonfinite, lost->without_area);
}

static sl_status add_triangles(const sl_model *m, corners *all, sl_scene *s, sl_error *error) {
    dropped lost = {0};
    for (size_t t = 0; t < m->triangle_count; t++) {
        const sl_bicubic *surface =
            s->bicubic_count < m->bicubic_count ? &m->bicubics[s->bicubic_count] : NULL;
        sl_vec3 normal;
        sl_status status = SL_OK;
        if (surface && t == surface->first_triangle) {
            status = add_surface(m, surface, all, s, error);
            t += surface->triangle_count - 1;
        } else if (keep_triangle(m, t, &normal, &lost) &&
                   !add_triangle(m, t, NULL, NULL, normal, all, s)) {
            status = sl_fail_memory(error, "the scene's vertices");
        }
        if (status != SL_OK) return status;
    }
    return tell_of_dropped(s, m->triangle_count, &lost, error);
}

static sl_status allocate_triangles(const sl_model *m, sl_scene *s, sl_error *error) {
    uint32_t **arrays[] = {&s->vertex[0], &s->vertex[1], &s->vertex[2], &s->material_index, &s->object_index};
    bool there = (s->bicubics = sl_allocate(m->bicubic_count, sizeof *s->bicubics));
    for (size_t i = 0; i < 5; i++) there &= (*arrays[i] = sl_allocate_unset(m->triangle_count, 4)) != NULL;
    return there ? SL_OK : sl_fail_memory(error, "the scene's triangles");
}

/* What follows from the triangles; the model's are gone by then. */
static sl_status allocate_derived(sl_scene *s, sl_error *error) {
    float **normal[] = {&s->geometric_normal_x, &s->geometric_normal_y, &s->geometric_normal_z};
    bool there = (s->emitter_of_triangle = sl_allocate_unset(s->triangle_count, 4));
    for (size_t i = 0; i < 3; i++) there &= (*normal[i] = sl_allocate_unset(s->triangle_count, 4)) != NULL;
    return there ? SL_OK : sl_fail_memory(error, "the scene's triangles");
}

sl_status sl_model_add_geometry(sl_model *m, sl_scene *s, sl_error *error) {
    corners all = corners_of(s);
    sl_status status = allocate_triangles(m, s, error);
    if (status == SL_OK) status = add_triangles(m, &all, s, error);
    sl_free(all.slot);
    sl_model_drop_geometry(m);
    if (status == SL_OK && !set_room(&all, s->vertex_count))
        status = sl_fail_memory(error, "the scene's vertices");
    sl_free(all.owner);
    return status == SL_OK ? allocate_derived(s, error) : status;
}

/* ---- the whole ------------------------------------------------------------------------------- */

/* A triangle without a material is of a grey one, and one without an object of one without a name. */
static sl_status add_what_is_missing(sl_model *m, sl_error *error) {
    const sl_material grey = sl_grey_material("", 0.5f);
    uint32_t index;
    sl_status status = m->scene.material_count ? SL_OK : sl_model_add_material(m, &grey, &index, error);
    return status != SL_OK || m->scene.object_count ? status : sl_model_add_object(m, "", &index, error);
}

static sl_status check_sky(sl_scene *s, sl_error *error) {
    size_t repaired = 0;
    sl_status status = sl_environment_complete(&s->environment, &repaired, error);
    if (repaired)
        sl_scene_warn(s, "environment: %zu values that were negative or not finite are black", repaired);
    return status;
}

static sl_status light_if_dark(const sl_model *m, sl_scene *s, bool shut_out, sl_error *error) {
    const bool any = s->emitter_count || s->environment.present || sl_scene_has_lit_light(s);
    if (any && !shut_out) return SL_OK;
    if (!m->stays_dark) return sl_scene_light_by_default(s, error);
    if (!any) sl_scene_warn(s, "no light: the picture will be black");
    return SL_OK;
}

static sl_status complete(sl_model *m, sl_error *error) {
    sl_scene *s = &m->scene;
    bool shut_out = false;
    s->is_read = true;
    if (m->dark_lights) sl_scene_warn(s, "%zu lights have no intensity and are left out", m->dark_lights);
    if (!s->film_width) s->film_width = s->film_height = FILM_DEFAULT;
    sl_status status = add_what_is_missing(m, error);
    if (status == SL_OK) status = sl_materials_check(s, error);
    if (status == SL_OK) status = sl_lights_check(s, error);
    if (status == SL_OK) status = check_sky(s, error);
    if (status == SL_OK) status = sl_model_add_geometry(m, s, error);
    if (status == SL_OK) status = sl_scene_make_emitters(s, error);
    if (status == SL_OK)
        status = sl_scene_place_camera(s, m->has_camera ? &m->camera : NULL, m->view, &shut_out, error);
    if (status == SL_OK) status = light_if_dark(m, s, shut_out, error);
    if (status == SL_OK) sl_scene_measure_from(s, s->camera.eye);
    return status;
}

sl_status sl_model_build(sl_model *m, sl_scene **scene, sl_error *error) {
    *scene = NULL;
    sl_status status = complete(m, error);
    if (status != SL_OK) return status;
    if (!(*scene = sl_allocate(1, sizeof **scene))) return sl_fail_memory(error, "the scene");
    **scene = m->scene;
    m->scene = (sl_scene){0};
    return SL_OK;
}
