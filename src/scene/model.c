#include "scene/model.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "base/print.h"
#include "base/random.h"
#include "image/decode.h"
#include "scene/bicubic.h"
#include "scene/derive.h"
#include "scene/file.h"
#include "scene/texture.h"

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

sl_status sl_model_add_vertices(sl_model *m, size_t count, uint32_t object, size_t *first, sl_error *error) {
    const column columns[] = {COLUMN(m->positions, 3), COLUMN(m->normals, 3), COLUMN(m->uvs, 2),
                              COLUMN(m->vertex_object, 1)};
    if (count >= SL_NO_INDEX || m->vertex_count + count >= SL_NO_INDEX)
        return sl_fail(error, SL_ERROR_RESOURCES, "more than %u vertices", SL_NO_INDEX);
    if (!make_room(columns, 4, m->vertex_count, &m->vertex_room, count))
        return sl_fail_memory(error, "the vertices");
    *first = m->vertex_count;
    m->vertex_count += count;
    for (size_t v = *first; v < m->vertex_count; v++) m->vertex_object[v] = object;
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

sl_status sl_model_add_bicubic(sl_model *m, const sl_bicubic *surface, uint32_t material, uint32_t object,
                               sl_error *error) {
    const column columns[] = {COLUMN(m->bicubics, 1)};
    size_t n = (size_t)surface->steps, vertices = (n + 1) * (n + 1), triangles = 2 * n * n, first_vertex,
           first_triangle;
    if (!make_room(columns, 1, m->bicubic_count, &m->bicubic_room, 1))
        return sl_fail_memory(error, "the surfaces");
    sl_status status = sl_model_add_vertices(m, vertices, object, &first_vertex, error);
    if (status == SL_OK) status = sl_model_add_triangles(m, triangles, &first_triangle, error);
    if (status != SL_OK) return status;
    if (first_triangle + triangles >= SL_NO_INDEX)
        return sl_fail(error, SL_ERROR_RESOURCES, "more than %u triangles", SL_NO_INDEX);
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
    const column columns[] = {COLUMN(m->materials, 1)};
    char *name = sl_string_copy(material->name);
    if (!name || !make_room(columns, 1, m->material_count, &m->material_room, 1)) {
        sl_free(name);
        return sl_fail_memory(error, "the materials");
    }
    *index = (uint32_t)m->material_count++;
    m->materials[*index] = *material;
    m->materials[*index].name = name;
    return SL_OK;
}

sl_status sl_model_add_light(sl_model *m, const sl_light *light, sl_error *error) {
    const column columns[] = {COLUMN(m->lights, 1)};
    if (!make_room(columns, 1, m->light_count, &m->light_room, 1)) return sl_fail_memory(error, "the lights");
    m->lights[m->light_count++] = *light;
    return SL_OK;
}

static bool add_string(char ***list, size_t *count, size_t *room, const char *text) {
    const column columns[] = {COLUMN(*list, 1)};
    char *copy = sl_string_copy(text);
    if (!copy || !make_room(columns, 1, *count, room, 1)) {
        sl_free(copy);
        return false;
    }
    (*list)[(*count)++] = copy;
    return true;
}

sl_status sl_model_add_object(sl_model *m, const char *name, uint32_t *index, sl_error *error) {
    *index = (uint32_t)m->object_count;
    if (!add_string(&m->object_names, &m->object_count, &m->object_room, name))
        return sl_fail_memory(error, "the objects");
    return SL_OK;
}

void sl_model_warn(sl_model *m, const char *format, ...) {
    char line[1024];
    va_list arguments;
    va_start(arguments, format);
    sl_print_list(line, sizeof line, format, arguments);
    va_end(arguments);
    for (size_t i = 0; i < m->warning_count; i++) {
        if (strcmp(m->warnings[i], line) == 0) return; /* once is enough */
    }
    if (m->warning_count == SL_WARNINGS_OF_READING) m->warnings_left_out++;
    else add_string(&m->warnings, &m->warning_count, &m->warning_room, line);
}

void sl_model_clear(sl_model *m) {
    void *plain[] = {m->positions,      m->normals,      m->uvs,      m->vertex_object, m->indices,
                     m->material_index, m->object_index, m->bicubics, m->lights,        m->environment.texels,
                     m->folder};
    for (size_t i = 0; i < sizeof plain / sizeof plain[0]; i++) sl_free(plain[i]);
    for (size_t i = 0; i < m->material_count; i++) sl_free(m->materials[i].name);
    sl_free(m->materials);
    for (size_t i = 0; i < m->texture_count; i++) {
        sl_free(m->textures[i].file);
        sl_free(m->textures[i].texels);
    }
    sl_free(m->textures);
    sl_strings_free(m->object_names, m->object_count);
    sl_strings_free(m->warnings, m->warning_count);
    sl_strings_free(m->files, m->file_count);
    *m = (sl_model){0};
}

/* ---- where files may lie --------------------------------------------------------------------- */

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
    if (!sl_file_exists(path) || add_string(&m->files, &m->file_count, &m->file_room, path)) return SL_OK;
    return sl_fail_memory(error, "a file name");
}

