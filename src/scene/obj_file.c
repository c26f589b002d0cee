
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "scene/file.h"
#include "scene/lines.h"
#include "scene/mesh_file.h"
#include "scene/obj_materials.h"
#include "scene/polygons.h"

/* Positions, texture coordinates, normals, and how many numbers each may have. */
static const struct {
    const char *word, *name, *numbers, *index; /* the last two: what is expected */
    unsigned allowed; /* bit n: n numbers */
} kinds[SL_CORNER_PARTS] = {
    {"v", "vertex", "3, 4 or 6 numbers for a vertex", "a vertex index", 1 << 3 | 1 << 4 | 1 << 6},
    {"vt", "texture coordinate", "1, 2 or 3 numbers for a texture coordinate", "a texture coordinate index",
     1 << 1 | 1 << 2 | 1 << 3},
    {"vn", "normal", "3 numbers for a normal", "a normal index", 1 << 3}};

typedef struct reader {
    sl_lines lines;
    sl_polygons polygons;
    sl_obj_materials materials;
    sl_names objects;
    uint32_t *object_index; /* in the model, of each of them; SL_NO_INDEX: it has no face yet */
    size_t object_count, object_room;
    uint32_t object, material; /* of the faces to come */
    const sl_affine *placement;
    bool has_library, lacks_library;
    unsigned long short_faces, first_short; /* faces of fewer than three corners, and the line of the first */
    sl_model *model;
} reader;

static sl_status fail(const reader *r, const char *expected, const char *got) {
    return sl_lines_fail(&r->lines, expected, got);
}

static sl_status memory_if_not(const reader *r, bool added) {
    return added ? SL_OK : sl_fail_memory(r->lines.error, r->lines.path);
}

/* ---- numbers ------------------------------------------------------------------------------------------ */

/* Adds a position, which may be homogeneous, a normal or texture coordinates; colours are not used. */
static sl_status finish_value(reader *r, sl_corner_part part, unsigned count, float value[8]) {
    if (part == SL_CORNER_POSITION && count == 4) {
        if (value[3] == 0.0f)
            return sl_fail(r->lines.error, SL_ERROR_INPUT,
                           "%s:%lu: expected the fourth number of a vertex to be other than 0: it divides",
                           r->lines.path, r->lines.line);
        for (int i = 0; i < 3; i++) value[i] /= value[3];
    }
    if (count == 6) sl_scene_warn(&r->model->scene, "%s: vertex colours are not used", r->lines.path);
    for (int i = 0; part == SL_CORNER_UV && i < 2; i++) value[i] = isfinite(value[i]) ? value[i] : 0.0f;
    return memory_if_not(r, sl_polygons_add_value(&r->polygons, part, value));
}

static sl_status read_value(reader *r, sl_corner_part part, char *at) {
    float value[8] = {0};
    unsigned count = 0;
    for (char *end; !sl_is_line_end(at) && count < 8; at = end, count++) {
        end = sl_read_number(at, &value[count]);
        if (!end) return fail(r, kinds[part].numbers, at);
    }
    if (kinds[part].allowed >> count & 1u) return finish_value(r, part, count, value);
    return sl_fail(r->lines.error, SL_ERROR_INPUT, "%s:%lu: expected %s, got %u", r->lines.path,
                   r->lines.line, kinds[part].numbers, count);
}

/* ---- faces -------------------------------------------------------------------------------------------- */

static bool ends_word(const char *at) { return *at == ' ' || *at == '\t' || sl_is_line_end(at); }

