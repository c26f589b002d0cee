#include "scene/model.h"

#include <errno.h>
#include <string.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "image/formats.h"
#include "scene/bicubic.h"
#include "scene/derive.h"
#include "scene/file.h"

/* ---- lists that grow ------------------------------------------------------------------------- */

typedef struct column {
    void *array; /* as in sl_regrow() */
    size_t size; /* bytes of one entry */
} column;

/* Room for `count` more entries in columns that share one count. What is beyond the count is zero. */
static bool make_room(const column *columns, size_t column_count, size_t used, size_t *room, size_t count) {
    if (count <= *room - used) return true;
    size_t wanted = used + count > 2 * *room ? used + count : 2 * *room;
    if (wanted < used) return false;
    for (size_t i = 0; i < column_count; i++) {
        if (!sl_regrow(columns[i].array, used, wanted, columns[i].size)) return false;
    }
    *room = wanted;
    return true;
}

#define COLUMN(list, per_entry) {&(list), (per_entry) * sizeof *(list)}

sl_status sl_model_add_vertices(sl_model *m, size_t count, size_t *first, sl_error *error) {
    const column columns[] = {COLUMN(m->positions, 3), COLUMN(m->normals, 3), COLUMN(m->uvs, 2)};
    if (count >= SL_NO_INDEX || m->vertex_count + count >= SL_NO_INDEX)
        return sl_fail(error, SL_ERROR_RESOURCES, "more than %u vertices", SL_NO_INDEX);
    if (!make_room(columns, 3, m->vertex_count, &m->vertex_room, count))
        return sl_fail_memory(error, "the vertices");
    *first = m->vertex_count;
    m->vertex_count += count;
    return SL_OK;
}

sl_status sl_model_add_triangles(sl_model *m, size_t count, size_t *first, sl_error *error) {
    const column columns[] = {COLUMN(m->indices, 3), COLUMN(m->material_index, 1),
                              COLUMN(m->object_index, 1)};
    const size_t most = (SL_NO_INDEX - 1) / 3; /* corners are counted in 32 bits */
    if (count > most || m->triangle_count + count > most)
        return sl_fail(error, SL_ERROR_RESOURCES, "more than %zu triangles", most);
    if (!make_room(columns, 3, m->triangle_count, &m->triangle_room, count))
        return sl_fail_memory(error, "the triangles");
    *first = m->triangle_count;
    m->triangle_count += count;
    return SL_OK;
}

static sl_vec3d vector_at(const float *xyz, size_t i) {
    return sl_v3d((double)xyz[3 * i], (double)xyz[3 * i + 1], (double)xyz[3 * i + 2]);
}

static void place_vertices(sl_model *m, const sl_mesh *mesh, const sl_affine *placement, size_t first) {
    const sl_affine normal_map = sl_affine_normal_map(placement);
    const bool stays = sl_affine_is_identity(placement);
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        const sl_vec3 p = sl_to_float(sl_affine_point(placement, vector_at(mesh->positions, v)));
        memcpy(m->positions + 3 * (first + v), (float[3]){p.x, p.y, p.z}, 3 * sizeof(float));
        if (!mesh->normals) continue;
        const sl_vec3 given = sl_to_float(vector_at(mesh->normals, v)),
                      n = stays ? sl_unit_or(given, sl_v3(0, 0, 0)) : sl_affine_unit(&normal_map, given);
        memcpy(m->normals + 3 * (first + v), (float[3]){n.x, n.y, n.z}, 3 * sizeof(float));
    }
    if (mesh->uvs && mesh->vertex_count)
        memcpy(m->uvs + 2 * first, mesh->uvs, 2 * mesh->vertex_count * sizeof(float));
}

sl_status sl_mesh_check(const char *path, const sl_mesh *mesh, sl_error *error) {
    for (size_t i = 0; i < 3 * mesh->triangle_count; i++) {
        if (mesh->corners[i] < mesh->vertex_count) continue;
        return sl_fail(error, SL_ERROR_INPUT,
                       "%s%smesh '%s': index %zu of triangle %zu is %u, the mesh has %zu vertices", path,
                       *path ? ": " : "", mesh->name, i, i / 3, mesh->corners[i], mesh->vertex_count);
    }
    return SL_OK;
}