/* ---- textures -------------------------------------------------------------------------------- */

/* An alpha channel that is opaque everywhere says nothing: then a mask is read from the luminance. */
static bool alpha_says_something(const sl_texture *t) {
    for (size_t i = 0; i < (size_t)t->width * (size_t)t->height; i++) {
        if (t->texels[4 * i + 3] != 255) return true;
    }
    return false;
}

sl_status sl_model_texture(sl_model *m, const char *path, const void *memory, size_t bytes, uint32_t *index,
                           sl_error *error) {
    for (size_t i = 0; i < m->texture_count; i++) {
        if (strcmp(m->textures[i].file, path) == 0) {
            *index = (uint32_t)i;
            return SL_OK;
        }
    }
    *index = SL_NO_INDEX;
    if (!memory) {
        sl_status status = sl_model_may_read(m, path, error);
        if (status == SL_OK) status = sl_model_note_file(m, path, error);
        if (status != SL_OK) return status;
    }
    const column columns[] = {COLUMN(m->textures, 1)};
    if (!make_room(columns, 1, m->texture_count, &m->texture_room, 1))
        return sl_fail_memory(error, "the textures");
    sl_texture texture = {0};
    sl_error problem;
    sl_status status = sl_decode_texels(path, memory, bytes, &texture.width, &texture.height,
                                        &texture.has_alpha, &texture.texels, &problem);
    if (status == SL_ERROR_RESOURCES) return sl_fail(error, status, "%s", problem.message);
    if (status != SL_OK) {
        sl_model_warn(m, "texture left out: %s", problem.message);
        return SL_OK;
    }
    texture.has_alpha = texture.has_alpha && alpha_says_something(&texture);
    texture.file = sl_string_copy(path);
    if (!texture.file) {
        sl_free(texture.texels);
        return sl_fail_memory(error, "the textures");
    }
    *index = (uint32_t)m->texture_count;
    m->textures[m->texture_count++] = texture;
    return SL_OK;
}

sl_rgb sl_texture_mean_color(const sl_texture *t) {
    double sum[3] = {0, 0, 0};
    for (int y = 0; y < t->height; y++) {
        for (int x = 0; x < t->width; x++) {
            sl_rgb c = sl_texture_texel(t, x, y);
            sum[0] += (double)c.r;
            sum[1] += (double)c.g;
            sum[2] += (double)c.b;
        }
    }
    double texels = (double)t->width * (double)t->height;
    return (sl_rgb){(float)(sum[0] / texels), (float)(sum[1] / texels), (float)(sum[2] / texels)};
}

sl_rgb sl_texture_mean_data(const sl_texture *t) {
    uint64_t sum[3] = {0, 0, 0};
    size_t texels = (size_t)t->width * (size_t)t->height;
    for (size_t i = 0; i < texels; i++) {
        for (size_t c = 0; c < 3; c++) sum[c] += t->texels[4 * i + c];
    }
    double scale = 255.0 * (double)texels;
    return (sl_rgb){(float)((double)sum[0] / scale), (float)((double)sum[1] / scale),
                    (float)((double)sum[2] / scale)};
}

/* ---- welding --------------------------------------------------------------------------------- */

typedef struct vertex_key {
    float value[8]; /* position, normal, texture coordinates; -0 as +0 */
    uint32_t object;
} vertex_key;

static vertex_key key_of(const sl_model *m, size_t v) {
    vertex_key key;
    for (size_t i = 0; i < 3; i++) {
        key.value[i] = m->positions[3 * v + i] + 0.0f;
        key.value[3 + i] = m->normals[3 * v + i] + 0.0f;
    }
    key.value[6] = m->uvs[2 * v] + 0.0f;
    key.value[7] = m->uvs[2 * v + 1] + 0.0f;
    key.object = m->vertex_object[v];
    return key;
}

