/* Building a scene from plain arrays: check, repair, copy. Everything that loads or makes a scene ends here,
 * so that nothing behind this file ever meets a triangle without area, a vertex that is not finite or a
 * normal without direction. */
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "scene/bicubic.h"
#include "scene/derive.h"

enum { FILM_DEFAULT = 512 };

/* ---- surfaces, lights, sky ------------------------------------------------------------------- */

static sl_status copy_materials(const sl_scene_parts *parts, sl_scene *scene, sl_error *error) {
    static const sl_material grey = {
        .diffuse = {0.5f, 0.5f, 0.5f}, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX};
    size_t count = parts->material_count ? parts->material_count : 1;
    scene->materials = sl_allocate(count, sizeof *scene->materials);
    if (!scene->materials) return sl_fail_memory(error, "the scene's materials");
    scene->material_count = count;
    for (size_t i = 0; i < count; i++) {
        scene->materials[i] = parts->material_count ? parts->materials[i] : grey;
        scene->materials[i].name = sl_string_copy(scene->materials[i].name);
        if (!scene->materials[i].name) {
            scene->material_count = i;
            return sl_fail_memory(error, "the scene's materials");
        }
    }
    return sl_materials_check(scene, error);
}

static sl_status copy_textures(const sl_scene_parts *parts, sl_scene *scene, sl_error *error) {
    scene->textures = sl_allocate(parts->texture_count, sizeof *scene->textures);
    if (!scene->textures) return sl_fail_memory(error, "the scene's textures");
    for (size_t i = 0; i < parts->texture_count; i++) {
        const sl_texture *from = &parts->textures[i];
        sl_texture *to = &scene->textures[i];
        if (from->width <= 0 || from->height <= 0 || !from->texels) {
            return sl_fail(error, SL_ERROR_INPUT, "texture '%s' is empty", from->file ? from->file : "");
        }
        size_t texels = (size_t)from->width * (size_t)from->height;
        *to = (sl_texture){sl_string_copy(from->file), from->width, from->height, from->has_alpha,
                           sl_allocate(texels, 4)};
        scene->texture_count = i + 1;
        if (!to->file || !to->texels) return sl_fail_memory(error, "the scene's textures");
        memcpy(to->texels, from->texels, 4 * texels);
    }
    return SL_OK;
}

static sl_status copy_lights(const sl_scene_parts *parts, sl_scene *scene, sl_error *error) {
    scene->lights = sl_allocate(parts->light_count, sizeof *scene->lights);
    if (!scene->lights) return sl_fail_memory(error, "the scene's lights");
    scene->light_count = parts->light_count;
    if (parts->light_count) memcpy(scene->lights, parts->lights, parts->light_count * sizeof *scene->lights);
    sl_status status = sl_lights_check(scene, error);
    if (status != SL_OK || !parts->environment) return status;
    size_t repaired = 0;
    status = sl_environment_copy(parts->environment, &scene->environment, &repaired, error);
    if (repaired)
        sl_scene_warn(scene, "environment: %zu values that were negative or not finite are black", repaired);
    return status;
}

/* ---- triangles ------------------------------------------------------------------------------- */

static sl_vec3 vector_at(const float *xyz, size_t i) {
    return sl_v3(xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]);
}

typedef struct dropped {
    size_t out_of_range, nonfinite, without_area;
} dropped;

/* Tells whether a triangle can be kept; its geometric normal if so. */
static bool keep_triangle(const sl_scene_parts *parts, size_t triangle, sl_vec3 *normal, dropped *lost) {
    const uint32_t *corner = parts->indices + 3 * triangle;
    sl_vec3 p[3];
    for (int i = 0; i < 3; i++) {
        if (corner[i] >= parts->vertex_count) {
            lost->out_of_range++;
            return false;
        }
        p[i] = vector_at(parts->positions, corner[i]);
    }
    if (!sl_is_finite(p[0]) || !sl_is_finite(p[1]) || !sl_is_finite(p[2])) {
        lost->nonfinite++;
        return false;
    }
    sl_vec3d cross;
    if (!sl_triangle_cross(p[0], p[1], p[2], &cross)) {
        lost->without_area++;
        return false;
    }
    *normal = sl_to_float(sl_scaled(cross, 1.0 / sl_lengthd(cross)));
    return true;
}

