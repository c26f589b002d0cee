#include "scene/obj_materials.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "scene/file.h"
#include "scene/import_process.h"
#include "scene/mtl_text.h"

enum { LONGEST_TOLD = 512 /* bytes of a name in a warning */ };

static int told(size_t length) { return length < LONGEST_TOLD ? (int)length : LONGEST_TOLD; }

static void add_material(sl_obj_materials *m, const char *name, size_t length, unsigned long line) {
    const size_t room = sl_grown_capacity(m->room, m->count + 64);
    if (m->count == m->room && !sl_regrow(&m->material, m->count, room, sizeof *m->material))
        m->starved = true;
    else if (m->count == m->room) m->room = room;
    if (m->starved) return;
    m->material[m->count++] = (sl_obj_material){m->names.size, length, NULL, line};
    sl_text_add(&m->names, name, length);
    m->starved = m->names.starved;
}

/* ---- libraries ------------------------------------------------------------------------------- */

static void add_names(sl_obj_materials *m, const sl_text *library) {
    static const char word[] = "newmtl ";
    const size_t length = strlen(word);
    for (size_t byte = 0; byte < library->size;) {
        const char *at = library->data + byte, *end = memchr(at, '\n', library->size - byte);
        byte += (size_t)(end - at) + 1;
        if ((size_t)(end - at) > length && memcmp(at, word, length) == 0)
            add_material(m, at + length, (size_t)(end - at) - length, 0);
    }
}

static sl_status read_library(sl_obj_materials *m, const char *path, sl_error *error) {
    sl_text plain;
    if (!sl_file_is_below(m->model->folder, path)) return SL_OK; /* importing it says why not */
    sl_status status = sl_mtl_text_read(path, m->model, &plain, error);
    if (status != SL_OK) return status;
    add_names(m, &plain);
    if (plain.size) sl_import_add_text(m->texts, path, plain.data, plain.size);
    if (plain.size) m->readable++;
    else m->unreadable++; /* perhaps for being in UTF-16 */
    sl_text_release(&plain);
    return SL_OK;
}

/* The path of a library if there is one of that name, to be freed; else NULL. */
static sl_status find_library(const sl_obj_materials *m, const char *name, size_t length, char **path,
                              sl_error *error) {
    char copy[4096];
    *path = NULL;
    if (length == 0 || length >= sizeof copy) return SL_OK;
    memcpy(copy, name, length);
    copy[length] = 0;
    *path = sl_file_beside(m->path, copy);
    if (!*path) return sl_fail_memory(error, "a file name");
    if (sl_file_exists(*path)) return SL_OK;
    sl_free(*path);
    *path = NULL;
    return SL_OK;
}

static sl_status add_library(sl_obj_materials *m, const char *name, size_t length, bool *exists,
                             sl_error *error) {
    char *path;
    sl_status status = find_library(m, name, length, &path, error);
    *exists = path != NULL;
    if (!path) return status;
    status = read_library(m, path, error);
    sl_free(path);
    sl_text_add(&m->libraries, "mtllib ", 7);
    sl_text_add(&m->libraries, name, length);
    sl_text_add(&m->libraries, "\n", 1);
    return status;
}

static void warn_of_library(sl_obj_materials *m, unsigned long line, const char *name, size_t length) {
    m->unreadable++;
    sl_model_warn(m->model, "%s:%lu: material library '%.*s' does not exist; its materials are grey", m->path,
                  line, told(length), name);
}

/* Who gives both files another name often leaves the old one in the first. */
static sl_status take_library_of_same_name(sl_obj_materials *m, unsigned long line, const char *missing,
                                           size_t missing_length, sl_error *error) {
    const char *slash = strrchr(m->path, '/'), *name = slash ? slash + 1 : m->path;
    char same[4096];
    int length = snprintf(same, sizeof same, "%.*s.mtl", (int)(strlen(name) - strlen(".obj")), name);
    bool exists;
    sl_status status = add_library(m, same, (size_t)length, &exists, error);
    if (!exists) warn_of_library(m, line, missing, missing_length);
    if (!exists || status != SL_OK) return status;
    sl_model_warn(m->model, "%s:%lu: material library '%.*s' does not exist; '%.*s' is read in its place",
                  m->path, line, told(missing_length), missing, told((size_t)length), same);
    return SL_OK;
}