/* Reads an index as the file has it, of what stands before it, into one from 0. */
static sl_status read_index(reader *r, sl_corner_part part, char **at, uint32_t *index) {
    const char *word = *at;
    const bool negative = *word == '-';
    const unsigned long count = r->polygons.count[part];
    unsigned long value = 0;
    char *digit = *at + (negative || *word == '+');
    for (*at = digit; **at >= '0' && **at <= '9'; ++*at) {
        if (value < 1000000000000ul) value = 10 * value + (unsigned long)(**at - '0');
    }
    if (*at == digit) return fail(r, kinds[part].index, word);
    if (value == 0 || (negative && value > count))
        return sl_fail(r->lines.error, SL_ERROR_INPUT,
                       "%s:%lu: %s index %s%lu is out of range: expected 1 or more, or -1 to -%lu",
                       r->lines.path, r->lines.line, kinds[part].name, negative ? "-" : "", value, count);
    if (value > count)
        return sl_fail(r->lines.error, SL_ERROR_INPUT,
                       "%s:%lu: %s index %lu is out of range: the file has %lu before it", r->lines.path,
                       r->lines.line, kinds[part].name, value, count);
    *index = (uint32_t)(negative ? count - value : value - 1);
    return SL_OK;
}

/* Reads v, v/vt, v//vn or v/vt/vn. */
static sl_status read_corner(reader *r, char **at, sl_corner *corner) {
    *corner = (sl_corner){{SL_NO_INDEX, SL_NO_INDEX, SL_NO_INDEX}};
    sl_status status = read_index(r, SL_CORNER_POSITION, at, &corner->at[0]);
    for (int part = 1; part < SL_CORNER_PARTS && status == SL_OK && **at == '/'; part++) {
        ++*at;
        if (**at != '/' && !ends_word(*at))
            status = read_index(r, (sl_corner_part)part, at, &corner->at[part]);
    }
    if (status == SL_OK && !ends_word(*at)) return fail(r, "face corners like 1, 1/2, 1//3 or 1/2/3", *at);
    *at += strspn(*at, " \t");
    return status;
}

static bool have_the_same(const sl_corner *a, const sl_corner *b) {
    return (a->at[1] == SL_NO_INDEX) == (b->at[1] == SL_NO_INDEX) &&
           (a->at[2] == SL_NO_INDEX) == (b->at[2] == SL_NO_INDEX);
}

static sl_status read_corners(reader *r, char *at, uint32_t *count) {
    sl_corner corner, first = {{0}};
    sl_status status = SL_OK;
    for (*count = 0; status == SL_OK && !sl_is_line_end(at);) {
        status = read_corner(r, &at, &corner);
        if (status == SL_OK) status = memory_if_not(r, sl_polygons_add_corner(&r->polygons, corner));
        if ((*count)++ == 0) first = corner;
        if (status != SL_OK || have_the_same(&first, &corner)) continue;
        return sl_fail(r->lines.error, SL_ERROR_INPUT,
                       "%s:%lu: expected face corners that all have the same, as in 1/1 2/2 3/3: corner %u "
                       "has other indices than the first",
                       r->lines.path, r->lines.line, *count);
    }
    return status;
}

/* Returns where in the model the object of the faces to come is; it is made for its first face. */
static sl_status find_object(reader *r, uint32_t *index) {
    sl_status status = SL_OK;
    while (r->object_count < r->objects.count) {
        if (!sl_make_room(&r->object_index, r->object_count, &r->object_room, sizeof *r->object_index))
            return sl_fail_memory(r->lines.error, r->lines.path);
        r->object_index[r->object_count++] = SL_NO_INDEX;
    }
    uint32_t *known = &r->object_index[r->object];
    if (*known == SL_NO_INDEX)
        status = sl_model_add_object(r->model, r->objects.name[r->object], known, r->lines.error);
    *index = *known;
    return status;
}

static sl_status read_face(reader *r, char *at) {
    uint32_t count, object = 0;
    sl_status status = read_corners(r, at, &count);
    if (status != SL_OK) return status;
    if (count < 3) {
        r->polygons.corner_count = 0;
        if (r->short_faces++ == 0) r->first_short = r->lines.line;
        return SL_OK;
    }
    status = find_object(r, &object);
    if (status != SL_OK) return status;
    return sl_polygons_place(&r->polygons, r->lines.path, r->material, object, r->placement, r->model,
                             r->lines.error);
}

/* ---- libraries ---------------------------------------------------------------------------------------- */