static void add_triangle(const sl_scene_parts *parts, sl_scene *s, size_t from, sl_vec3 normal) {
    size_t to = s->triangle_count++;
    for (int c = 0; c < 3; c++) s->vertex[c][to] = parts->indices[3 * from + (size_t)c];
    s->material_index[to] = parts->material_index ? parts->material_index[from] : 0;
    s->object_index[to] = parts->object_index ? parts->object_index[from] : 0;
    s->geometric_normal_x[to] = normal.x;
    s->geometric_normal_y[to] = normal.y;
    s->geometric_normal_z[to] = normal.z;
}

static void warn_of_dropped(sl_scene *scene, const dropped *lost) {
    if (lost->out_of_range)
        sl_scene_warn(scene, "%zu triangles with vertex indices out of range dropped", lost->out_of_range);
    if (lost->nonfinite)
        sl_scene_warn(scene, "%zu triangles with NaN or infinite vertices dropped", lost->nonfinite);
    if (lost->without_area) sl_scene_warn(scene, "%zu triangles without area dropped", lost->without_area);
}

static sl_status fail_without_triangles(size_t given, const dropped *lost, sl_error *error) {
    if (!given)
        return sl_fail(
            error, SL_ERROR_INPUT,
            "no triangles: expected faces of three corners or more (points and lines are not drawn)");
    return sl_fail(error, SL_ERROR_INPUT,
                   "no triangles: expected one with an area; of %zu, %zu have NaN or infinite vertices, %zu "
                   "indices out of range, and %zu no area",
                   given, lost->nonfinite, lost->out_of_range, lost->without_area);
}

/* A surface's triangles follow each other, so they do after those without area, which poles are made of, are
 * gone without a word. */
static sl_status keep_surface(const sl_scene_parts *parts, sl_scene *s, const sl_bicubic *from,
                              sl_bicubic *to, sl_error *error) {
    to->first_triangle = (uint32_t)s->triangle_count;
    dropped lost = {0};
    sl_vec3 normal;
    for (uint32_t t = from->first_triangle; t < from->first_triangle + from->triangle_count; t++) {
        if (keep_triangle(parts, t, &normal, &lost)) add_triangle(parts, s, t, normal);
    }
    to->triangle_count = (uint32_t)s->triangle_count - to->first_triangle;
    if (to->triangle_count && lost.out_of_range + lost.nonfinite == 0) return SL_OK;
    return sl_fail(error, SL_ERROR_INPUT, "a bicubic surface has no area or is not finite");
}

/* Fills the scene's triangles; their corners still name the parts' vertices. */
static sl_status copy_triangles(const sl_scene_parts *parts, sl_scene *s, sl_error *error) {
    size_t count = parts->triangle_count;
    uint32_t **whole[] = {&s->vertex[0], &s->vertex[1], &s->vertex[2], &s->material_index, &s->object_index};
    float **real[] = {&s->geometric_normal_x, &s->geometric_normal_y, &s->geometric_normal_z};
    for (size_t i = 0; i < 5; i++) {
        if (!(*whole[i] = sl_allocate(count, sizeof(uint32_t))))
            return sl_fail_memory(error, "the scene's triangles");
    }
    for (size_t i = 0; i < 3; i++) {
        if (!(*real[i] = sl_allocate(count, sizeof(float))))
            return sl_fail_memory(error, "the scene's triangles");
    }
    sl_status status = sl_bicubics_copy(parts, s, error);
    if (status != SL_OK) return status;
    dropped lost = {0};
    size_t surface = 0;
    for (size_t t = 0; t < count; t++) {
        if (parts->material_index && parts->material_index[t] >= s->material_count) {
            return sl_fail(error, SL_ERROR_INPUT, "triangle %zu names material %u of %zu", t,
                           parts->material_index[t], s->material_count);
        }
        sl_vec3 normal;
        if (surface < parts->bicubic_count && t == parts->bicubics[surface].first_triangle) {
            status = keep_surface(parts, s, &parts->bicubics[surface], &s->bicubics[surface], error);
            if (status != SL_OK) return status;
            t += parts->bicubics[surface++].triangle_count - 1;
        } else if (keep_triangle(parts, t, &normal, &lost)) {
            add_triangle(parts, s, t, normal);
        }
    }
    warn_of_dropped(s, &lost);
    return s->triangle_count ? SL_OK : fail_without_triangles(count, &lost, error);
}