static size_t name_length(const char *at, const char *end) {
    size_t length = 0;
    while (at + length < end && at[length] != ' ' && at[length] != '\t' && at[length] != '\v') length++;
    return length;
}

/* Names between blanks, up to a comment. Where none of them is that of a file they are one name, for the
 * warning. */
static sl_status read_several(sl_obj_materials *m, unsigned long line, const char *names, const char *end,
                              sl_error *error) {
    bool exists, any = false;
    size_t length;
    sl_status status = SL_OK;
    for (const char *at = names; status == SL_OK && at < end && *at != '#'; at += length + 1) {
        length = name_length(at, end);
        status = add_library(m, at, length, &exists, error);
        any |= exists;
    }
    if (!any && status == SL_OK)
        return take_library_of_same_name(m, line, names, (size_t)(end - names), error);
    for (const char *at = names; status == SL_OK && at < end && *at != '#'; at += length + 1) {
        char *path;
        length = name_length(at, end);
        status = find_library(m, at, length, &path, error);
        if (status == SL_OK && length && !path) warn_of_library(m, line, at, length);
        sl_free(path);
    }
    return status;
}

sl_status sl_obj_materials_read(sl_obj_materials *m, unsigned long line, const char *names, size_t length,
                                sl_error *error) {
    bool exists;
    sl_status status = add_library(m, names, length, &exists, error);
    return exists || status != SL_OK ? status : read_several(m, line, names, names + length, error);
}

/* ---- names that are used --------------------------------------------------------------------- */

/* Of one statement after another that names the same material the first is remembered. */
void sl_obj_materials_use(sl_obj_materials *m, unsigned long line, const char *name, size_t length) {
    const sl_obj_material *last = m->count ? &m->material[m->count - 1] : NULL;
    if (m->starved || (last && last->line && last->length == length &&
                       memcmp(m->names.data + last->start, name, length) == 0))
        return;
    add_material(m, name, length, line);
}

/* By name, and of one name by line. */
static int compare_materials(const void *first, const void *second) {
    const sl_obj_material *a = first, *b = second;
    int order = memcmp(a->name, b->name, a->length < b->length ? a->length : b->length);
    if (order) return order;
    if (a->length != b->length) return a->length < b->length ? -1 : 1;
    return a->line < b->line ? -1 : a->line > b->line;
}

static bool are_of_one_name(const sl_obj_material *a, const sl_obj_material *b) {
    return a->length == b->length && memcmp(a->name, b->name, a->length) == 0;
}

static int compare_lines(const void *first, const void *second) {
    const sl_obj_material *a = first, *b = second;
    return a->line < b->line ? -1 : a->line > b->line;
}

/* Puts the first uses of names that no library has to the front, by line, and returns how many they are. */
static size_t find_unknown_materials(sl_obj_materials *m) {
    sl_obj_material *all = m->material, last = {0};
    size_t unknown = 0;
    for (size_t i = 0; i < m->count; i++) all[i].name = m->names.data + all[i].start;
    qsort(all, m->count, sizeof *all, compare_materials);
    /* of one name that of a library comes first, then the first use */
    for (size_t i = 0; i < m->count; i++) {
        bool seen = i > 0 && are_of_one_name(&last, &all[i]);
        last = all[i];
        if (last.line && !seen) all[unknown++] = last;
    }
    qsort(all, unknown, sizeof *all, compare_lines);
    return unknown;
}

/* A file without libraries has names for others to give materials to. */
static void warn_of_unknown_materials(sl_obj_materials *m) {
    if (!m->readable || m->unreadable || !m->count) return;
    size_t unknown = find_unknown_materials(m);
    for (const sl_obj_material *u = m->material; u < m->material + unknown; u++) {
        sl_model_warn(m->model, "%s:%lu: no material library has '%.*s'; it is grey", m->path, u->line,
                      told(u->length), u->name);
    }
}

sl_status sl_obj_materials_conclude(sl_obj_materials *m, sl_error *error) {
    if (m->starved) return sl_fail_memory(error, m->path);
    warn_of_unknown_materials(m);
    return SL_OK;
}

void sl_obj_materials_release(sl_obj_materials *m) {
    sl_text_release(&m->libraries);
    sl_text_release(&m->names);
    sl_free(m->material);
}