/* Reads the library of that name, if there is one. */
static sl_status read_library(reader *r, const char *name, bool *exists) {
    sl_error problem;
    char *path = sl_file_beside(r->lines.path, name);
    sl_status status = memory_if_not(r, path);
    *exists = path && sl_file_exists(path);
    if (*exists) {
        r->has_library = true;
        status = sl_model_may_read(r->model, path, &problem);
        if (status != SL_OK)
            sl_fail(r->lines.error, status, "%s: names %s", r->lines.path, problem.message);
        else status = sl_model_note_file(r->model, path, r->lines.error);
        if (status == SL_OK) status = sl_obj_materials_read(&r->materials, path, r->lines.error);
    }
    sl_free(path);
    return status;
}

/* Reads one library, whose name may have blanks in it, or several up to a comment, if there is none of that
 * name. */
static sl_status read_libraries(reader *r, char *names) {
    bool exists;
    sl_status status = read_library(r, names, &exists);
    if (exists) return status;
    for (char *at = names, *next; status == SL_OK && !sl_is_line_end(at); at = next) {
        next = sl_word_after(at);
        *sl_word_end(at) = 0;
        status = read_library(r, at, &exists);
        if (exists || status != SL_OK) continue;
        r->lacks_library = true;
        sl_scene_warn(&r->model->scene,
                      "%s:%lu: material library '%.512s' does not exist; its materials are grey",
                      r->lines.path, r->lines.line, at);
    }
    return status;
}

/* ---- the file ----------------------------------------------------------------------------------------- */

static sl_status read_statement(reader *r, char *at) {
    char *rest = sl_word_after(at);
    for (int part = 0; part < SL_CORNER_PARTS; part++) {
        if (sl_word_is(at, kinds[part].word)) return read_value(r, (sl_corner_part)part, rest);
    }
    /* fo is an old name of the same */
    if (sl_word_is(at, "f") || sl_word_is(at, "fo")) return read_face(r, rest);
    if (sl_word_is(at, "o") || sl_word_is(at, "g"))
        return memory_if_not(r, sl_names_find(&r->objects, rest, &r->object));
    if (sl_word_is(at, "mtllib")) return read_libraries(r, rest);
    if (sl_word_is(at, "usemtl"))
        return sl_obj_materials_find(&r->materials, rest, r->lines.line, &r->material, r->lines.error);
    return SL_OK;
}

/* Warns of short faces, and of names that no library has: a file without libraries has them for others to
 * give materials to. */
static void tell_of_the_whole(const reader *r) {
    const char *path = r->lines.path;
    if (r->short_faces == 1)
        sl_scene_warn(&r->model->scene, "%s:%lu: a face of fewer than three corners is not drawn", path,
                      r->first_short);
    else if (r->short_faces)
        sl_scene_warn(&r->model->scene,
                      "%s:%lu: this face and %lu more of fewer than three corners are not drawn", path,
                      r->first_short, r->short_faces - 1);
    for (size_t i = 1; i < r->materials.count && r->has_library && !r->lacks_library; i++) {
        if (r->materials.material[i].line)
            sl_scene_warn(&r->model->scene, "%s:%lu: no material library has '%.512s'; it is grey", path,
                          r->materials.material[i].line, r->materials.names.name[i]);
    }
}

sl_status sl_obj_file_load(const char *path, const sl_affine *placement, sl_model *model, sl_error *error) {
    reader r = {.materials = {.model = model, .path = path, .first = (uint32_t)model->scene.material_count},
                .placement = placement,
                .model = model};
    char *text, *line;
    sl_status status = sl_lines_open(path, &text, &r.lines, error);
    /* the first material is that of faces that name none, and so is the first object */
    if (status == SL_OK) status = sl_obj_materials_find(&r.materials, "", 0, &r.material, error);
    if (status == SL_OK) status = memory_if_not(&r, sl_names_find(&r.objects, "defaultobject", &r.object));
    while (status == SL_OK && (line = sl_lines_next(&r.lines))) status = read_statement(&r, line);
    if (status == SL_OK) sl_obj_materials_finish(&r.materials);
    if (status == SL_OK) tell_of_the_whole(&r);
    sl_polygons_release(&r.polygons);
    sl_names_release(&r.objects);
    sl_free(r.object_index);
    sl_obj_materials_release(&r.materials);
    sl_free(text);
    return status;
}