/* A placement that mirrors would turn fronts into backs: two corners change places. */
sl_status sl_model_add_mesh(sl_model *m, const char *path, const sl_mesh *mesh, const sl_affine *placement,
                            sl_error *error) {
    const bool mirrored = sl_affine_determinant(placement) < 0.0;
    size_t first_vertex, first;
    sl_status status = sl_mesh_check(path, mesh, error);
    if (status == SL_OK) status = sl_model_add_vertices(m, mesh->vertex_count, &first_vertex, error);
    if (status == SL_OK) status = sl_model_add_triangles(m, mesh->triangle_count, &first, error);
    if (status != SL_OK) return status;
    place_vertices(m, mesh, placement, first_vertex);
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        for (size_t c = 0; c < 3; c++) {
            const uint32_t corner = mesh->corners[3 * t + (mirrored && c > 0 ? 3 - c : c)];
            m->indices[3 * (first + t) + c] = (uint32_t)first_vertex + corner;
        }
        m->material_index[first + t] = mesh->material;
        m->object_index[first + t] = mesh->object;
    }
    return SL_OK;
}

sl_status sl_model_add_bicubic(sl_model *m, const sl_bicubic *surface, uint32_t material, uint32_t object,
                               sl_error *error) {
    const column columns[] = {COLUMN(m->bicubics, 1)};
    size_t n = (size_t)surface->steps, vertices = (n + 1) * (n + 1), triangles = 2 * n * n, first_vertex,
           first_triangle;
    if (!make_room(columns, 1, m->bicubic_count, &m->bicubic_room, 1))
        return sl_fail_memory(error, "the surfaces");
    sl_status status = sl_model_add_vertices(m, vertices, &first_vertex, error);
    if (status == SL_OK) status = sl_model_add_triangles(m, triangles, &first_triangle, error);
    if (status != SL_OK) return status;
    sl_bicubic *b = &m->bicubics[m->bicubic_count++];
    *b = *surface;
    b->first_vertex = (uint32_t)first_vertex;
    b->first_triangle = (uint32_t)first_triangle;
    b->triangle_count = (uint32_t)triangles;
    sl_bicubic_tessellate(b, m->positions + 3 * first_vertex, m->normals + 3 * first_vertex,
                          m->uvs + 2 * first_vertex, m->indices + 3 * first_triangle);
    for (size_t t = first_triangle; t < m->triangle_count; t++) {
        m->material_index[t] = material;
        m->object_index[t] = object;
    }
    return SL_OK;
}

sl_status sl_model_add_material(sl_model *m, const sl_material *material, uint32_t *index, sl_error *error) {
    sl_scene *s = &m->scene;
    char *name = sl_string_copy(material->name);
    if (!name || !sl_make_room(&s->materials, s->material_count, &m->material_room, sizeof *s->materials)) {
        sl_free(name);
        return sl_fail_memory(error, "the materials");
    }
    *index = (uint32_t)s->material_count++;
    s->materials[*index] = *material;
    s->materials[*index].name = name;
    return SL_OK;
}

sl_status sl_model_add_light(sl_model *m, const sl_light *light, uint32_t *index, sl_error *error) {
    sl_scene *s = &m->scene;
    const sl_rgb i = light->intensity;
    *index = SL_NO_INDEX;
    if (!m->keeps_dark_lights && i.r == 0.0f && i.g == 0.0f && i.b == 0.0f) {
        m->dark_lights++;
        return SL_OK;
    }
    if (!sl_make_room(&s->lights, s->light_count, &m->light_room, sizeof *s->lights))
        return sl_fail_memory(error, "the lights");
    *index = (uint32_t)s->light_count++;
    s->lights[*index] = *light;
    return SL_OK;
}

static bool add_string(char ***list, size_t *count, size_t *room, const char *text) {
    char *copy = sl_string_copy(text);
    if (!copy || !sl_make_room(list, *count, room, sizeof **list)) {
        sl_free(copy);
        return false;
    }
    (*list)[(*count)++] = copy;
    return true;
}

sl_status sl_model_add_object(sl_model *m, const char *name, uint32_t *index, sl_error *error) {
    *index = (uint32_t)m->scene.object_count;
    if (add_string(&m->scene.object_names, &m->scene.object_count, &m->object_room, name)) return SL_OK;
    return sl_fail_memory(error, "the objects");
}

static bool find_texture(const sl_scene *s, const char *name, uint32_t *index) {
    for (size_t i = 0; i < s->texture_count; i++) {
        if (strcmp(s->textures[i].file, name) != 0) continue;
        *index = (uint32_t)i;
        return true;
    }
    return false;
}

/* An alpha channel that is opaque everywhere says nothing: then a mask is read from the luminance. */
static bool alpha_says_something(const sl_texture *t) {
    for (size_t i = 0; i < (size_t)t->width * (size_t)t->height; i++) {
        if (t->texels[4 * i + 3] != 255) return true;
    }
    return false;
}