/* ---- vertices -------------------------------------------------------------------------------- */

/* Vertices in the order of their first use, while they are being collected. */
typedef struct vertex_list {
    uint32_t *latest;  /* of each of the parts' vertices: the newest of ours made from it, or SL_NO_INDEX */
    uint32_t *source;  /* of each of ours: the parts' vertex */
    sl_vec3 *normal;   /* of each of ours */
    size_t count;
} vertex_list;

static bool given_normal(const sl_scene_parts *parts, uint32_t vertex, sl_vec3 *normal) {
    if (!parts->normals) return false;
    *normal = sl_normalize_or(vector_at(parts->normals, vertex), sl_v3(0, 0, 0));
    return sl_dot(*normal, *normal) > 0.5f;
}

static bool same(sl_vec3 a, sl_vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

/* Our vertex for a corner. With a normal of its own a vertex is shared; without, only among facets that face
 * the same way. */
static uint32_t vertex_for(vertex_list *list, const sl_scene_parts *parts, uint32_t source,
                           sl_vec3 facet_normal) {
    uint32_t latest = list->latest[source];
    sl_vec3 normal;
    bool given = given_normal(parts, source, &normal);
    if (!given) normal = facet_normal;
    if (latest != SL_NO_INDEX && (given || same(list->normal[latest], normal))) return latest;
    uint32_t made = (uint32_t)list->count++;
    list->source[made] = source;
    list->normal[made] = normal;
    list->latest[source] = made;
    return made;
}

/* All vertices of a surface, row by row, whether its triangles use them or not: their numbers say where on it
 * they lie. */
static void add_surface_vertices(vertex_list *list, const sl_scene_parts *parts, const sl_bicubic *from,
                                 sl_bicubic *to) {
    uint32_t side = (uint32_t)from->steps + 1;
    to->first_vertex = (uint32_t)list->count;
    for (uint32_t v = 0; v < side * side; v++) {
        uint32_t source = from->first_vertex + v, made = (uint32_t)list->count++;
        given_normal(parts, source, &list->normal[made]);
        list->source[made] = source;
        list->latest[source] = made;
    }
}

static void collect_vertices(vertex_list *list, const sl_scene_parts *parts, sl_scene *s) {
    size_t surface = 0;
    for (size_t t = 0; t < s->triangle_count; t++) {
        if (surface < s->bicubic_count && t == s->bicubics[surface].first_triangle) {
            add_surface_vertices(list, parts, &parts->bicubics[surface], &s->bicubics[surface]);
            surface++;
        }
        sl_vec3 facet = sl_scene_geometric_normal(s, (uint32_t)t);
        for (int c = 0; c < 3; c++) s->vertex[c][t] = vertex_for(list, parts, s->vertex[c][t], facet);
    }
}

static sl_status allocate_vertices(sl_scene *s, size_t count, sl_error *error) {
    float **arrays[] = {&s->position_x, &s->position_y, &s->position_z, &s->normal_x,
                        &s->normal_y,   &s->normal_z,   &s->texture_u,  &s->texture_v};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++) {
        if (!(*arrays[i] = sl_allocate(count, sizeof(float))))
            return sl_fail_memory(error, "the scene's vertices");
    }
    s->vertex_count = count;
    return SL_OK;
}

static void fill_vertices(const sl_scene_parts *parts, const vertex_list *list, sl_scene *s) {
    for (size_t v = 0; v < list->count; v++) {
        sl_vec3 p = vector_at(parts->positions, list->source[v]), n = list->normal[v];
        s->position_x[v] = p.x;
        s->position_y[v] = p.y;
        s->position_z[v] = p.z;
        s->normal_x[v] = n.x;
        s->normal_y[v] = n.y;
        s->normal_z[v] = n.z;
        if (!parts->texture_coordinates) continue;
        float u = parts->texture_coordinates[2 * (size_t)list->source[v]];
        float w = parts->texture_coordinates[2 * (size_t)list->source[v] + 1];
        s->texture_u[v] = isfinite(u) ? u : 0.0f;
        s->texture_v[v] = isfinite(w) ? w : 0.0f;
    }
}