static uint64_t hash_of(const vertex_key *key) {
    uint64_t hash = key->object, word;
    for (int i = 0; i < 8; i += 2) {
        memcpy(&word, &key->value[i], sizeof word);
        hash = sl_hash64(hash ^ word);
    }
    return hash;
}

static bool same_key(const vertex_key *a, const vertex_key *b) {
    return memcmp(a->value, b->value, sizeof a->value) == 0 && a->object == b->object;
}

/* Open addressing; the first vertex of a kind stands for all, so the result does not depend on the table. */
sl_status sl_model_weld(sl_model *m, sl_error *error) {
    size_t slots = 16;
    while (slots < 2 * m->vertex_count) slots *= 2;
    uint32_t *table = sl_allocate(slots, sizeof *table),
             *stand_in = sl_allocate(m->vertex_count, sizeof *stand_in);
    if (!table || !stand_in) {
        sl_free(table);
        sl_free(stand_in);
        return sl_fail_memory(error, "welding");
    }
    memset(table, 0xff, slots * sizeof *table); /* SL_NO_INDEX */
    for (size_t v = 0; v < m->vertex_count; v++) {
        vertex_key key = key_of(m, v);
        size_t slot = (size_t)hash_of(&key) & (slots - 1);
        for (;; slot = (slot + 1) & (slots - 1)) {
            if (table[slot] == SL_NO_INDEX) table[slot] = (uint32_t)v;
            vertex_key other = key_of(m, table[slot]);
            if (same_key(&key, &other)) break;
        }
        stand_in[v] = table[slot];
    }
    for (size_t i = 0; i < m->bicubic_count; i++) { /* their numbers say where they lie */
        uint32_t side = (uint32_t)m->bicubics[i].steps + 1, first = m->bicubics[i].first_vertex;
        for (uint32_t v = first; v < first + side * side; v++) stand_in[v] = v;
    }
    for (size_t i = 0; i < 3 * m->triangle_count; i++) {
        if (m->indices[i] < m->vertex_count) m->indices[i] = stand_in[m->indices[i]];
    }
    sl_free(table);
    sl_free(stand_in);
    return SL_OK;
}

/* ---- the scene ------------------------------------------------------------------------------- */

/* The model's warnings before those of the build: they were found first. */
static void pass_warnings_on(const sl_model *m, sl_scene *scene) {
    size_t built = scene->warning_count;
    for (size_t i = 0; i < m->warning_count; i++) sl_scene_warn(scene, "%s", m->warnings[i]);
    size_t added = scene->warning_count - built;
    for (size_t i = 0; i < built; i++) { /* rotate left by `built`, one at a time: both lists are short */
        char *first = scene->warnings[0];
        memmove(scene->warnings, scene->warnings + 1, (built + added - 1) * sizeof *scene->warnings);
        scene->warnings[built + added - 1] = first;
    }
    if (m->warnings_left_out) sl_scene_leave_out_warnings(scene, m->warnings_left_out);
}

sl_status sl_model_build(sl_model *m, sl_scene **scene, sl_error *error) {
    *scene = NULL;
    sl_status status = sl_model_weld(m, error);
    if (status != SL_OK) return status;
    sl_scene_parts parts = {.vertex_count = m->vertex_count,
                            .positions = m->positions,
                            .normals = m->normals,
                            .texture_coordinates = m->uvs,
                            .triangle_count = m->triangle_count,
                            .indices = m->indices,
                            .material_index = m->material_index,
                            .object_index = m->object_index,
                            .bicubic_count = m->bicubic_count,
                            .bicubics = m->bicubics,
                            .material_count = m->material_count,
                            .materials = m->materials,
                            .texture_count = m->texture_count,
                            .textures = m->textures,
                            .light_count = m->light_count,
                            .lights = m->lights,
                            .environment = m->environment.present ? &m->environment : NULL,
                            .camera = m->has_camera ? &m->camera : NULL,
                            .view = m->view,
                            .film_width = m->film_width,
                            .film_height = m->film_height,
                            .default_light = true,
                            .object_count = m->object_count,
                            .object_names = (const char *const *)m->object_names};
    status = sl_scene_build(&parts, scene, error);
    if (status != SL_OK) return status;
    pass_warnings_on(m, *scene);
    (*scene)->files = m->files;
    (*scene)->file_count = m->file_count;
    m->files = NULL;
    m->file_count = m->file_room = 0;
    return SL_OK;
}