sl_status sl_model_add_texture(sl_model *m, const char *name, const sl_texture *texture, uint32_t *index,
                               sl_error *error) {
    sl_scene *s = &m->scene;
    const bool known = find_texture(s, name, index);
    char *copy = known ? NULL : sl_string_copy(name);
    if (!copy || !sl_make_room(&s->textures, s->texture_count, &m->texture_room, sizeof *s->textures)) {
        sl_free(copy);
        sl_free(texture->texels);
        return known ? SL_OK : sl_fail_memory(error, "the textures");
    }
    *index = (uint32_t)s->texture_count++;
    s->textures[*index] = *texture;
    s->textures[*index].file = copy;
    s->textures[*index].has_alpha = texture->has_alpha && alpha_says_something(texture);
    return SL_OK;
}

void sl_model_drop_geometry(sl_model *m) {
    SL_FREE_ALL(m->positions, m->normals, m->uvs, m->indices, m->material_index, m->object_index,
                m->bicubics);
    m->positions = m->normals = m->uvs = NULL;
    m->indices = m->material_index = m->object_index = NULL;
    m->bicubics = NULL;
    m->vertex_count = m->triangle_count = m->bicubic_count = 0;
    m->vertex_room = m->triangle_room = m->bicubic_room = 0;
}

void sl_model_clear(sl_model *m) {
    sl_model_drop_geometry(m);
    sl_free(m->folder);
    sl_scene_release(&m->scene);
    *m = (sl_model){0};
}

/* ---- files that it names --------------------------------------------------------------------- */

sl_status sl_model_confine(sl_model *m, const char *path, sl_error *error) {
    m->folder = sl_file_folder(path);
    return m->folder ? SL_OK
                     : sl_fail(error, sl_status_of_errno(errno, SL_ERROR_INPUT),
                               "%s: its folder cannot be read", path);
}

sl_status sl_model_may_read(const sl_model *m, const char *path, sl_error *error) {
    if (sl_file_is_below(m->folder, path)) return SL_OK;
    return sl_fail(
        error, SL_ERROR_INPUT,
        "%s: lies outside of the scene's folder, which --allow-outside (sl_load_options) would allow", path);
}

sl_status sl_model_note_file(sl_model *m, const char *path, sl_error *error) {
    if (!sl_file_exists(path) || add_string(&m->scene.files, &m->scene.file_count, &m->file_room, path))
        return SL_OK;
    return sl_fail_memory(error, "a file name");
}

sl_status sl_model_texture(sl_model *m, const char *path, const void *memory, size_t bytes, uint32_t *index,
                           sl_error *error) {
    if (find_texture(&m->scene, path, index)) return SL_OK;
    *index = SL_NO_INDEX;
    sl_status status = memory ? SL_OK : sl_model_may_read(m, path, error);
    if (status == SL_OK && !memory) status = sl_model_note_file(m, path, error);
    if (status != SL_OK) return status;
    sl_texture texture = {0};
    sl_error problem;
    status = sl_decode_texels(path, memory, bytes, &texture.width, &texture.height, &texture.has_alpha,
                              &texture.texels, &problem);
    if (status == SL_ERROR_RESOURCES) return sl_fail(error, status, "%s", problem.message);
    if (status != SL_OK) {
        sl_scene_warn(&m->scene, "texture left out: %s", problem.message);
        return SL_OK;
    }
    return sl_model_add_texture(m, path, &texture, index, error);
}

/* "%20" in file names stands for a blank. */
static void decode_blanks(char *name) {
    char *to = name;
    for (const char *from = name; *from; from++) {
        const bool blank = strncmp(from, "%20", 3) == 0;
        *to++ = blank ? ' ' : *from;
        if (blank) from += 2;
    }
    *to = 0;
}

/* Without any that is there it is the name as it stands: reading that says what is wrong. */
static char *find_beside(const sl_model *m, const char *mesh_file, char *name) {
    char *best = NULL;
    int most = -1;
    for (char *c = name; *c; c++) *c = *c == '\\' ? '/' : *c;
    for (int i = 0; i < 3; i++) {
        if (i == 1) decode_blanks(name);
        const char *slash = i == 2 ? strrchr(name, '/') : NULL;
        char *path = sl_file_beside(mesh_file, slash ? slash + 1 : name);
        const bool exists = path && sl_file_exists(path);
        const int worth = exists + (exists && sl_file_is_below(m->folder, path));
        sl_free(worth > most ? best : path);
        if (worth > most) most = worth, best = path;
    }
    return best;
}

sl_status sl_model_texture_beside(sl_model *m, const char *mesh_file, char *name, uint32_t *index,
                                  sl_error *error) {
    char *path = find_beside(m, mesh_file, name);
    sl_status status = path ? sl_model_texture(m, path, NULL, 0, index, error)
                            : sl_fail_memory(error, "a file name");
    sl_free(path);
    return status;
}