/* No vertex list can be longer than its triangles have corners and its surfaces vertices. */
static sl_status make_vertices(const sl_scene_parts *parts, sl_scene *s, sl_error *error) {
    size_t corners = 3 * s->triangle_count;
    for (size_t i = 0; i < s->bicubic_count; i++)
        corners += ((size_t)s->bicubics[i].steps + 1) * ((size_t)s->bicubics[i].steps + 1);
    if (corners >= SL_NO_INDEX)
        return sl_fail(error, SL_ERROR_RESOURCES, "more than %u triangle corners", SL_NO_INDEX);
    vertex_list list = {sl_allocate(parts->vertex_count, sizeof(uint32_t)),
                        sl_allocate(corners, sizeof(uint32_t)), sl_allocate(corners, sizeof(sl_vec3)), 0};
    sl_status status = SL_OK;
    if (!list.latest || !list.source || !list.normal) {
        status = sl_fail_memory(error, "the scene's vertices");
    } else {
        memset(list.latest, 0xff, parts->vertex_count * sizeof(uint32_t)); /* SL_NO_INDEX */
        collect_vertices(&list, parts, s);
        status = allocate_vertices(s, list.count, error);
    }
    if (status == SL_OK) fill_vertices(parts, &list, s);
    sl_free(list.latest);
    sl_free(list.source);
    sl_free(list.normal);
    return status;
}

/* ---- objects, camera, the whole -------------------------------------------------------------- */

static sl_status name_objects(const sl_scene_parts *parts, sl_scene *s, sl_error *error) {
    size_t count = parts->object_count ? parts->object_count : 1;
    for (size_t t = 0; t < s->triangle_count; t++) {
        if (s->object_index[t] < count) continue;
        if (parts->object_count)
            return sl_fail(error, SL_ERROR_INPUT, "a triangle names object %u of %zu", s->object_index[t],
                           count);
        count = (size_t)s->object_index[t] + 1;
    }
    if (!(s->object_names = sl_allocate(count, sizeof *s->object_names)))
        return sl_fail_memory(error, "the scene's objects");
    s->object_count = count;
    for (size_t i = 0; i < count; i++) {
        s->object_names[i] =
            sl_string_copy(parts->object_names && i < parts->object_count ? parts->object_names[i] : "");
        if (!s->object_names[i]) return sl_fail_memory(error, "the scene's objects");
    }
    return SL_OK;
}

static bool camera_is_valid(const sl_camera *c) {
    sl_camera check;
    return sl_is_finite(c->right) && sl_is_finite(c->up) && sl_is_finite(c->eye) &&
           sl_camera_look_at(&check, sl_v3(0, 0, 0), sl_neg(c->back), c->up, c->vertical_fov);
}

/* Parts of a view that replace the camera's own; an eye alone looks at the middle of the scene. */
static bool take_view(const sl_viewpoint *v, const sl_scene *s, sl_camera *camera) {
    sl_vec3d low = sl_to_double(s->box_min), high = sl_to_double(s->box_max);
    sl_vec3 middle = sl_to_float(sl_scaled(sl_addd(low, high), 0.5));
    sl_vec3 eye = v->has_eye ? sl_v3(v->eye[0], v->eye[1], v->eye[2]) : camera->eye;
    sl_vec3 target = v->has_target ? sl_v3(v->target[0], v->target[1], v->target[2])
                     : v->has_eye  ? middle
                                   : sl_sub(eye, camera->back);
    sl_vec3 up = v->has_up ? sl_v3(v->up[0], v->up[1], v->up[2]) : sl_v3(0, 1, 0);
    float fov = v->has_fov ? v->vertical_fov_rad : camera->vertical_fov;
    if (!v->has_eye && !v->has_target) { /* looking from the origin keeps all bits of the direction */
        bool good =
            sl_camera_look_at(camera, sl_v3(0, 0, 0), sl_neg(camera->back), v->has_up ? up : camera->up, fov);
        camera->eye = eye;
        return good;
    }
    return sl_camera_look_at(camera, eye, target, up, fov);
}

static sl_status place_camera(const sl_scene_parts *parts, sl_scene *s, bool *shut_out, sl_error *error) {
    bool inside = false;
    const sl_viewpoint *view = parts->view;
    if (parts->camera && !camera_is_valid(parts->camera)) {
        return sl_fail(
            error, SL_ERROR_INPUT,
            "camera: expected a finite frame and a vertical field of view between 0 and 180 degrees");
    }
    s->camera = parts->camera ? *parts->camera : sl_camera_framed(s, &inside, shut_out);
    if (view && !take_view(view, s, &s->camera)) {
        return sl_fail(error, SL_ERROR_USAGE,
                       "camera: expected an eye apart from its target, an up vector not along the view "
                       "and a vertical field of view between 0 and 180 degrees");
    }
    *shut_out = *shut_out && !(view && view->has_eye);
    if (parts->camera || (view && view->has_eye)) return SL_OK;
    sl_vec3 eye = s->camera.eye, back = s->camera.back;
    sl_scene_warn(s, "no camera: %s (eye %g %g %g, looking along %.3g %.3g %.3g, %.3g degrees)",
                  inside ? "one is put into the room" : "the whole scene is framed from outside",
                  (double)eye.x, (double)eye.y, (double)eye.z, -(double)back.x, -(double)back.y,
                  -(double)back.z, (double)s->camera.vertical_fov * 57.29577951308232);
    return SL_OK;
}

static sl_status light_if_dark(const sl_scene_parts *parts, sl_scene *s, bool shut_out, sl_error *error) {
    bool any = s->light_count || s->emitter_count || s->environment.present;
    if (any && !shut_out) return SL_OK;
    if (parts->default_light) return sl_scene_light_by_default(s, error);
    if (!any) sl_scene_warn(s, "no light: the picture will be black");
    return SL_OK;
}

static sl_status set_film(const sl_scene_parts *parts, sl_scene *s, sl_error *error) {
    s->film_width = parts->film_width ? parts->film_width : FILM_DEFAULT;
    s->film_height = parts->film_height ? parts->film_height : FILM_DEFAULT;
    if (s->film_width > 0 && s->film_height > 0) return SL_OK;
    return sl_fail(error, SL_ERROR_INPUT, "film: expected a width and height of at least 1");
}

static sl_status fill_scene(const sl_scene_parts *parts, sl_scene *s, sl_error *error) {
    sl_status (*const steps[])(const sl_scene_parts *, sl_scene *, sl_error *) = {
        set_film, copy_textures, copy_materials, copy_lights, copy_triangles, make_vertices, name_objects};
    for (size_t i = 0; i < sizeof steps / sizeof steps[0]; i++) {
        sl_status status = steps[i](parts, s, error);
        if (status != SL_OK) return status;
    }
    sl_status status = sl_scene_make_emitters(s, error);
    if (status != SL_OK) return status;
    bool shut_out = false;
    status = place_camera(parts, s, &shut_out, error);
    if (status == SL_OK) status = light_if_dark(parts, s, shut_out, error);
    sl_scene_measure_from(s, s->camera.eye);
    return status;
}

sl_status sl_scene_build(const sl_scene_parts *parts, sl_scene **scene, sl_error *error) {
    *scene = NULL;
    if (parts->triangle_count >= SL_NO_INDEX || parts->vertex_count >= SL_NO_INDEX) {
        return sl_fail(error, SL_ERROR_RESOURCES, "more than %u triangles or vertices", SL_NO_INDEX - 1);
    }
    sl_scene *made = sl_allocate(1, sizeof *made);
    if (!made) return sl_fail_memory(error, "the scene");
    sl_status status = fill_scene(parts, made, error);
    if (status == SL_OK) *scene = made;
    else sl_scene_destroy(made);
    return status;
}
